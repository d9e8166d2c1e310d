//! Tests of every build.

extern crate std;

mod in_parts;
mod in_steps;
mod moved;
mod outliers;

use super::*;
use crate::bvh::MAX_DEPTH;
use crate::bvh::*;
use crate::{Bvh, Mesh};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use pfront_testkit::shapes::{point, sheet};
use std::prelude::v1::*;
use std::{format, vec};

fn points(centres: impl IntoIterator<Item = [f32; 3]>) -> MeshData {
    MeshData::of(centres.into_iter().map(|c| [c; 3]))
}

fn random(triangles: usize, size: f32) -> MeshData {
    let mut rng = seeded(7);
    MeshData::of((0..triangles).map(|_| [0; 3].map(|_| point(size, &mut rng))))
}

fn meshes() -> Vec<(&'static str, MeshData)> {
    let unit = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let max = f32::MAX;
    let corners = [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -max } else { max }));
    let triples = (0..33).map(|t| [0, 1, 2].map(|k| corners[(3 * t + k) % 8]));
    let scaled = |i: i32| unit.map(|p| p.map(|x| x * 2_f32.powi(i)));
    let duplicates = MeshData { positions: unit.into(), triangles: vec![[0, 1, 2]; 1000] };
    vec![
        ("empty", MeshData::default()),
        ("one", MeshData::of([unit])),
        ("two", MeshData::of([unit; 2])),
        ("duplicates", duplicates),
        ("coincident points", points([[3.0, -2.0, 1e-3]; 500])),
        ("collinear", points((0..700).map(|i| [i as f32, 2.0 * i as f32, 0.0]))),
        ("along an axis", points((0..700).map(|i| [0.0, i as f32, 0.0]))),
        ("powers of two", points((-149..128).map(|i| [2_f32.powi(i), 0.0, 0.0]))),
        ("powers on a diagonal", points((-149..128).map(|i| [2_f32.powi(i); 3]))),
        ("nested", MeshData::of((-60..60).map(scaled))),
        ("grid", sheet(20, |_, _| 0.0)),
        ("random", random(1500, 2.0)),
        ("huge", random(300, max)),
        ("extreme corners", points(corners.into_iter().cycle().take(100))),
        ("extreme triangles", MeshData::of(triples)),
        ("tiny", random(300, 1e-20)),
        ("subnormal", random(300, 1e-42)),
        ("smallest", points((0..9).map(|i| [f32::from_bits(i % 3), 0.0, 0.0]))),
        ("flat and far", random(200, 1e-3).map(|p| [p[0], 1e30, p[2]])),
    ]
}

/// Ways to run two tasks, one of them none.
fn joins() -> [&'static Join<'static>; 4] {
    [
        &|a, b| {
            a();
            b();
        },
        &|a, b| {
            b();
            a();
        },
        &|a, _| a(),
        &|a, b| {
            std::thread::scope(|scope| {
                scope.spawn(a);
                b();
            });
        },
    ]
}

/// Runs `visit` on the BVH of each build with leaves of a size; both start from dirty buffers.
fn with_builds(mesh: Mesh<'_>, leaf_size: u32, mut visit: impl FnMut(&str, Bvh<'_>)) {
    let options = BuildOptions { leaf_size, join: None };
    let count = mesh.triangles().len();
    let dirty = Node { min: [f32::NAN; 3], first: 9, max: [f32::NAN; 3], count: 9 };
    let mut nodes = vec![dirty; node_bound(count) + 3];
    let mut order = vec![u32::MAX; count + 3];
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let mut items = vec![Node::EMPTY; count];
    visit("sah", sah(mesh, &options, storage, &mut items).unwrap());
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let mut keys = vec![u64::MAX; 2 * count];
    visit("morton", morton(mesh, &options, storage, &mut keys).unwrap());
}

#[test]
fn every_build_of_every_mesh_is_well_formed() {
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        for leaf_size in 0..=9 {
            with_builds(mesh, leaf_size, |build, bvh| {
                let context = format!("{build} of {name} with leaves of {leaf_size}");
                bvh.assert_well_formed();
                assert!(bvh.depth() <= MAX_DEPTH, "{context}");
                let limit = leaf_size.clamp(1, MAX_LEAF_SIZE);
                assert!(bvh.nodes().iter().all(|node| node.count <= limit), "{context}");
                let found = quality(&bvh);
                assert!(found.is_finite() && found >= 0.0, "{context}: {found}");
            });
        }
    }
}

