//! Triangles far away from the others: what queries then cost, and whether the quality tells.

use super::*;
use crate::bvh::*;
use crate::bvtt::{PairBvtt, Query, SelfBvtt};
use crate::pose::Pose;
use core::ops::ControlFlow::Continue;
use pfront_testkit::rng::seq::SliceRandom;
use pfront_testkit::shapes::{sphere, union};

/// A sphere with bumps.
fn ball() -> MeshData {
    sphere(60).map(|[x, y, z]| {
        let r = 1.0 + 0.08 * ((9.0 * x).sin() * (8.0 * y).cos() + (11.0 * z).sin());
        [x * r, y * r, z * r]
    })
}

/// Box tests of a ball against itself moved aside, by SAH and in Morton order.
fn box_tests(MeshData { positions, triangles }: &MeshData) -> [f64; 2] {
    let mesh = Mesh::new(positions, triangles).unwrap();
    let mut tests = vec![];
    with_builds(mesh, 8, |_, bvh| {
        bvh.assert_well_formed();
        let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 0.3])).unwrap();
        let mut cursor = query.start();
        let _ = query.visit(&mut cursor, |_| Continue(()));
        tests.push(cursor.work.box_tests as f64);
    });
    [tests[0], tests[1]]
}

/// A stray decides where the borders of cells cut the ball: few cuts are bad, so the median over strays is bounded.
#[test]
fn morton_order_usually_survives_strays() {
    for in_order in [true, false] {
        let mut rng = seeded(9);
        let mut body = ball();
        if !in_order {
            body.triangles.shuffle(&mut rng);
        }
        let [alone_by_sah, alone_by_morton] = box_tests(&body);
        assert!(alone_by_morton < 1.5 * alone_by_sah, "{alone_by_morton} {alone_by_sah}");
        for (strays, extents) in
            [(1, 4e3), (1, 1e2), (1, 1e4), (100, 1e2), (100, 1e4), (10_000, 1e2), (10_000, 1e4)]
        {
            let mut ratios = [0; 9].map(|_| {
                let stray = |_| {
                    let [x, y, z] = point(4.0 * extents, &mut rng);
                    [[x, y, z], [x + 1.0, y, z], [x, y + 1.0, z]]
                };
                let mut all = union(&[body.clone(), MeshData::of((0..strays).map(stray))]);
                if !in_order {
                    all.triangles.shuffle(&mut rng);
                }
                let [by_sah, by_morton] = box_tests(&all);
                by_morton / by_sah
            });
            ratios.sort_by(f64::total_cmp);
            // Half as much again as Morton order costs alone.
            assert!(
                ratios[4] <= 1.5 * alone_by_morton / alone_by_sah,
                "{strays} strays, {extents} extents, in order {in_order}: {ratios:?}"
            );
        }
    }
}

#[test]
fn quality_notices_what_queries_do_though_one_body_is_far_away() {
    let mut rng = seeded(3);
    for far in [None, Some(1e4), Some(1e6)] {
        let mut centres: Vec<_> = (0..3000).map(|_| point(2.0, &mut rng)).collect();
        if let Some(far) = far {
            centres[0] = [0.0, -far, 0.0];
        }
        let corners = |centres: &[[f32; 3]]| -> Vec<_> {
            centres.iter().flat_map(|c| [-0.02, 0.02].map(|half| c.map(|x| x + half))).collect()
        };
        let diagonals: Vec<_> = (0..3000).map(|i| [2 * i, 2 * i + 1, 2 * i + 1]).collect();
        let before = corners(&centres);
        let mesh = Mesh::new(&before, &diagonals).unwrap();
        with_builds(mesh, 2, |build, bvh| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let mut after = |centres: &[[f32; 3]]| {
                let corners = corners(centres);
                let mesh = mesh.with_positions(&corners).unwrap();
                let now = refit(mesh, &mut nodes, order, Refit::default()).unwrap();
                let query = SelfBvtt::new(Bvh::new_unchecked(mesh, &nodes, order)).boxes_only();
                let mut cursor = query.start();
                let _ = query.visit(&mut cursor, |_| Continue(()));
                (now / quality(&bvh), cursor.work.box_tests as f32)
            };
            let (_, tests) = after(&centres);
            let mut centres = centres.clone();
            if far.is_some() {
                // Farther still is no reason to rebuild.
                centres[0] = centres[0].map(|x| 10.0 * x);
                let farther = after(&centres).0;
                assert!(farther < 1.01, "{build}, {far:?}: {farther}");
            }
            centres[1..].shuffle(&mut rng);
            let (ratio, more) = after(&centres);
            assert!(more > 20.0 * tests, "{build}, {far:?}: {more} of {tests}");
            assert!(ratio > 10.0 * REBUILD_RATIO, "{build}, {far:?}: {ratio}");
        });
    }
}
