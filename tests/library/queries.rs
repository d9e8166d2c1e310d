//! Queries over whole meshes against brute force with the exact oracle: every verb, leaf size,
//! build, page size and mode gives one and the same set.

use pfront::{
    Adjacency, BuildOptions, Executor, Model, Node, PairQuery, Pose, SceneQuery, SelfQuery,
    TrianglePair,
};
use pfront_core::bvh::{self, BvhStorage};
use pfront_core::bvh::{MAX_LEAF_SIZE, node_bound};
use pfront_core::bvtt::{self, Query};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::oracle::{pairs, self_pairs, share_a_vertex};
use pfront_testkit::rng::{ChaCha8Rng, seeded};
use pfront_testkit::shapes::{bumpy, family, pose_rows, posed, sheet, sphere, tangle, union};
use std::ops::ControlFlow;
use std::sync::Arc;

const PAGES: [usize; 5] = [1, 2, 3, 7, 64];

#[test]
fn spheres_in_any_pose() {
    let mut rng = seeded(1);
    for _ in 0..8 {
        assert!(pair(&sphere(12), &sphere(10), &pose(1.0, &mut rng)) > 0);
    }
    assert_eq!(pair(&sphere(8), &sphere(8), &Pose::from_translation([2.5, 0.0, 0.0])), 0);
}

#[test]
fn a_mesh_that_a_pose_brings_into_range_is_taken() {
    let shrink = Pose::new([[1e-3, 0.0, 0.0, 0.0], [0.0, 1e-3, 0.0, 0.0], [0.0, 0.0, 1e-3, 0.0]]);
    for size in [2e38, f32::MAX] {
        let scaled = |soup: MeshData, by: f32| soup.map(|p| p.map(|x| x * by));
        let (near, large) = (scaled(sphere(12), 0.6e-3 * size), scaled(tilted(), size));
        let found = pair(&near, &large, &shrink);
        assert!(found > 0, "{size:e}");
        let mut scene = SceneQuery::new();
        for (soup, pose) in [(near, Pose::IDENTITY), (large, shrink)] {
            let model = Model::new(soup.positions, soup.triangles).unwrap();
            scene.add(Arc::new(model), pose).unwrap();
        }
        assert_eq!(scene.count().unwrap(), found as u64, "{size:e}");
    }
}