/// Tall triangles at x = 2^i: all planes cost about the same, and the heuristic peels off a few
/// triangles a level.
#[test]
fn sah_stops_at_the_depth_bound() {
    let corners = |x: f32| [[x, 0.0, 0.0], [x, 1e10, 0.0], [x, 0.0, 1e10]];
    let MeshData { positions, triangles } =
        MeshData::of((-149..128).map(|i| corners(2_f32.powi(i))));
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    with_builds(mesh, 1, |build, bvh| {
        bvh.assert_well_formed();
        assert!(bvh.depth() == MAX_DEPTH || build != "sah" && bvh.depth() < MAX_DEPTH, "{build}");
    });
}

#[test]
fn a_refit_restores_a_well_formed_tree() {
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let mut rng = seeded(3);
        let moved: Vec<_> = positions.iter().map(|_| point(9.0, &mut rng)).collect();
        let moved = mesh.with_positions(&moved).unwrap();
        with_builds(mesh, 2, |build, bvh| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let unmoved = refit(mesh, &mut nodes, order, Refit::default()).unwrap();
            assert_eq!(nodes, bvh.nodes(), "{build} of {name}: boxes were not tight");
            assert_eq!(unmoved, quality(&bvh), "{build} of {name}");
            let found = refit(moved, &mut nodes, order, Refit::default()).unwrap();
            assert!(found.is_finite() && found >= 0.0, "{build} of {name}: {found}");
            let refitted = Bvh::new_unchecked(moved, &nodes, order);
            refitted.assert_well_formed();
            assert_eq!(found, quality(&refitted), "{build} of {name}");
        });
    }
}

#[test]
fn the_quality_of_a_small_tree_is_what_the_definition_says() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [4.0, 0.0, 0.0], [5.0, 1.0, 1.0]];
    let mesh = Mesh::new(&corners, &[[0, 0, 1], [2, 2, 3]]).unwrap();
    // Both triangles meet the root, and each its own leaf. The half-area of the root is that of 3.7 triangles, but
    // there are only two.
    with_builds(mesh, 1, |_, bvh| assert_eq!(quality(&bvh), (2.0 * 2.0 + 1.0 + 1.0) / 2.0));
    with_builds(mesh, 2, |_, bvh| assert_eq!(quality(&bvh), 2.0 * 2.0 / 2.0));
}

#[test]
fn sah_is_better_than_morton() {
    let mut rng = seeded(5);
    let MeshData { positions, triangles } = MeshData::of((0..3000).map(|_| {
        let centre = point(1.0, &mut rng).map(|x| 8.0 * x * x * x);
        [centre; 3].map(|c| c.map(|x| x + 0.02 * rng.random::<f32>()))
    }));
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    let mut found = vec![];
    with_builds(mesh, 4, |_, bvh| found.push(quality(&bvh)));
    assert!(found[0] < found[1], "{found:?}");
}

#[test]
fn a_buffer_one_short_is_an_error_that_names_the_need() {
    let MeshData { positions, triangles } = sheet(5, |_, _| 0.0);
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    let options = BuildOptions::default();
    let run = |nodes: usize, order: usize, scratch: usize| {
        let (mut nodes, mut order) = (vec![Node::EMPTY; nodes], vec![0; order]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let by_sah = sah(mesh, &options, storage, &mut vec![Node::EMPTY; scratch]).err();
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let by_morton = morton(mesh, &options, storage, &mut vec![0; scratch]).err();
        [by_sah, by_morton].map(|e| e.map(|e| (e.buffer, e.needed, e.capacity)))
    };
    assert_eq!(run(100, 50, 100), [None; 2]);
    // No more nodes are needed than the tree has.
    assert_eq!(run(99, 50, 100), [None; 2]);
    assert_eq!(run(100, 49, 100), [Some(("order", 50, 49)); 2]);
    assert_eq!(run(100, 50, 99), [None, Some(("scratch", 100, 99))]);
    assert_eq!(run(100, 50, 49)[0], Some(("scratch", 50, 49)));
}
