//! Tests of grids, and of the checks on compact arrays from elsewhere.

extern crate std;

use super::*;
use pfront_testkit::rng::{Rng, RngExt, finite, seeded};
use std::vec;
use std::vec::Vec;

/// An interval: of any size anywhere, of some last places, or flat.
fn interval(rng: &mut impl Rng) -> (f32, f32) {
    let x = finite(rng);
    let (a, b) = match rng.random_range(0..4) {
        0 => (x, x),
        1 => (x, (0..rng.random_range(0..1000)).fold(x, |x, _| x.next_up()).min(f32::MAX)),
        2 => (x, x * (1.0 + rng.random_range(0.0..0.004))),
        _ => (x, finite(rng)),
    };
    let b = b.clamp(-f32::MAX, f32::MAX);
    (a.min(b), a.max(b))
}

/// Intervals that come close to what a float or a grid can do.
fn nasty() -> Vec<(f32, f32)> {
    let (most, least) = (f32::MAX, f32::from_bits(1));
    let ends =
        [0.0, least, f32::MIN_POSITIVE, 1e-30, 1.0, 1e5, 16_777_216.0, 1e30, most / 2.0, most];
    let ends: Vec<f32> = ends.iter().flat_map(|&x| [x, -x, x.next_down()]).collect();
    let pairs = ends.iter().flat_map(|&a| ends.iter().map(move |&b| (a.min(b), a.max(b))));
    pairs.collect()
}

/// A place in an interval.
fn within((min, max): (f32, f32), rng: &mut impl Rng) -> f32 {
    let share = rng.random_range(0.0..=1.0f32);
    (min + share * (max * 0.5 - min * 0.5) * 2.0).clamp(min, max)
}

fn on(grid: &Grid, node: &Node) -> CompactNode {
    CompactNode::new(node, grid.first(), grid.width.map(inverse_width))
}

#[test]
fn boxes_on_a_grid_contain_what_they_are_made_of() {
    let mut rng = seeded(7);
    let mut roots = nasty();
    roots.extend((0..100_000).map(|_| interval(&mut rng)));
    for (i, x) in roots.iter().enumerate() {
        let [y, z] = [roots[i * 7 % roots.len()], roots[i * 13 % roots.len()]];
        let axes = [*x, y, z];
        let root = Aabb { min: axes.map(|axis| axis.0), max: axes.map(|axis| axis.1) };
        let grid = Grid::new(&root);
        assert_eq!(Grid::read(&grid.header()).map(|grid| grid.header()), Some(grid.header()));
        let part = axes.map(|axis| {
            let (a, b) = (within(axis, &mut rng), within(axis, &mut rng));
            (a.min(b), a.max(b))
        });
        let point = part.map(|(min, _)| (min, min));
        let nodes = [axes, part, point, axes.map(|(_, max)| (max, max))].map(|axes| {
            let (min, max) = (axes.map(|axis| axis.0), axes.map(|axis| axis.1));
            Node { min, max, first: 6, count: 0 }
        });
        let small = nodes.map(|node| on(&grid, &node));
        let [a, b, c, d] = &small;
        let four = CompactNode::boxes(&grid, [a, b, c, d]);
        for (lane, (node, small)) in nodes.iter().zip(&small).enumerate() {
            let found = Aabb::from(small.bounds(&grid));
            let of_root = Aabb::from(a.bounds(&grid));
            assert_eq!(found.union(&node.aabb()), found, "{node:?} {small:?}");
            assert_eq!(of_root.union(&found), of_root);
            for k in 0..3 {
                let width = grid.width[k];
                // Corners as real numbers, which f64 holds without rounding.
                let first = f64::from(grid.offset[k]) + f64::from(TO_BITS);
                let at = |q: i32| (first + f64::from(q)) * f64::from(width);
                let [low, high] = [small.min[k], small.max[k]].map(i32::from);
                assert!(
                    f64::from(node.min[k]) < at(low + 1) && f64::from(node.max[k]) > at(high - 1)
                );
                let exact = |q: u16, x: f32| x.abs() == f32::MAX || f64::from(x) == at(q.into());
                let [low, high] = [four.min[k], four.max[k]].map(|v| v.to_array()[lane]);
                assert!(exact(small.min[k], low) && exact(small.max[k], high));
                assert!([low, high] == [found.min[k], found.max[k]]);
                // No wider than it must be.
                if width > f32::from_bits(1) {
                    let twice = 2.0 * inverse_width(width);
                    let (low, high) = (below(root.min[k], twice), above(root.max[k], twice));
                    assert!(high - low > LAST || low < -FARTHEST || high > FARTHEST);
                }
            }
        }
    }
}