/// A tetrahedron over the whole of −1..1.
fn tilted() -> MeshData {
    MeshData {
        positions: vec![[-1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}

#[test]
fn spheres_that_coincide_or_just_touch() {
    pair(&sphere(10), &sphere(10), &Pose::IDENTITY);
    for x in [2.0f32, 2.0f32.next_up(), 2.0f32.next_down()] {
        pair(&sphere(16), &sphere(16), &Pose::from_translation([x, 0.0, 0.0]));
    }
}

#[test]
fn sheets_on_sheets() {
    let mut rng = seeded(2);
    let flat = sheet(8, |_, _| 0.0);
    let wavy = bumpy(11);
    pair(&flat, &flat, &Pose::IDENTITY);
    pair(&flat, &flat, &Pose::from_translation([0.1, 0.05, 0.0]));
    pair(&flat, &flat, &Pose::from_translation([0.0, 0.0, 1e-45]));
    for _ in 0..4 {
        assert!(pair(&flat, &wavy, &pose(0.2, &mut rng)) > 0);
    }
}

#[test]
fn soups_of_every_family() {
    let mut rng = seeded(3);
    for f in Family::ALL {
        let (a, b) = (family(f, 40, &mut rng), family(f, 30, &mut rng));
        pair(&a, &b, &Pose::IDENTITY);
        within(&union(&[a, b]));
    }
}

#[test]
fn soups_of_every_moderate_family_in_any_pose() {
    let mut rng = seeded(4);
    for f in Family::ALL.into_iter().filter(|f| !matches!(f, Family::Huge | Family::RawBits)) {
        let (a, b) = (family(f, 30, &mut rng), family(f, 30, &mut rng));
        let here = pose(0.5, &mut rng);
        // Turned about the origin, B stays near A whatever the scale.
        let there = MeshData { positions: posed(&b.positions, &pose(0.0, &mut rng).rows), ..b };
        pair(&a, &there, &here);
        pair(&a, &there, &pose(0.0, &mut rng));
    }
}

/// Affine maps are allowed: they magnify subnormal coordinates and what is lost on them.
#[test]
fn poses_that_stretch() {
    let mut rng = seeded(5);
    let steps = |v: f32| v * f32::from_bits(1);
    for scale in [1e-30f32, 1e-3, 1e3, 1e20, 1e36] {
        for _ in 0..3 {
            let lattice = tangle(30, 60, 3, &mut rng);
            let tiny = lattice.clone().map(|p| p.map(steps));
            let stretch = Pose::new(pose(0.0, &mut rng).rows.map(|r| r.map(|x| x * scale)));
            let near =
                MeshData { positions: posed(&tiny.positions, &stretch.rows), ..tiny.clone() };
            pair(&near, &tiny, &stretch);
            let far =
                MeshData { positions: posed(&lattice.positions, &stretch.rows), ..lattice.clone() };
            pair(&far, &lattice, &stretch);
        }
    }
}

/// A far mesh brought home: its corners are rounded much more coarsely than it is fine, so a box that
/// is posed without padding loses them.
#[test]
fn poses_that_cancel() {
    let mut rng = seeded(7);
    for offset in [10.0f32, 1e3, 1e5, 1e7] {
        for _ in 0..3 {
            let far = tangle(30, 60, 3, &mut rng).map(|p| p.map(|x| offset + x * 1e-6 * offset));
            let turn = pose_rows(0.0, &mut rng);
            let [home] = posed(&[[offset; 3]], &turn)[..] else { unreachable!() };
            let back = Pose::new([0, 1, 2].map(|i| [turn[i][0], turn[i][1], turn[i][2], -home[i]]));
            let near = MeshData { positions: posed(&far.positions, &back.rows), ..far.clone() };
            assert!(pair(&near, &far, &back) > 60);
        }
    }
}

#[test]
fn tangles_of_shared_indices() {
    let mut rng = seeded(6);
    for size in [0, 1, 2, 3, 20] {
        for vertices in [1, 3, 5, 8, 40] {
            let soup = tangle(vertices, 50, size, &mut rng);
            within(&soup);
            pair(&soup, &tangle(vertices, 40, size, &mut rng), &Pose::IDENTITY);
        }
    }
}

#[test]
fn one_mesh_with_itself() {
    assert_eq!(within(&sheet(10, |_, _| 0.0)), 0);
    // Grid lines are exact in f32 and the sheets coplanar, so that neighbours touch everywhere.
    within(&union(&[sheet(6, |_, _| 0.0), sheet(6, |_, _| 0.0), sheet(6, |x, _| x)]));
    within(&union(&[sphere(10), sphere(10).map(|[x, y, z]| [x + 0.5, y, z])]));
    let rolled = sheet(12, |_, _| 0.0).map(|[x, y, _]| [(4.0 * x).cos(), (4.0 * x).sin() * 0.9, y]);
    assert!(within(&rolled) > 0);
}

#[test]
fn nothing_and_nearly_nothing() {
    let (none, one) = (MeshData::default(), sheet(1, |_, _| 0.0));
    let bare = MeshData { positions: one.positions.clone(), triangles: vec![] };
    for empty in [&none, &bare] {
        assert_eq!(pair(empty, empty, &Pose::IDENTITY), 0);
        assert_eq!(pair(empty, &one, &Pose::IDENTITY), 0);
        assert_eq!(pair(&one, empty, &Pose::from_translation([1.0; 3])), 0);
        assert_eq!(within(empty), 0);
    }
    assert_eq!(pair(&one, &one, &Pose::IDENTITY), 4);
    let point = MeshData { positions: vec![[0.0; 3]], triangles: vec![[0; 3]; 3] };
    assert_eq!(pair(&one, &point, &Pose::IDENTITY), 6);
    assert_eq!(within(&point), 3);
}

#[test]
fn deforming_meshes_are_refitted() {
    let mut moving = model(&sheet(10, |_, _| 0.0));
    let still = model(&sphere(8));
    let (mut pair, mut own) = (PairQuery::new(), SelfQuery::new());
    for frame in 0..20 {
        let t = frame as f32 / 19.0;
        // From flat to folded over, and at last scattered so that the tree is worth nothing.
        let shape = sheet(10, |_, _| 0.0).map(|[x, y, _]| {
            let (sin, cos) = (3.0 * t * x).sin_cos();
            let scatter = if frame > 15 { (x * 977.0 + y * 331.0).sin() } else { 0.0 };
            [sin * (1.0 - 0.5 * t * y), y + scatter, 0.7 * (1.0 - cos)]
        });
        moving.set_positions(&shape.positions).unwrap();
        moving.bvh().assert_well_formed();
        let (a, b) = (moving.mesh(), still.mesh());
        let truth =
            pairs(a.positions().unwrap(), a.triangles(), b.positions().unwrap(), b.triangles());
        assert_eq!(pair.all(&moving, &still, Pose::IDENTITY).unwrap(), as_pairs(&truth));
        assert_eq!(
            own.all(&moving).unwrap(),
            as_pairs(&self_pairs(a.positions().unwrap(), a.triangles()))
        );
    }
}

/// Checks all answers about two meshes and returns how many pairs meet.
fn pair(a: &MeshData, b: &MeshData, a_from_b: &Pose) -> usize {
    let world = posed(&b.positions, &a_from_b.rows);
    let truth = as_pairs(&pairs(&a.positions, &a.triangles, &world, &b.triangles));
    let mut query = PairQuery::new();
    for (s, t) in models(a).iter().zip(&models(b)) {
        // In this order none is answered by what is kept of the one before.
        let any = query.any(s, t, a_from_b).unwrap();
        assert!(any.map_or(truth.is_empty(), |pair| truth.contains(&pair)));
        assert_eq!(query.count(s, t, a_from_b).unwrap(), truth.len() as u64);
        assert_eq!(query.all(s, t, a_from_b).unwrap(), truth);
        for stop in [1, 2, truth.len().max(1), usize::MAX] {
            stops(&truth, stop, |visit| query.visit(s, t, a_from_b, visit).unwrap());
        }
        if truth.len() < 2000 {
            let contacts = query.contacts(s, t, a_from_b).unwrap();
            assert!(contacts.iter().map(|c| &c.0).eq(&truth));
        }
        pages(&bvtt::PairBvtt::new(s.bvh(), t.bvh(), *a_from_b).unwrap(), &truth);
    }
    morton(a, |s| {
        morton(b, |t| {
            pages(&bvtt::PairBvtt::new(s, t, *a_from_b).unwrap(), &truth);
        });
    });
    truth.len()
}

/// Checks all answers about one mesh and returns how many pairs meet.
fn within(soup: &MeshData) -> usize {
    let truth = as_pairs(&self_pairs(&soup.positions, &soup.triangles));
    let neighbours = |pair: &TrianglePair| {
        let [a, b] = [pair.a, pair.b].map(|t| soup.triangles[t as usize]);
        share_a_vertex(a, b)
    };
    let apart: Vec<_> = truth.iter().copied().filter(|pair| !neighbours(pair)).collect();
    let rules = [(Adjacency::SharedIndexRule, &truth), (Adjacency::SkipNeighbours, &apart)];
    for (adjacency, truth) in rules {
        let mut query = SelfQuery::new().with_adjacency(adjacency);
        for model in &models(soup) {
            let any = query.any(model).unwrap();
            assert!(any.map_or(truth.is_empty(), |pair| truth.contains(&pair)));
            assert_eq!(query.count(model).unwrap(), truth.len() as u64);
            assert_eq!(query.all(model).unwrap(), truth);
            for stop in [1, 2, truth.len().max(1), usize::MAX] {
                stops(truth, stop, |visit| query.visit(model, visit).unwrap());
            }
            pages(&bvtt::SelfBvtt::new(model.bvh()).with_adjacency(adjacency), truth);
        }
        morton(soup, |bvh| {
            pages(&bvtt::SelfBvtt::new(bvh).with_adjacency(adjacency), truth);
        });
    }
    truth.len()
}

fn pose(reach: f32, rng: &mut ChaCha8Rng) -> Pose {
    Pose::new(pose_rows(reach, rng))
}

/// The oracle's pairs as the library writes them.
fn as_pairs(truth: &[(u32, u32)]) -> Vec<TrianglePair> {
    truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect()
}

fn model(soup: &MeshData) -> Model {
    Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap()
}

/// The mesh with every leaf size.
fn models(soup: &MeshData) -> Vec<Model> {
    let build = |leaf_size| {
        let options = BuildOptions { leaf_size, ..BuildOptions::default() };
        let (positions, triangles) = (soup.positions.clone(), soup.triangles.clone());
        let model = Executor::sequential().build(positions, triangles, options).unwrap();
        model.bvh().assert_well_formed();
        model
    };
    (1..=MAX_LEAF_SIZE).map(build).collect()
}

/// The other build, in the core's own way.
fn morton(soup: &MeshData, ask: impl FnOnce(pfront::Bvh<'_>)) {
    let n = soup.triangles.len();
    let mesh = pfront::Mesh::new(&soup.positions, &soup.triangles).unwrap();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let mut scratch = vec![0; 2 * n];
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let bvh = bvh::morton(mesh, &BuildOptions::default(), storage, &mut scratch).unwrap();
    bvh.assert_well_formed();
    ask(bvh);
}

/// A visitor that breaks after `stop` pairs has seen so many different true ones.
fn stops(
    truth: &[TrianglePair],
    stop: usize,
    ask: impl FnOnce(&mut dyn FnMut(TrianglePair) -> ControlFlow<()>) -> ControlFlow<()>,
) {
    let mut seen = Vec::new();
    let end = ask(&mut |pair| {
        seen.push(pair);
        if seen.len() == stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!(end.is_break(), seen.len() == stop);
    assert_eq!(seen.len(), stop.min(truth.len()));
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), stop.min(truth.len()), "a pair came twice");
    assert!(superset(truth, &seen));
}

/// Pages of every capacity together are the truth, full but for the last.
fn pages(query: &impl Query, truth: &[TrianglePair]) {
    for capacity in PAGES {
        let mut page = vec![TrianglePair::default(); capacity];
        let (mut cursor, mut all) = (query.start(), Vec::new());
        while !cursor.is_done() {
            let n = query.page(&mut cursor, &mut page);
            assert!(n == capacity || cursor.is_done(), "a page of {n} with more to come");
            all.extend_from_slice(&page[..n]);
        }
        assert_eq!(query.page(&mut cursor, &mut page), 0);
        all.sort_unstable();
        assert_eq!(all, truth, "capacity {capacity}");
    }
}

/// Whether the sorted `all` contains the sorted `part`.
fn superset(all: &[TrianglePair], part: &[TrianglePair]) -> bool {
    let mut all = all.iter();
    part.iter().all(|pair| all.any(|other| other == pair))
}
