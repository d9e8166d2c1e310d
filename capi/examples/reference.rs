//! The output that `engine.c` must have, found by pfront's Rust API from the same meshes.

use pfront::{BodyOptions, Model, PairQuery, Pose, SceneQuery, SelfQuery, TrianglePair};
use std::sync::Arc;

const FRAMES: u32 = 8;

fn on_circle(step: u32, of: u32) -> [f32; 2] {
    let (quarter, t) = (4 * (step % of) / of, (4 * (step % of) % of) as f32 / of as f32);
    let (x, y) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    match quarter {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

fn grid(columns: u32, rows: u32, closed: bool) -> Vec<[u32; 3]> {
    let [wide, high] = [columns, rows].map(|n| if closed { n } else { n - 1 });
    let cells = (0..wide).flat_map(|i| (0..high).map(move |j| (i, j)));
    let vertex = |i: u32, j: u32| i % columns * rows + j % rows;
    cells
        .flat_map(|(i, j)| {
            let (p, q) = (vertex(i, j), vertex(i, j + 1));
            let (r, s) = (vertex(i + 1, j), vertex(i + 1, j + 1));
            [[p, r, s], [p, s, q]]
        })
        .collect()
}

fn vertices(columns: u32, rows: u32, at: impl Fn(u32, u32) -> [f32; 3]) -> Vec<[f32; 3]> {
    (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
}

fn ring(bump: f32) -> Result<Model, pfront::Error> {
    let (columns, rows) = (40, 24);
    let points = vertices(columns, rows, |i, j| {
        let ([x, y], [across, up]) = (on_circle(i, columns), on_circle(j, rows));
        let tube = 0.4 + bump * on_circle(5 * i, columns)[0];
        let from_axis = 1.0 + tube * across;
        [x * from_axis, y * from_axis, tube * up]
    });
    Model::new(points, grid(columns, rows, true))
}

const SHEET: [u32; 2] = [48, 24];

fn roll(frame: u32) -> Vec<[f32; 3]> {
    let [columns, rows] = SHEET;
    vertices(columns, rows, |i, j| {
        let [x, y] = on_circle(i * (frame + 1), 4 * columns);
        let waves = on_circle(3 * i + j, columns);
        let radius = 1.0 + 0.02 * waves[0];
        [x * radius, y * radius, j as f32 / rows as f32 + 0.1 * frame as f32 * waves[1]]
    })
}

fn pose(frame: u32) -> Pose {
    let [x, y] = on_circle(frame, 4 * FRAMES);
    let down = 1.0 - 0.125 * frame as f32;
    Pose::new([[x, 0.0, y, 0.5], [0.0, 1.0, 0.0, 0.25], [-y, 0.0, x, down]])
}

fn hash(words: impl Iterator<Item = u32>) -> u32 {
    words.fold(2_166_136_261, |hash, word| (hash ^ word).wrapping_mul(16_777_619))
}

fn fingerprint(pairs: &[TrianglePair]) -> u32 {
    hash(pairs.iter().flat_map(|pair| [pair.a, pair.b]))
}

fn main() -> Result<(), pfront::Error> {
    let (a, b) = (Arc::new(ring(0.0)?), Arc::new(ring(0.3)?));
    let mut sheet = Model::new(roll(0), grid(SHEET[0], SHEET[1], false))?;
    let (mut pair, mut within) = (PairQuery::new(), SelfQuery::new());
    let world_from_a = Pose::from_rotation_translation([0.0, 0.0, 0.6, 0.8], [1.0, 2.0, 3.0]);
    let mut scene = SceneQuery::new();
    scene.add(a.clone(), world_from_a)?;
    let [sinking, twin] =
        [scene.add(b.clone(), world_from_a)?, scene.add(b.clone(), Pose::IDENTITY)?];
    let rolling =
        scene.add(Model::new(roll(0), grid(SHEET[0], SHEET[1], false))?, Pose::IDENTITY)?;
    let bodies: Vec<_> = scene.bodies().map(|body| body.id()).collect();
    for (entity, &body) in (0..).zip(&bodies) {
        scene.set_options(body, BodyOptions { user_data: entity, ..BodyOptions::default() })?;
    }
    scene.ignore(sinking, twin, true)?;
    for frame in 0..FRAMES {
        let contacts = pair.contacts(&a, &b, pose(frame))?;
        let segments = contacts.iter().flat_map(|(_, contact)| contact.segment).flatten();
        let segments = hash(segments.map(f32::to_bits));
        let pairs = pair.all(&a, &b, pose(frame))?;
        print!("frame {frame}: {} pairs, list {:08x}, ", pairs.len(), fingerprint(pairs));
        print!("segments {segments:08x}; ");
        sheet.set_positions(&roll(frame))?;
        let folds = within.all(&sheet)?;
        print!("sheet: {} pairs, list {:08x}; ", folds.len(), fingerprint(folds));
        scene.set_pose(sinking, world_from_a * pose(frame))?;
        scene.set_pose(twin, pose(frame))?;
        scene.set_positions(rolling, &roll(frame))?;
        scene.update()?;
        let entity = |body| scene.body(body).map(|body| body.options().user_data as u32);
        let mut words = Vec::new();
        for hit in scene.hits() {
            let [first, second] = hit.bodies;
            words.extend([entity(first)?, entity(second)?, hit.pair.a, hit.pair.b]);
        }
        println!("scene: {} hits, list {:08x}", scene.hits().len(), hash(words.into_iter()));
    }
    Ok(())
}
