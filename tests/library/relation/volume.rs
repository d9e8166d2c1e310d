//! The volume that two solids have in common, against that of cells and against rationals.

use super::{cube, solid};
use crate::each_executor;
use pfront::{Model, PairQuery, Pose, Pose64, Relation, Solid};
use pfront_testkit::MeshData;
use pfront_testkit::oracle::overlap_volume;
use pfront_testkit::rng::seeded;
use pfront_testkit::scenes::{icosphere, torus_knot};
use pfront_testkit::shapes::pose_rows;
use pfront_testkit::solids::{pair, truth};

/// The interval holds the volume, of which flush parts have none, and is the same on every executor.
#[test]
fn the_overlap_volume_is_that_of_the_cells() {
    let mut rng = seeded(51);
    let executors = each_executor(&[2]);
    let mut queries: Vec<_> = executors.iter().map(|e| PairQuery::new().on(e)).collect();
    for round in 0..60 {
        let solids = pair(&mut rng);
        let [a, b] = solids.each_ref().map(|s| solid(s.mesh(false, &mut rng)));
        let [own, other] = solids.each_ref().map(|solid| solid.cells());
        let truth = truth(&own, &other).volume as f64;
        let found: Vec<_> = queries
            .iter_mut()
            .map(|query| query.overlap_volume(&a, &b, Pose::IDENTITY).unwrap())
            .collect();
        assert!(found.iter().all(|interval| *interval == found[0]), "{round} {found:?}");
        let [low, high] = found[0];
        assert!(low <= truth && truth <= high && high - low < 1e-7, "{round} {truth} {low} {high}");
        // Both are turned by 37 degrees, and so rounded.
        let (s, c) = 37_f64.to_radians().sin_cos();
        let turn = Pose64::new([[c, -s, 0.0, 0.1], [s, c, 0.0, 0.2], [0.0, 0.0, 1.0, 0.3]]);
        let turned = |solid: &Solid| {
            let mesh = solid.model().mesh();
            let posed = mesh.shadow().iter().map(|p| turn.apply(p.map(f64::from)));
            let model = Model::from_f64(posed.collect(), mesh.triangles().to_vec());
            Solid::new(model.unwrap()).unwrap()
        };
        let (a, b) = (turned(&a), turned(&b));
        let [low, high] = queries[0].overlap_volume(&a, &b, Pose::IDENTITY).unwrap();
        assert!(high - low < 1e-7 && low < truth + 1e-7 && high > truth - 1e-7, "{round}");
    }
}

/// The interval of two meshes.
fn interval(a: &MeshData, b: &MeshData) -> [f64; 2] {
    let [a, b] = [a, b].map(|mesh| solid(mesh.clone()));
    assert!(a.marked_pair().is_none() && b.marked_pair().is_none());
    PairQuery::new().overlap_volume(&a, &b, Pose::IDENTITY).unwrap()
}

/// A pair of curved solids that cross, with coordinates of few bits, of which rationals take less time.
fn crossing(triangles: [usize; 2], seed: u64) -> [MeshData; 2] {
    let mut rng = seeded(seed);
    let mut turned = |mesh: MeshData, reach: f32| {
        let pose = Pose::new(pose_rows(reach, &mut rng));
        mesh.map(|p| pose.apply(p).map(|x| (x * 1024.0).round() / 1024.0))
    };
    [turned(torus_knot(triangles[0]), 0.0), turned(icosphere(triangles[1]), 0.4)]
}

#[test]
fn the_overlap_volume_holds_that_of_rationals() {
    for seed in 0..4 {
        let [a, b] = crossing([64, 80], seed);
        let (truth, [low, high]) = (overlap_volume(&a, &b), interval(&a, &b));
        assert!(low <= truth && truth <= high, "{seed} {truth} {low} {high}");
        assert!(high - low < 1e-12 * truth, "{seed} {truth} {low} {high}");
    }
}

/// The number is that of the same oracle, which takes some 20 seconds and is asked if `PFRONT_VOLUME_ORACLE` is set.
#[test]
fn a_larger_volume_has_twelve_digits() {
    let [a, b] = crossing([2_000, 1_280], 9);
    let truth = match std::env::var_os("PFRONT_VOLUME_ORACLE") {
        Some(_) => dbg!(overlap_volume(&a, &b)),
        None => 1.220_253_180_030_016,
    };
    let [low, high] = interval(&a, &b);
    assert!(low <= truth && truth <= high, "{truth} {low} {high}");
    assert!(high - low < 1e-12 * truth, "{truth} {low} {high}");
}

/// A mirrored solid overlaps as its posed mesh does.
#[test]
fn mirrored_solids_have_their_volume() {
    let solid = Solid::new(cube()).unwrap();
    let pose = Pose::new([[-1.0, 0.0, 0.0, 1.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.5]]);
    let mut query = PairQuery::new();
    let [low, high] = query.overlap_volume(&solid, &solid, pose).unwrap();
    assert!(low <= 0.25 && 0.25 <= high && high - low < 1e-11, "{low} {high}");
    assert_eq!(query.relation(&solid, &solid, pose).unwrap().relation, Some(Relation::Crossing));
}
