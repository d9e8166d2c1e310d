//! Relations of solids that are sets of cells, and the patches in which they meet, by every executor.

mod patches;
mod surface;
mod volume;

use crate::each_executor;
use pfront::{Executor, Model, PairQuery, Pose, Pose64, Relation, Solid};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::solids::{Truth, map, mapped, pair, truth};

fn solid(mesh: MeshData) -> Solid {
    Solid::new(Model::new(mesh.positions, mesh.triangles).unwrap()).unwrap()
}

fn lattice_pair(rng: &mut pfront_testkit::rng::ChaCha8Rng) -> ([MeshData; 2], Truth) {
    let solids = pair(rng);
    let (rows, _) = map(rng);
    let meshes = solids.each_ref().map(|solid| {
        let is_soup = rng.random_range(0..4) == 0;
        solid.mesh(is_soup, rng).map(|p| mapped(&rows, p))
    });
    let [a, b] = solids.each_ref().map(|solid| solid.cells());
    (meshes, truth(&a, &b))
}

#[test]
fn every_executor_tells_the_relation_of_the_cells() {
    let mut rng = seeded(47);
    let executors = each_executor(&[2]);
    let mut queries: Vec<_> = executors.iter().map(|e| PairQuery::new().on(e)).collect();
    for round in 0..60 {
        let (meshes, truth) = lattice_pair(&mut rng);
        let [a, b] = meshes.map(solid);
        for query in &mut queries {
            let found = query.relation(&a, &b, Pose::IDENTITY).unwrap();
            let word = found.relation.map(Relation::as_str);
            assert_eq!((word, found.meets), (Some(truth.word), truth.meets), "{round}");
        }
    }
}

/// In poses that round, a solid is what its posed positions say.
#[test]
fn rounded_solids_are_solids_of_their_posed_positions() {
    let mut rng = seeded(48);
    let mut query = PairQuery::new();
    for round in 0..300 {
        let ([a, mesh], _) = lattice_pair(&mut rng);
        let (s, c) = [(0.6, 0.8), (0.1_f32.sin(), 0.1_f32.cos()), (1.0, 0.0)][round % 3];
        let by = [0; 3].map(|_| rng.random_range(-4..=4) as f32);
        let pose = Pose::new([[c, -s, 0.0, by[0]], [s, c, 0.0, by[1]], [0.0, 0.0, 1.0, by[2]]]);
        let posed = mesh.clone().map(|p| pose.apply(p));
        let Ok(posed) = Solid::new(Model::new(posed.positions, posed.triangles).unwrap()) else {
            continue;
        };
        let (a, b) = (solid(a), solid(mesh));
        let expected = query.relation(&a, &posed, Pose::IDENTITY).unwrap();
        let found = query.relation(&a, &b, pose).unwrap();
        assert_eq!((found.relation, found.meets), (expected.relation, expected.meets), "{round}");
        let in_f64 = query.relation(&a, &b, Pose64::from(pose)).unwrap();
        assert!(in_f64.relation.is_some(), "{round}");
    }
}

#[test]
fn solids_apart_are_near_within_the_distance() {
    let mut rng = seeded(49);
    let unit =
        pfront_testkit::solids::Blocks { size: [1; 3], offset: [0; 3], blocks: [[0; 3]].into() };
    let cube = solid(unit.mesh(false, &mut rng));
    let beside = Pose::from_translation([1.25, 0.0, 0.0]);
    let relation = |d: f32, pose| {
        let mut query = PairQuery::new().within(d).unwrap();
        query.relation(&cube, &cube, pose).unwrap().relation
    };
    assert_eq!(relation(0.25, beside), Some(Relation::Near));
    assert_eq!(relation(0.125, beside), Some(Relation::Apart));
    assert_eq!(relation(0.25, Pose::IDENTITY), Some(Relation::Equal));
}

