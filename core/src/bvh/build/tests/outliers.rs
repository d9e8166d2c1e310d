//! Triangles far away from the others: what queries then cost, and whether the quality tells.

use super::*;
use crate::bvh::*;
use crate::bvtt::{PairQuery, Query, SelfQuery};
use crate::pose::Pose;
use core::ops::ControlFlow::Continue;

/// A sphere with bumps.
fn ball(side: u32) -> Soup {
    let turn = |i: u32, n: u32| i as f32 / n as f32 * core::f32::consts::TAU;
    let at = |i: u32, j: u32| j * (side + 1) + i;
    let positions = (0..(side + 1).pow(2)).map(|i| {
        let (a, b) = (turn(i % (side + 1), side), turn(i / (side + 1), 2 * side));
        let [x, y, z] = [b.sin() * a.cos(), b.sin() * a.sin(), b.cos()];
        let r = 1.0 + 0.08 * ((9.0 * x).sin() * (8.0 * y).cos() + (11.0 * z).sin());
        [x * r, y * r, z * r]
    });
    let triangles = (0..side * side).flat_map(|i| {
        let (i, j) = (i % side, i / side);
        let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
        [[p, q, r], [q, s, r]]
    });
    (positions.collect(), triangles.collect())
}

fn shuffle<T>(items: &mut [T], random: &mut Random) {
    for i in (1..items.len()).rev() {
        items.swap(i, (random.unit() * (i + 1) as f32) as usize);
    }
}

/// Box tests of a ball against itself moved aside, by SAH and in Morton order.
fn box_tests((positions, triangles): &Soup) -> [u64; 2] {
    let mesh = Mesh::new(positions, triangles).unwrap();
    let mut tests = vec![];
    with_builds(mesh, 8, |_, bvh| {
        bvh.assert_well_formed();
        let query = PairQuery::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 0.3])).unwrap();
        let mut cursor = query.start();
        let _ = query.visit(&mut cursor, |_| Continue(()));
        tests.push(cursor.work().box_tests);
    });
    [tests[0], tests[1]]
}

#[test]
#[cfg_attr(miri, ignore = "miri is slow")]
fn morton_order_survives_strays() {
    for in_order in [true, false] {
        let mut random = Random(9);
        let mut body = ball(60);
        if !in_order {
            shuffle(&mut body.1, &mut random);
        }
        let alone = box_tests(&body);
        for (strays, extents) in
            [(1, 4e3), (1, 1e2), (1, 1e4), (100, 1e2), (100, 1e4), (10_000, 1e2), (10_000, 1e4)]
        {
            let (mut positions, mut triangles) = body.clone();
            for _ in 0..strays {
                let (first, far) = (positions.len() as u32, random.point(4.0 * extents));
                positions.extend(
                    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
                        .map(|p| [0, 1, 2].map(|k| p[k] + far[k])),
                );
                triangles.push([first, first + 1, first + 2]);
            }
            if !in_order {
                shuffle(&mut triangles, &mut random);
            }
            let tests = box_tests(&(positions, triangles));
            // Morton order takes some 1.4 times the tests of SAH; strays add at most three in ten to that.
            let [of_sah, of_morton] = tests.map(|tests| tests as f32);
            let usual = alone[1] as f32 / alone[0] as f32;
            assert!(
                usual < 1.5 && of_morton <= 1.3 * usual * of_sah,
                "{strays} strays, {extents} extents, in order {in_order}: {tests:?}, alone {alone:?}"
            );
        }
    }
}

#[test]
#[cfg_attr(miri, ignore = "miri is slow")]
fn quality_notices_what_queries_do_though_one_body_is_far_away() {
    let mut random = Random(3);
    for far in [None, Some(1e4), Some(1e6)] {
        let mut centres: Vec<_> = (0..3000).map(|_| random.point(2.0)).collect();
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
                let query = SelfQuery::new(Bvh::new_unchecked(mesh, &nodes, order)).boxes_only();
                let mut cursor = query.start();
                let _ = query.visit(&mut cursor, |_| Continue(()));
                (now / quality(&bvh), cursor.work().box_tests as f32)
            };
            let (_, tests) = after(&centres);
            let mut centres = centres.clone();
            if far.is_some() {
                // Farther still is no reason to rebuild.
                centres[0] = centres[0].map(|x| 10.0 * x);
                let farther = after(&centres).0;
                assert!(farther < 1.01, "{build}, {far:?}: {farther}");
            }
            shuffle(&mut centres[1..], &mut random);
            let (ratio, more) = after(&centres);
            assert!(more > 20.0 * tests, "{build}, {far:?}: {more} of {tests}");
            assert!(ratio > 10.0 * REBUILD_RATIO, "{build}, {far:?}: {ratio}");
        });
    }
}