#[test]
fn links_tell_leaves_from_children() {
    let grid = Grid::new(&Aabb { min: [0.0; 3], max: [1.0; 3] });
    for first in [0, 1, 7, (1 << 28) - 8] {
        for count in 1..=8 {
            let leaf = Node { first, count, min: [0.0; 3], max: [1.0; 3] };
            let small = on(&grid, &leaf);
            assert!(small.is_leaf() && small.leaf_range() == [first, count]);
        }
        let inner = Node { first: 2 * first + 2, count: 0, min: [0.0; 3], max: [1.0; 3] };
        let small = on(&grid, &inner);
        assert!(!small.is_leaf() && small.left() == inner.first);
    }
}

const POSITIONS: [[f32; 3]; 5] =
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5], [9.0, 0.1, 2.0], [9.0, 3.0, -2.0]];
const TRIANGLES: [[u32; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 3, 4]];

/// A tree of three leaves; its nodes are 0, 2, 3, 4 and 5.
fn standard() -> [Node; 6] {
    let of = |ids: &[usize]| {
        let corners = ids.iter().flat_map(|&t| TRIANGLES[t]).map(|v| POSITIONS[v as usize]);
        corners.fold(Aabb::EMPTY, |b, p| b.union(&Aabb { min: p, max: p }))
    };
    let node = |aabb: Aabb, first, count| Node { min: aabb.min, max: aabb.max, first, count };
    [
        node(of(&[0, 1, 2]), 2, 0),
        Node::EMPTY,
        node(of(&[0]), 0, 1),
        node(of(&[1, 2]), 4, 0),
        node(of(&[1]), 1, 1),
        node(of(&[2]), 2, 1),
    ]
}

#[test]
fn trees_of_any_size_are_well_formed() {
    let nodes = standard();
    let one = [Node { first: 0, count: 1, ..nodes[2] }];
    let cases: [(&[Node], &[u32]); 3] = [(&nodes, &[0, 1, 2]), (&one, &[0]), (&[], &[])];
    for (nodes, order) in cases {
        let mesh = Mesh::new(&POSITIONS, &TRIANGLES[..order.len()]).unwrap();
        Bvh::new(mesh, nodes, order, &mut [0]).unwrap();
        let mut storage = [CompactNode::default(); 8];
        let bvh = compact(mesh, nodes, order, &mut storage).unwrap();
        bvh.assert_well_formed();
        assert_eq!(
            (bvh.nodes().len(), bvh.order()),
            (if nodes.len() == 1 { 2 } else { nodes.len() }, order)
        );
    }
}

#[test]
fn storage_that_is_too_small_is_refused() {
    let mesh = Mesh::new(&POSITIONS, &TRIANGLES).unwrap();
    let nodes = standard();
    for (count, needed) in [(6, 6), (1, 2)] {
        let mut storage = vec![CompactNode::default(); needed - 1];
        let refused = compact(mesh, &nodes[..count], &[0, 1, 2], &mut storage).err();
        let error = CapacityError { buffer: "storage", needed, capacity: needed - 1 };
        assert_eq!(refused, Some(error.into()));
    }
}