/// An assembly of flush parts, turned by 37 degrees: of all that rounding makes cross, only the true clash is above a tolerance.
#[test]
fn the_check_of_a_turned_assembly_finds_its_one_clash() {
    use pfront::{Allowed, SceneQuery};
    use pfront_testkit::solids::Blocks;
    use std::sync::Arc;
    let mut rng = seeded(52);
    let (s, c) = 37_f32.to_radians().sin_cos();
    let turn = Pose::new([[c, -s, 0.0, 0.1], [s, c, 0.0, 0.2], [0.0, 0.0, 1.0, 0.3]]);
    let mut blocks = |size: [i32; 3], offset: [i32; 3]| {
        Blocks { size, offset, blocks: [[0; 3]].into() }.mesh(false, &mut rng)
    };
    // Rows of cubes of edge 4 that lie flush, every other by 1 farther, a peg in a hole of a plate, and equal parts; the last part clashes by 1.
    let mut parts: Vec<_> =
        (0..290).map(|i| blocks([4; 3], [4 * (i % 10) + i / 10 % 2, 4 * (i / 10), 0])).collect();
    let hole: std::collections::BTreeSet<_> = pfront_testkit::solids::cells_of_box([3, 3, 2])
        .filter(|&[x, y, _]| [x, y] != [1, 1])
        .collect();
    parts.push(
        Blocks { size: [2; 3], offset: [0, 0, 20], blocks: hole }.mesh(false, &mut seeded(3)),
    );
    parts.push(blocks([2, 2, 4], [2, 2, 20]));
    parts.push(blocks([2; 3], [0, 0, 40]));
    parts.push(blocks([2; 3], [0, 0, 40]));
    parts.push(blocks([6; 3], [20, 0, 40]));
    parts.push(blocks([2; 3], [22, 2, 42]));
    let clash = parts.len();
    parts.push(blocks([4; 3], [0, 0, 3]).map(|[x, y, z]| [x + 0.5, y + 0.5, z]));
    for executor in each_executor(&[2]).into_iter().take(2) {
        let mut scene = SceneQuery::new().on(&executor);
        let mut ids = Vec::new();
        for part in &parts {
            let part = part.clone().map(|p| turn.apply(p));
            let model = Model::new(part.positions, part.triangles).unwrap();
            ids.push(scene.add(Arc::new(model), Pose::IDENTITY).unwrap());
        }
        let nested = vec![Relation::Equal, Relation::AInB, Relation::BInA];
        let mut allowed = Allowed { overlap_volume: 1e-2, ..Allowed::default() };
        allowed.relations.extend(nested);
        let report = scene.check(&allowed).unwrap();
        assert!(report.refused.is_empty());
        let crossing = report.pairs.iter().filter(|p| p.relation == Some(Relation::Crossing));
        assert!(crossing.count() > 100, "rounding makes flush parts cross");
        let clashes: Vec<_> = report.pairs.iter().filter(|pair| !pair.is_allowed).collect();
        assert!(clashes.iter().all(|pair| pair.bodies[1] == ids[clash]), "{clashes:?}");
        let volume: f64 = clashes.iter().map(|p| p.overlap_volume.unwrap()[0]).sum();
        assert_eq!(clashes.len(), 3, "{clashes:?}");
        assert!((volume - 15.75).abs() < 1e-3, "{volume}");
        let of = |relation| report.pairs.iter().filter(|p| p.relation == Some(relation)).count();
        assert_eq!([of(Relation::Equal), of(Relation::BInA)], [1, 1]);
    }
}

fn cube() -> std::sync::Arc<Model> {
    use pfront_testkit::solids::Blocks;
    let blocks = Blocks { size: [1; 3], offset: [0; 3], blocks: [[0; 3]].into() };
    let mesh = blocks.mesh(false, &mut seeded(54));
    std::sync::Arc::new(Model::new(mesh.positions, mesh.triangles).unwrap())
}

