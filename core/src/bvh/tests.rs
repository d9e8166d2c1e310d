//! Tests of the checks on foreign arrays.

extern crate std;

use super::*;
use crate::bvh::{BuildOptions, BvhStorage, morton, node_bound, sah};
use crate::bvtt::{PairBvtt, Query, SelfBvtt};
use crate::{Bvh, BvhError, Mesh, Node, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::shapes::strip;
use std::sync::LazyLock;
use std::vec;
use std::vec::Vec;

/// A mesh and its BVH.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Owned {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<u32>,
}

impl Owned {
    pub(crate) fn new(soup: MeshData, leaf_size: u32, by_morton: bool) -> Self {
        let MeshData { positions, triangles } = soup;
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let n = triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let options = BuildOptions { leaf_size, ..BuildOptions::default() };
        let built = if by_morton {
            morton(mesh, &options, storage, &mut vec![0; 2 * n])
        } else {
            sah(mesh, &options, storage, &mut vec![Node::EMPTY; n])
        };
        let used = built.unwrap().nodes().len();
        nodes.truncate(used);
        Self { positions, triangles, nodes, order }
    }

    pub(crate) fn bvh(&self) -> Bvh<'_> {
        let mesh = Mesh::new_unchecked(&self.positions, &self.triangles);
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }
}

static STRIP: LazyLock<Owned> = LazyLock::new(|| Owned::new(strip(16), 2, false));

/// The check of the strip's BVH after a change to both arrays.
fn check_after(change: impl Fn(&mut Vec<Node>, &mut Vec<u32>)) -> Result<(), BvhError> {
    let Owned { positions, triangles, nodes, order } = &*STRIP;
    let mesh = Mesh::new_unchecked(positions, triangles);
    let (mut nodes, mut order) = (nodes.clone(), order.clone());
    change(&mut nodes, &mut order);
    let in_one_pass = Bvh::new(mesh, &nodes, &order, &mut [7]).map(|_| ());
    let big_scratch = Bvh::new(mesh, &nodes, &order, &mut [7; 99]).map(|_| ());
    assert_eq!(in_one_pass, big_scratch);
    in_one_pass
}

fn first_leaf(nodes: &[Node]) -> usize {
    nodes.iter().position(Node::is_leaf).unwrap()
}

#[test]
fn an_untouched_tree_is_accepted() {
    assert_eq!(check_after(|_, _| ()), Ok(()));
}

#[test]
fn a_wrong_order_is_refused() {
    assert_eq!(check_after(|_, o| o[3] = 16), Err(BvhError::Order { entry: 3 }));
    assert_eq!(check_after(|_, o| o[15] = u32::MAX), Err(BvhError::Order { entry: 15 }));
    assert_eq!(check_after(|_, o| o[9] = o[2]), Err(BvhError::Order { entry: 9 }));
    let short = BvhError::Length { array: "order", expected: 16, found: 15 };
    assert_eq!(check_after(|_, o| o.truncate(15)), Err(short));
    // A permutation, but not the one that the boxes were made for.
    assert!(matches!(check_after(|_, o| o.swap(0, 15)), Err(BvhError::Box { .. })));
}

#[test]
fn wrong_children_are_refused() {
    for first in [0, 1, 3, u32::MAX - 1, u32::MAX, 1000] {
        let found = check_after(|n, _| n[0].first = first);
        assert_eq!(found, Err(BvhError::Child { node: 0 }), "{first}");
    }
    // Both children of the root lead to the nodes below the left one.
    let twice = check_after(|n, _| n[3] = Node { first: n[2].first, ..n[3] });
    assert!(matches!(twice, Err(BvhError::Leaf { .. } | BvhError::Box { .. })), "{twice:?}");
}

#[test]
fn wrong_leaves_are_refused() {
    for (first, count) in [(1, 2), (u32::MAX, 2), (0, 9), (0, u32::MAX), (15, 2)] {
        let found = check_after(|n, _| {
            let leaf = first_leaf(n);
            n[leaf] = Node { first, count, ..n[leaf] };
        });
        assert!(matches!(found, Err(BvhError::Leaf { .. })), "{found:?}");
    }
    // One triangle less in the first leaf: the second leaf does not continue where it ends.
    assert!(
        check_after(|n, _| {
            let leaf = first_leaf(n);
            n[leaf].count -= 1;
        })
        .is_err()
    );
    // One less in the last leaf: an entry is left over.
    let last = check_after(|n, _| {
        let leaf = n.iter_mut().max_by_key(|n| if n.is_leaf() { n.first + 1 } else { 0 });
        leaf.unwrap().count -= 1;
    });
    assert!(matches!(last, Err(BvhError::Order { .. } | BvhError::Child { .. })), "{last:?}");
}

#[test]
fn wrong_boxes_are_refused() {
    for (node, axis) in [0, 2, 3, 4].into_iter().flat_map(|n| (0..3).map(move |k| (n, k))) {
        let refused = |what: &str, change: &dyn Fn(&mut f32, &mut f32)| -> Option<BvhError> {
            let found = check_after(|n, _| {
                let n = &mut n[node];
                change(&mut n.min[axis], &mut n.max[axis]);
            });
            assert!(matches!(found, Err(BvhError::Box { .. })), "{what}: {node} {axis} {found:?}");
            found.err()
        };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let named = Some(BvhError::Box { node });
            assert_eq!(refused("min", &|min, _| *min = bad), named);
            assert_eq!(refused("max", &|_, max| *max = bad), named);
        }
        refused("shrunk below its content", &|min, _| *min += 0.1);
        refused("shrunk below its content", &|_, max| *max -= 0.1);
        if node != 0 {
            refused("grown beyond its parent", &|min, _| *min -= 99.0);
            refused("grown beyond its parent", &|_, max| *max += 99.0);
        }
    }
}

