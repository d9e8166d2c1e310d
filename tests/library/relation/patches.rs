//! Patches of contact of solids that are sets of cells, by every executor, and of solids that cross.

use crate::each_executor;
use pfront::{ContactPatch, ContactSize, Model, PairQuery, Pose, Pose64, TrianglePair};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::solids::{Blocks, Patch, map, mapped, pair, patches};

fn model(mesh: MeshData) -> Model {
    Model::new(mesh.positions, mesh.triangles).unwrap()
}

/// The whole number that a short interval holds.
fn whole([low, high]: [f64; 2]) -> usize {
    let nearest = low.midpoint(high).round();
    assert!(low <= nearest && nearest <= high && high - low < 1e-9, "{low} {high}");
    nearest as usize
}

fn as_truth(patch: &ContactPatch) -> Patch {
    Patch {
        dimension: patch.dimension,
        area: whole(patch.area),
        length: whole(patch.length),
        is_closed: patch.is_closed,
    }
}

/// Checks what a patch says of itself, and that all have each pair once.
fn check(found: &[ContactPatch], pairs: &[TrianglePair]) {
    let mut all: Vec<_> = found.iter().flat_map(|patch| patch.pairs.clone()).collect();
    all.sort_unstable();
    assert_eq!(all, pairs);
    for patch in found {
        let apart = |[i, j]: &[u32; 2]| {
            let [p, q] = [i, j].map(|&i| patch.points[i as usize]);
            (0..3).map(|k| (q[k] - p[k]).powi(2)).sum::<f64>().sqrt()
        };
        let length: f64 = patch.segments.iter().map(apart).sum();
        let [low, high] = patch.length;
        assert!(low - 1e-6 <= length && length <= high + 1e-6, "{patch:?}");
    }
}

#[test]
fn patches_of_cells_are_those_that_their_surfaces_have_in_common() {
    let mut rng = seeded(44);
    let mut query = PairQuery::new();
    let mut seen = [0; 3];
    for round in 0..3_000 {
        let solids = pair(&mut rng);
        let [a, b] = solids.each_ref().map(Blocks::cells);
        let truth = patches(&a, &b);
        let mut mesh = |solid: &Blocks| {
            let is_soup = rng.random_range(0..4) == 0;
            solid.mesh(is_soup, &mut rng)
        };
        let [mesh_a, mesh_b] = solids.each_ref().map(&mut mesh);
        let back = [0; 3].map(|_| rng.random_range(-9_i32..=9) as f32);
        let moved = mesh_b.clone().map(|p| [0, 1, 2].map(|k| p[k] - back[k]));
        let [first, second] = [mesh_a.clone(), moved].map(model);
        let pose = match round % 2 {
            0 => Pose::from_translation(back).into(),
            _ => pfront::AnyPose::from(Pose64::from_translation(back.map(f64::from))),
        };
        let found = query.patches(&first, &second, pose).unwrap();
        check(&found, query.all(&first, &second, pose).unwrap());
        let mut own: Vec<_> = found.iter().map(as_truth).collect();
        own.sort_unstable();
        assert_eq!(own, truth, "{round}");
        own.iter().for_each(|patch| seen[patch.dimension] += 1);
        let size = ContactSize::of(&found);
        assert_eq!(size.map_or(0, |size| size.patches), truth.len());
        assert_eq!(
            size.map_or(0, |size| whole(size.area)),
            truth.iter().map(|patch| patch.area).sum::<usize>()
        );

        // Skew, only measures differ.
        let (rows, _) = map(&mut rng);
        let [a, b] = [mesh_a, mesh_b].map(|mesh| model(mesh.map(|p| mapped(&rows, p))));
        let found = query.patches(&a, &b, Pose::IDENTITY).unwrap();
        check(&found, query.all(&a, &b, Pose::IDENTITY).unwrap());
        let of = |dimension, is_closed| (dimension, is_closed);
        let mut own: Vec<_> = found.iter().map(|p| of(p.dimension, p.is_closed)).collect();
        let mut truth: Vec<_> = truth.iter().map(|p| of(p.dimension, p.is_closed)).collect();
        own.sort_unstable();
        truth.sort_unstable();
        assert_eq!(own, truth, "{round}");
    }
    assert!(seen.iter().all(|&count| count > 8), "{seen:?}");
}

