//! Bodies of either precision that are split, against the whole body and against every two triangles.

use pfront::pfront_core::triangle::intersects_f64;
use pfront::{
    AnyPose, Body, BodyId, BuildOptions, Executor, Model, Pose, Pose64, SceneHit, SceneQuery,
};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::shapes::{sheet, sphere};

/// Places of the world, from the origin to where f32 knows a coordinate to half a metre.
const PLACES: [[f64; 3]; 4] =
    [[0.0; 3], [1000.1, -3.0, 0.25], [4096.0, 512.0, -2048.0], [500_000.1, 5_000_000.2, 300.3]];

/// The kinds of bodies whose pairs are decided in f64.
#[derive(Clone, Copy)]
enum Kind {
    /// Noise below what f32 holds.
    Noisy,
    /// A model in f64 every coordinate of which f32 holds.
    Representable,
    /// A model in f32 in a pose in f64.
    Posed,
}

/// A wavy sheet or a ball near a place, by where its vertices or its pose are.
fn body(kind: Kind, place: [f64; 3], rng: &mut impl Rng) -> (Model, AnyPose) {
    let shape = if rng.random() { sheet(6, |x, y| 0.3 * x * y) } else { sphere(6) };
    let mut noise = || rng.random_range(-0.4..0.4_f64);
    let shift = [0; 3].map(|_| noise());
    let at = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) + place[k] + shift[k]);
    let triangles = shape.triangles.clone();
    match kind {
        Kind::Noisy => {
            let positions = shape.positions.iter().map(|p| at(p).map(|x| x + 1e-9 * noise()));
            (Model::from_f64(positions.collect(), triangles).unwrap(), Pose::IDENTITY.into())
        }
        Kind::Representable => {
            let positions = shape.positions.iter().map(|p| at(p).map(|x| f64::from(x as f32)));
            (Model::from_f64(positions.collect(), triangles).unwrap(), Pose::IDENTITY.into())
        }
        Kind::Posed => {
            let place = [0, 1, 2].map(|k| place[k] + shift[k]);
            let turn = [0.1, noise(), 0.2, 0.9];
            let pose = Pose64::from_rotation_translation(turn, place);
            (Model::new(shape.positions, triangles).unwrap(), pose.into())
        }
    }
}

/// The corners of each triangle in the world.
fn corners(body: &Body) -> Vec<[[f64; 3]; 3]> {
    let (mesh, pose) = (body.model().mesh(), body.pose().to_f64());
    let position = |v: u32| match mesh.positions_f64() {
        Some(positions) => positions[v as usize],
        None => mesh.shadow()[v as usize].map(f64::from),
    };
    mesh.triangles().iter().map(|t| t.map(|v| pose.apply(position(v)))).collect()
}

/// The hits of one body with others, by triangles and the other body.
fn with(body: BodyId, hits: &[SceneHit]) -> Vec<(u32, BodyId, u32)> {
    let of = |hit: &SceneHit| match hit.bodies {
        [a, b] if a == body => Some((hit.pair.a, b, hit.pair.b)),
        [a, b] if b == body => Some((hit.pair.b, a, hit.pair.a)),
        _ => None,
    };
    hits.iter().filter_map(of).collect()
}

#[test]
fn pieces_meet_what_the_whole_body_met() {
    let (mut rng, mut met) = (seeded(11), 0);
    for round in 0..120 {
        let place = PLACES[round % 4];
        let mut scene = SceneQuery::new();
        let mut add = |kind: Kind, rng: &mut _| {
            let (model, pose) = body(kind, place, rng);
            scene.add(model, pose).unwrap()
        };
        let kinds = [Kind::Noisy, Kind::Representable, Kind::Posed];
        let first = add(kinds[rng.random_range(0..3)], &mut rng);
        let whole = add(kinds[round % 3], &mut rng);
        let others = [first, add(kinds[rng.random_range(0..3)], &mut rng)];
        let mut before = with(whole, scene.all().unwrap());
        let mut expected = Vec::new();
        for other in others {
            let own = corners(scene.body(whole).unwrap());
            for (i, p) in (0..).zip(&own) {
                for (j, q) in (0..).zip(&corners(scene.body(other).unwrap())) {
                    if intersects_f64(p, q).unwrap() {
                        expected.push((i, other, j));
                    }
                }
            }
        }
        before.sort_unstable();
        expected.sort_unstable();
        assert_eq!(before, expected, "round {round}");

        let parts = rng.random_range(1..6);
        let pieces = scene.split(whole, |triangle| triangle * 7 % parts).unwrap();
        let hits = scene.all().unwrap().to_vec();
        let mut after = Vec::new();
        for piece in &pieces {
            let old = |(t, other, u): (u32, BodyId, u32)| (piece.triangles[t as usize], other, u);
            let is_other = |hit: &(u32, BodyId, u32)| others.contains(&hit.1);
            after.extend(with(piece.body, &hits).into_iter().filter(is_other).map(old));
        }
        after.sort_unstable();
        assert_eq!(after, expected, "round {round}");
        met += expected.len();
    }
    assert!(met > 5_000, "{met}");
}

#[test]
fn pieces_keep_the_precision_and_the_options_of_the_whole() {
    let shape = sphere(5);
    let options = BuildOptions { leaf_size: 2, ..BuildOptions::default() };
    let fine =
        Executor::sequential().build(shape.positions.clone(), shape.triangles.clone(), options);
    let in_f64 = |scale: f64| {
        let positions = shape.positions.iter().map(|p| p.map(|x| f64::from(x) * scale + 1.0));
        Model::from_f64(positions.collect(), shape.triangles.clone()).unwrap()
    };
    let representable = in_f64(0.0);
    assert!(representable.is_f64() && representable.mesh().positions_f64().is_none());
    for model in [fine.unwrap(), in_f64(0.1), representable] {
        let mut scene = SceneQuery::new();
        let (is_f64, leaf_size) = (model.is_f64(), model.options().leaf_size);
        let bounds = model.bvh().aabb();
        let whole = scene.add(model, Pose::IDENTITY).unwrap();
        let pieces = scene.split(whole, |_| 0).unwrap();
        let piece = scene.body(pieces[0].body).unwrap().model();
        assert_eq!(piece.is_f64(), is_f64);
        assert_eq!(piece.options().leaf_size, leaf_size);
        assert_eq!(piece.bvh().aabb(), bounds);
    }
}