#[test]
fn wrong_node_counts_are_refused() {
    let found = check_after(|n, _| n.push(Node::EMPTY));
    assert!(matches!(found, Err(BvhError::Length { array: "nodes", .. })), "{found:?}");
    let found = check_after(|n, _| n.truncate(n.len() - 1));
    assert!(matches!(found, Err(BvhError::Child { .. })), "{found:?}");
    assert_eq!(check_after(|n, _| n.clear()), Err(BvhError::Order { entry: 0 }));
    // A lone root has no slot 1.
    let MeshData { positions, triangles } = strip(2);
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    let nodes = [Node { min: [-99.0; 3], first: 0, max: [99.0; 3], count: 2 }, Node::EMPTY];
    assert!(Bvh::new(mesh, &nodes[..1], &[0, 1], &mut [0]).is_ok());
    let two = Bvh::new(mesh, &nodes, &[0, 1], &mut [0]).err();
    assert_eq!(two, Some(BvhError::Length { array: "nodes", expected: 1, found: 2 }));
}

#[test]
fn a_chain_is_accepted_up_to_the_depth_bound() {
    for (depth, accepted) in [(MAX_DEPTH, true), (MAX_DEPTH + 1, false)] {
        let triangles = vec![[0; 3]; depth + 1];
        let mesh = Mesh::new(&[[0.0; 3]], &triangles).unwrap();
        let point = Node { min: [0.0; 3], max: [0.0; 3], first: 0, count: 0 };
        let mut nodes = vec![point; 2];
        let mut parent = 0;
        for leaf in 0..depth as u32 {
            nodes[parent].first = nodes.len() as u32;
            nodes.push(Node { first: leaf, count: 1, ..point });
            parent = nodes.len();
            nodes.push(point);
        }
        nodes[parent] = Node { first: depth as u32, count: 1, ..point };
        let order: Vec<_> = (0..=depth as u32).collect();
        match Bvh::new(mesh, &nodes, &order, &mut [0; 3]) {
            Ok(bvh) => assert!(accepted && bvh.depth() == MAX_DEPTH),
            Err(error) => assert!(!accepted && matches!(error, BvhError::Child { .. })),
        }
    }
}

#[test]
fn a_graph_that_folds_onto_itself_is_refused_at_once() {
    // Each node has the same two children: 2^60 paths, if one walked them all.
    let point = Node { min: [0.0; 3], max: [0.0; 3], first: 0, count: 0 };
    let mut nodes: Vec<_> = (0..120).map(|i| Node { first: (i / 2 + 1) * 2, ..point }).collect();
    nodes.extend([Node { first: 0, count: 1, ..point }; 2]);
    let mesh = Mesh::new(&[[0.0; 3]], &[[0; 3]]).unwrap();
    let found = Bvh::new(mesh, &nodes, &[0], &mut [0]).err();
    assert_eq!(found, Some(BvhError::Leaf { node: 121 }));
}

#[test]
fn an_empty_mesh_has_an_empty_tree() {
    let mesh = Mesh::new(&[], &[]).unwrap();
    assert!(Bvh::new(mesh, &[], &[], &mut []).is_ok());
    assert!(Bvh::new(mesh, &[Node::EMPTY], &[], &mut []).is_err());
    let one = Mesh::new(&[[0.0; 3]], &[[0; 3]]).unwrap();
    let found = Bvh::new(one, &[], &[0], &mut []).err();
    assert!(matches!(found, Some(BvhError::Capacity(_))));
}

/// Indices out of range in arrays that nobody checked: a query panics, with `std` and without, rather than answer
/// with fewer pairs.
#[test]
fn unchecked_arrays_never_lose_pairs_silently() {
    let Owned { positions, triangles, nodes, order } = &*STRIP;
    let leaf = first_leaf(nodes);
    type Change = fn(&mut [Node], &mut [u32], &mut [[u32; 3]], usize);
    let changes: [(&str, Change); 6] = [
        ("a leaf of nine", |n, _, _, leaf| n[leaf].count = 9),
        ("a leaf beyond the order", |n, _, _, leaf| n[leaf].first = 15),
        ("a leaf far beyond the order", |n, _, _, leaf| n[leaf].first = u32::MAX),
        ("children out of range", |n, _, _, _| n[0].first = 1000),
        ("a triangle out of range", |_, o, _, _| o[0] = 16),
        ("a vertex out of range", |_, o, t, _| t[o[0] as usize][1] = 18),
    ];
    for (what, change) in changes {
        let (mut nodes, mut order, mut triangles) =
            (nodes.clone(), order.clone(), triangles.clone());
        change(&mut nodes, &mut order, &mut triangles, leaf);
        let bvh = Bvh::new_unchecked(Mesh::new_unchecked(positions, &triangles), &nodes, &order);
        let pair = PairBvtt::new(bvh, bvh, Pose::IDENTITY);
        let asked = std::panic::catch_unwind(|| pair.map(|query| query.count()));
        assert!(asked.is_err(), "{what}: {asked:?}");
        let asked = std::panic::catch_unwind(|| SelfBvtt::new(bvh).count());
        assert!(asked.is_err(), "{what}: {asked:?}");
    }
}