#[test]
fn every_executor_finds_the_same_patches() {
    let mut rng = seeded(45);
    let executors = each_executor(&[2]);
    let mut queries: Vec<_> = executors.iter().map(|e| PairQuery::new().on(e)).collect();
    for _ in 0..20 {
        let [a, b] = pair(&mut rng).map(|solid| model(solid.mesh(false, &mut rng)));
        let pose = Pose::from_translation([0.0, 0.25, 0.0]);
        let [first, rest @ ..] = &mut queries[..] else { unreachable!() };
        let expected = first.patches(&a, &b, pose).unwrap();
        for query in rest {
            assert_eq!(query.patches(&a, &b, pose).unwrap(), expected);
        }
    }
}

/// A bar through a wall, turned about itself: it enters and leaves in a square.
#[test]
fn curves_in_which_solids_cross_are_closed_and_measured() {
    let mut rng = seeded(46);
    let mut block = |size: [i32; 3], offset: [i32; 3]| {
        let blocks = [[0; 3]].into_iter().collect();
        model(Blocks { size, offset, blocks }.mesh(false, &mut rng))
    };
    let wall = block([20, 20, 2], [-10, -10, -1]);
    let bar = block([2, 2, 8], [-1, -1, -4]);
    for step in 0..40 {
        let angle = 0.05 * f64::from(step);
        let (s, c) = angle.sin_cos();
        let turned = [[c, -s, 0.0, 1.1], [s, c, 0.0, -2.3], [0.0, 0.0, 1.0, 0.3]];
        let found = PairQuery::new().patches(&wall, &bar, Pose64::new(turned)).unwrap();
        assert_eq!(found.len(), 2);
        for patch in found {
            assert!(patch.dimension == 1 && patch.is_closed && patch.area == [0.0; 2]);
            let [low, high] = patch.length;
            // The corners are rounded.
            assert!(
                low - 1e-12 <= 8.0 && 8.0 <= high + 1e-12 && high - low < 1e-10,
                "{low} {high}"
            );
        }
    }
}

/// The middle of an edge is a vertex on one side only, and a triangle without area is between: what crosses it is one curve.
#[test]
fn triangles_without_area_join_what_is_beside_them() {
    let corners =
        vec![[0.0; 3], [4.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 4.0, 0.0], [2.0, -4.0, 0.0]];
    let sheet = Model::new(corners, vec![[0, 1, 3], [0, 4, 2], [2, 4, 1], [0, 2, 1]]).unwrap();
    let blade = |p: [f32; 3], q: [f32; 3]| {
        let middle = [p[0].midpoint(q[0]), p[1].midpoint(q[1]), 1.0];
        Model::new(vec![p, q, middle], vec![[0, 1, 2]]).unwrap()
    };
    // From one side to the other, across an edge, and across the middle.
    for x in [1.0, 2.0] {
        let across = blade([x, -0.5, 0.0], [x, 0.5, 0.0]);
        let found = PairQuery::new().patches(&sheet, &across, Pose::IDENTITY).unwrap();
        let [patch] = &found[..] else { unreachable!("{found:?}") };
        let [low, high] = patch.length;
        assert!(patch.dimension == 1 && !patch.is_closed, "{patch:?}");
        assert!(low <= 1.0 && 1.0 <= high, "{patch:?}");
    }
    // Along it lengths are bounds.
    let along = blade([0.5, 0.0, 0.0], [3.5, 0.0, 0.0]);
    let found = PairQuery::new().patches(&sheet, &along, Pose::IDENTITY).unwrap();
    let [patch] = &found[..] else { unreachable!("{found:?}") };
    assert!(patch.dimension == 1 && patch.length[0] <= 3.0 && 3.0 <= patch.length[1]);
}
