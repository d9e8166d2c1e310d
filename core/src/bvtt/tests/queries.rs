//! Queries against the oracle: every verb, in pages, in steps of any size, and in parts.

extern crate std;

use super::super::{
    AnyBvtt, Cursor, Estimated, NodePair, PairBvtt, PosedBvh, Query, SelfBvtt, TrianglePair, Work,
};
use super::steps::in_steps;
use super::{at_one_go, push, with_certificates};
use crate::bvh::tests::Owned;
use crate::triangle::{Adjacency, Contact, contact};
use crate::{Aabb, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::oracle::{pairs, self_pairs, share_a_vertex};
use pfront_testkit::rng::seeded;
use pfront_testkit::shapes::{bumpy, pose_rows, posed, sheet, sphere, tangle, union};
use std::ops::ControlFlow;
use std::vec;
use std::vec::Vec;

/// The pairs that all forms of a query visit, in its order, after they were compared.
fn visited(query: &impl Query) -> Vec<TrianglePair> {
    let whole = at_one_go(query);
    let all = &whole.0;
    assert_eq!(query.count(), all.len() as u64);
    assert_eq!(query.any(), all.first().copied());
    for size in [1, 3, 64] {
        assert_eq!(in_pages(query, size), *all, "pages of {size}");
    }
    in_steps(query, &whole, [(0, 1), (u64::MAX, usize::MAX)]);
    for budget in [1, 2, 7, 100] {
        // A visitor breaks every third step.
        let steps = [(budget, usize::MAX), (budget, usize::MAX), (budget, 1)];
        in_steps(query, &whole, steps.into_iter().cycle());
    }
    for budget in [1, 5, 40, 1000] {
        assert_eq!(sorted(in_parts(query, budget)), sorted(all.clone()), "parts after {budget}");
        assert_eq!(sorted(in_halves(query, budget)), sorted(all.clone()), "halves at {budget}");
    }
    assert_eq!(sorted(from_children(query)), sorted(all.clone()));
    for pair in all.iter().take(20) {
        assert!(query.contact(*pair).is_some(), "{pair:?}");
    }
    whole.0
}

fn in_pages(query: &impl Query, size: usize) -> Vec<TrianglePair> {
    let (mut found, mut cursor) = (Vec::new(), query.start());
    let mut page = vec![TrianglePair::default(); size];
    assert_eq!(query.page(&mut cursor, &mut []), 0);
    while !cursor.is_done() {
        let count = query.page(&mut cursor, &mut page);
        assert!(count == size || cursor.is_done());
        found.extend(&page[..count]);
    }
    found
}

/// The first `budget` tests by one cursor, the rest by one cursor for each node pair that is pending.
fn in_parts(query: &impl Query, budget: u64) -> Vec<TrianglePair> {
    let (mut found, mut cursor) = (Vec::new(), query.start());
    let _ = query.step(&mut cursor, budget, |pair| push(&mut found, pair));
    let pending = cursor.take_pending().to_vec();
    for part in pending {
        let _ = query.visit(&mut Cursor::at(part), |pair| push(&mut found, pair));
    }
    let _ = query.visit(&mut cursor, |pair| push(&mut found, pair));
    assert!(cursor.is_done());
    found
}

/// Cursors that are split after every `budget` tests.
fn in_halves(query: &impl Query, budget: u64) -> Vec<TrianglePair> {
    let (mut found, mut cursors) = (Vec::new(), vec![query.start()]);
    let mut work = Work::default();
    while let Some(mut cursor) = cursors.pop() {
        let _ = query.step(&mut cursor, budget, |pair| push(&mut found, pair));
        let pending = cursor.pending().len();
        if let Some(half) = cursor.take_half() {
            assert_eq!(half.pending().len() + cursor.pending().len(), pending);
            assert!(!half.is_done() && half.work == Work::default());
            cursors.push(half);
        }
        if cursor.is_done() {
            work = work + cursor.work;
        } else {
            cursors.push(cursor);
        }
    }
    let mut whole = query.start();
    let _ = query.visit(&mut whole, |_| ControlFlow::Continue(()));
    assert_eq!(work, whole.work);
    found
}

/// The pairs that cursors find, one for each leaf pair that [`Query::children`] leads to.
fn from_children(query: &impl Query) -> Vec<TrianglePair> {
    let mut stack: Vec<NodePair> = query.root().into_iter().collect();
    let mut found = Vec::new();
    while let Some(n) = stack.pop() {
        let (first, mut last) = (stack.len(), None);
        let tests = query.children(n, &mut |child, boxes| {
            assert_eq!(boxes, query.boxes(child));
            assert!(last < Some((child.a, child.b)), "children ascend");
            last = Some((child.a, child.b));
            stack.push(child);
        });
        assert!(tests <= 4 && tests as usize + 2 >= stack.len() - first);
        let [mut a, mut b] = [0; 2];
        for child in &stack[first..] {
            let [below_a, below_b] = query.triangles_below(*child);
            (a, b) = (a.max(below_a), b.max(below_b));
        }
        let [most_a, most_b] = query.triangles_below(n);
        assert!(a <= most_a && b <= most_b);
        if tests == 0 {
            assert_eq!(stack.len(), first);
            let _ = query.visit(&mut Cursor::at(n), |pair| push(&mut found, pair));
        }
    }
    found
}

fn sorted(mut pairs: Vec<TrianglePair>) -> Vec<TrianglePair> {
    pairs.sort_unstable();
    pairs
}

fn as_pairs(truth: Vec<(u32, u32)>) -> Vec<TrianglePair> {
    truth.into_iter().map(|(a, b)| TrianglePair { a, b }).collect()
}

/// BVHs of a mesh with leaves of each kind.
fn trees(soup: &MeshData) -> impl Iterator<Item = Owned> {
    [(1, false), (3, true), (8, false)]
        .into_iter()
        .map(|(leaf_size, by_morton)| Owned::new(soup.clone(), leaf_size, by_morton))
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; `blocks` runs the same vector code")]
fn two_meshes_as_the_oracle() {
    let mut rng = seeded(5);
    let scenes = [
        [sphere(7), sphere(6)],
        [bumpy(9), sheet(8, |_, _| 0.0)],
        [tangle(12, 40, 2, &mut rng), tangle(12, 40, 2, &mut rng)],
        [sheet(6, |_, _| 0.0), sheet(6, |_, _| 0.0)],
    ];
    for [a, b] in scenes {
        let still = [[1.0, 0.0, 0.0, 0.25], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let far = [[1.0, 0.0, 0.0, 50.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for rows in [still, far, pose_rows(0.5, &mut rng)] {
            let (pose, moved) = (Pose { rows }, posed(&b.positions, &rows));
            let truth = as_pairs(pairs(&a.positions, &a.triangles, &moved, &b.triangles));
            for (of_a, of_b) in trees(&a).zip(trees(&b)) {
                let query = PairBvtt::new(of_a.bvh(), of_b.bvh(), pose).unwrap();
                assert_eq!(sorted(visited(&query)), truth);
            }
            // Both posed alike, in a world.
            let (of_a, of_b) = (Owned::new(a.clone(), 4, false), Owned::new(b.clone(), 4, true));
            let sides = [of_a.bvh(), of_b.bvh()].map(|bvh| PosedBvh::new(bvh, &pose).unwrap());
            let world = posed(&a.positions, &rows);
            let truth = as_pairs(pairs(&world, &a.triangles, &moved, &b.triangles));
            let query = PairBvtt::in_world(sides[0], sides[1]);
            assert_eq!(sorted(visited(&query)), truth);
            let aabb = sides[1].aabb().unwrap();
            assert!(moved.iter().all(|&p| aabb.overlaps(&Aabb { min: p, max: p })));
        }
    }
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; `blocks` runs the same vector code")]
fn one_mesh_as_the_oracle() {
    let mut rng = seeded(6);
    let crossing = union(&[bumpy(7), sphere(6), sheet(5, |x, _| 0.3 * x)]);
    for soup in [crossing, tangle(14, 60, 2, &mut rng), bumpy(6)] {
        let truth = as_pairs(self_pairs(&soup.positions, &soup.triangles));
        let n = soup.triangles.len();
        for owned in trees(&soup) {
            let mesh = owned.bvh().mesh();
            let query = SelfBvtt::new(owned.bvh());
            assert_eq!(sorted(visited(&query)), truth);

            with_certificates(mesh, |certified| {
                assert_eq!(sorted(at_one_go(&query.with_certificates(certified)).0), truth);
            });

            let skip = |p: &TrianglePair| {
                let [t, u] = [p.a, p.b].map(|i| mesh.triangles()[i as usize]);
                !share_a_vertex(t, u)
            };
            let apart: Vec<_> = truth.iter().copied().filter(skip).collect();
            let without = query.with_adjacency(Adjacency::SkipNeighbours);
            assert_eq!(sorted(at_one_go(&without).0), apart);

            let every = || (0..n as u32).flat_map(|b| (0..b).map(move |a| TrianglePair { a, b }));
            let boxes = |p: &TrianglePair| {
                let [t, u] = [p.a, p.b].map(|i| Aabb::of(&mesh.shadow_triangle(i)));
                t.overlaps(&u)
            };
            let overlapping: Vec<_> = every().filter(boxes).collect();
            let found = at_one_go(&query.boxes_only()).0;
            assert_eq!(sorted(found), sorted(overlapping.clone()));
        }
    }
}

/// The children of the root, and the box tests that it takes to find them.
fn children_of_root(query: &impl Query) -> (Vec<[u32; 2]>, u32) {
    let mut found = Vec::new();
    let tests = query.children(NodePair::ROOT, &mut |child, _| found.push([child.a, child.b]));
    (found, tests)
}

/// Four triangles in one place, each a leaf, and one leaf of all four.
#[test]
fn tests_are_counted_once_for_each_unordered_pair() {
    let soup = MeshData::of([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]; 4]);
    let (four, one) = (Owned::new(soup.clone(), 1, true), Owned::new(soup, 4, true));
    let itself = SelfBvtt::new(four.bvh());
    let [left, right] = [2, 3];
    assert_eq!(four.nodes[0].first, left);
    let ordered = vec![[left, left], [left, right], [right, right]];
    assert_eq!(children_of_root(&itself), (ordered, 1));
    assert_eq!(at_one_go(&itself).1.box_tests, 6);
    let two = PairBvtt::new(four.bvh(), one.bvh(), Pose::IDENTITY).unwrap();
    assert_eq!(children_of_root(&two), (vec![[left, 0], [right, 0]], 2));
    assert_eq!(at_one_go(&two).1.box_tests, 4);
    let four = PairBvtt::new(four.bvh(), four.bvh(), Pose::IDENTITY).unwrap();
    assert_eq!((children_of_root(&four).1, at_one_go(&four).1.box_tests), (4, 16));
}

/// The root and the leaf edge of a query, and the contact of one pair.
fn described(query: impl Query, pair: TrianglePair) -> (Option<NodePair>, f32, Option<Contact>) {
    (query.root(), query.leaf_edge(), query.contact(pair))
}

#[test]
fn a_reference_to_a_query_is_that_query() {
    let (a, b) = (Owned::new(bumpy(9), 4, false), Owned::new(sphere(6), 4, false));
    let pose = Pose { rows: pose_rows(0.2, &mut seeded(9)) };
    let query = PairBvtt::new(a.bvh(), b.bvh(), pose).unwrap();
    let pair = query.any().unwrap();
    let t = a.bvh().mesh().shadow_triangle(pair.a);
    let u = b.bvh().mesh().shadow_triangle(pair.b).map(|p| pose.apply(p));
    let edge = a.bvh().leaf_edge().max(b.bvh().leaf_edge());
    let expected = (Some(NodePair::ROOT), edge, contact(&t, &u));
    assert!(edge > 0.0 && expected.2.is_some());
    let by_reference: &_ = &query;
    assert_eq!(described(by_reference, pair), expected);
    assert_eq!(described(query, pair), expected);
    // So is one of either kind.
    let any = AnyBvtt::Pair(query);
    assert_eq!(described(any, pair), expected);
    assert_eq!(any.contact_f64(pair), query.contact_f64(pair));
    let root = NodePair::ROOT;
    assert_eq!(any.triangles_below(root), query.triangles_below(root));
    let mut children = [Vec::new(), Vec::new()];
    let [own, others] = &mut children;
    let tests = any.children(root, &mut |n, boxes| own.push((n, boxes)));
    assert_eq!(tests, query.children(root, &mut |n, boxes| others.push((n, boxes))));
    assert!(children[0] == children[1] && !children[0].is_empty());
}

#[test]
fn an_empty_mesh_meets_nothing() {
    let (empty, some) = (
        Owned::new(MeshData::default(), 4, false),
        Owned::new(MeshData::of([[[0.0; 3]; 3]]), 4, false),
    );
    for [a, b] in [[&empty, &some], [&some, &empty], [&empty, &empty]] {
        let query = PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
        assert_eq!((query.root(), query.count(), query.any()), (None, 0, None));
        assert_eq!(Query::root(&&query), None);
    }
    assert_eq!(SelfBvtt::new(empty.bvh()).count(), 0);
}