/// Volumes and distances of a check are those of the world, whatever the poses; mirrored bodies are solids too.
#[test]
fn a_check_measures_in_the_world() {
    use pfront::{Allowed, SceneQuery};
    let scaled = |[x, y, z]: [f32; 3], s: [f32; 3]| {
        Pose::new([[s[0], 0.0, 0.0, x], [0.0, s[1], 0.0, y], [0.0, 0.0, s[2], z]])
    };
    for flip in [1.0, -1.0] {
        let size = [10.0 * flip, 20.0, 5.0];
        let mut scene = SceneQuery::new();
        scene.within(0.5).unwrap();
        let first = scene.add(cube(), scaled([0.0; 3], size)).unwrap();
        let other = scene.add(cube(), scaled([9.0 * flip, 0.0, 0.0], size)).unwrap();
        let near = scene.add(cube(), scaled([0.0, 20.25, 0.0], size)).unwrap();
        let report = scene.check(&Allowed::default()).unwrap();
        let of = |two| report.pairs.iter().find(|pair| pair.bodies == two).unwrap();
        let crossing = of([first, other]);
        assert_eq!(crossing.relation, Some(Relation::Crossing));
        let [low, high] = crossing.overlap_volume.unwrap();
        assert!(low <= 100.0 && 100.0 <= high && high - low < 1e-8, "{low} {high}");
        let place = crossing.place.unwrap();
        assert!(place[0] * f64::from(flip) >= 8.999 && place[1] <= 20.0, "{place:?}");
        let beside = of([first, near]);
        assert_eq!(beside.relation, Some(Relation::Near));
        let [low, high] = beside.gap.unwrap();
        assert!(low <= 0.25 && 0.25 <= high && high - low < 1e-5, "{low} {high}");
        assert!(!crossing.is_allowed && !beside.is_allowed && !report.is_allowed());
        let relations = vec![Relation::Near, Relation::Apart];
        let most = Allowed { relations, overlap_volume: 100.001, with_contacts: true };
        let report = scene.check(&most).unwrap();
        assert!(report.is_allowed());
        // The four sides of the overlap are flush, and its ends are their outline; the relative pose is rounded.
        let size = report.pairs.iter().find_map(|pair| pair.contact).unwrap();
        for ([low, high], expected) in [(size.area, 50.0), (size.length, 100.0)] {
            assert!((low - expected).abs() < 1e-9 && (high - expected).abs() < 1e-9, "{size:?}");
            assert!(low <= high);
        }
        assert_eq!((size.dimension, size.patches), (2, 1));
        assert_eq!(report.pairs.iter().filter(|pair| pair.contact.is_some()).count(), 1);
    }
}

/// A body that is no solid is told with its edge, and its pairs have no relation and are not allowed.
#[test]
fn a_check_refuses_open_bodies() {
    use pfront::{Allowed, NotSolid, SceneQuery};
    let mesh = cube();
    let triangles = mesh.mesh().triangles()[1..].to_vec();
    let open = Model::new(mesh.mesh().shadow().to_vec(), triangles).unwrap();
    let mut scene = SceneQuery::new();
    scene.add(cube(), Pose::IDENTITY).unwrap();
    let open = scene.add(std::sync::Arc::new(open), Pose::from_translation([0.5; 3])).unwrap();
    let report = scene.check(&Allowed::default()).unwrap();
    assert!(matches!(report.refused[..], [(body, NotSolid::OpenEdge { .. })] if body == open));
    let [pair] = &report.pairs[..] else { panic!("{report:?}") };
    assert!(pair.relation.is_none() && pair.meets && pair.place.is_some() && !pair.is_allowed);
}

/// A check that is cancelled says so.
#[test]
fn a_check_can_be_cancelled() {
    use pfront::{Allowed, Error, SceneQuery};
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    let flag = Arc::new(AtomicBool::new(true));
    let mut scene = SceneQuery::new().on(&Executor::sequential().with_cancel(flag));
    scene.add(cube(), Pose::IDENTITY).unwrap();
    scene.add(cube(), Pose::from_translation([0.5; 3])).unwrap();
    assert!(matches!(scene.check(&Allowed::default()), Err(Error::Cancelled)));
}