#[test]
#[should_panic(expected = "index out of range")]
fn unchecked_nodes_without_a_grid_panic() {
    let mesh = Mesh::new(&POSITIONS, &TRIANGLES).unwrap();
    let _ = Bvh::new_unchecked(mesh, &[CompactNode::default()], &[0, 1, 2]);
}

/// The panic is that of `new_unchecked`, in debug builds too.
#[test]
#[should_panic(expected = "index out of range")]
fn nodes_without_a_box_panic() {
    let mesh = Mesh::new(&POSITIONS, &TRIANGLES).unwrap();
    let _ = compact(mesh, &[Node::EMPTY], &[0, 1, 2], &mut [CompactNode::default(); 2]);
}

#[test]
fn wrong_arrays_are_refused() {
    let mesh = Mesh::new(&POSITIONS, &TRIANGLES).unwrap();
    let mut nodes = [CompactNode::default(); 6];
    compact(mesh, &standard(), &[0, 1, 2], &mut nodes).unwrap();
    let after = |change: &dyn Fn(&mut Vec<CompactNode>, &mut [u32])| {
        let (mut nodes, mut order) = (nodes.to_vec(), [0, 1, 2]);
        change(&mut nodes, &mut order);
        Bvh::new(mesh, &nodes, &order, &mut [0]).map(|_| ())
    };
    assert_eq!(after(&|_, _| ()), Ok(()));
    for k in 0..3 {
        for node in [0, 2, 3, 4, 5] {
            let refused = after(&|nodes, _| nodes[node].min[k] += 2);
            assert!(matches!(refused, Err(BvhError::Box { .. })), "{node} {k} {refused:?}");
            let refused = after(&|nodes, _| nodes[node].max[k] -= 2);
            assert!(matches!(refused, Err(BvhError::Box { .. })), "{node} {k} {refused:?}");
        }
    }
    // The grid: too far, too wide, bits that mean nothing, none at all; another one.
    assert_eq!(after(&|nodes, _| nodes[1].min[1] = 0x7fff), Err(BvhError::Grid));
    assert_eq!(after(&|nodes, _| nodes[1].link |= 0x3ff), Err(BvhError::Grid));
    assert_eq!(after(&|nodes, _| nodes[1].link |= 1 << 31), Err(BvhError::Grid));
    assert_eq!(after(&|nodes, _| nodes.truncate(1)), Err(BvhError::Grid));
    let moved = after(&|nodes, _| nodes[1].min[0] += 9);
    assert!(matches!(moved, Err(BvhError::Box { .. })), "{moved:?}");
    // Children before their parent, odd or out of range; a leaf too many; a run that does not go on.
    assert_eq!(after(&|nodes, _| nodes[3].link = 2), Err(BvhError::Child { node: 3 }));
    assert_eq!(after(&|nodes, _| nodes[3].link = 6), Err(BvhError::Child { node: 3 }));
    assert_eq!(after(&|nodes, _| nodes[4].link += 16), Err(BvhError::Leaf { node: 4 }));
    assert_eq!(after(&|nodes, _| nodes[5].link += 2), Err(BvhError::Leaf { node: 5 }));
    let more = after(&|nodes, _| nodes.push(CompactNode::default()));
    assert_eq!(more, Err(BvhError::Length { array: "nodes", expected: 6, found: 7 }));
    let leaf = CompactNode { link: 5, ..nodes[0] };
    let lone = after(&|nodes, _| *nodes = [&[leaf][..], &nodes[1..3]].concat());
    assert_eq!(lone, Err(BvhError::Length { array: "nodes", expected: 2, found: 3 }));
    assert_eq!(after(&|_, order| order[2] = 1), Err(BvhError::Order { entry: 2 }));
    assert!(matches!(after(&|_, order| order.swap(0, 2)), Err(BvhError::Box { .. })));
}
