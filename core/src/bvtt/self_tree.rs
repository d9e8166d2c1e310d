//! The BVTT of one mesh with itself: each unordered pair of triangles once.
//!
//! The node (n, n) has the children (l, l), (r, r) and (l, r); a pair of different nodes branches as
//! two meshes do. Overlapping boxes of neighbours are the rule here, so the walk reaches all of
//! them; the shared-index rule decides in the leaves.

use super::{
    Blocks, Bvtt, NodePair, Pairs, Progress, TrianglePair, Visit, after, decide, family_pairs, meet,
};
use crate::Bvh;
use crate::aabb::Bounds;
use crate::bvh::Layout;
use crate::index::at;
use crate::one_ring::OneRing;
use crate::simd::{LANES, Simd};
use crate::transform::InPlace;
use crate::triangle::{Accuracy, Adjacency, Inexact, intersects_in_mesh};
use core::ops::ControlFlow;

/// One BVH against itself.
pub(crate) struct SelfTree<'a, L: Layout> {
    pub(crate) bvh: Bvh<'a, L>,
    pub(crate) accuracy: Accuracy,
    pub(crate) inexact: Option<Inexact>,
    pub(crate) adjacency: Adjacency,
    /// What is known of the triangles about each vertex, or nothing.
    pub(crate) fans: &'a [OneRing],
    /// Whether triangles meet as soon as their boxes do.
    pub(crate) boxes_only: bool,
}

impl<L: Layout> Bvtt for SelfTree<'_, L> {
    fn root(&self) -> Option<NodePair> {
        self.bvh.root().map(|_| NodePair { a: 0, b: 0 })
    }

    #[inline]
    fn is_leaf(&self, n: NodePair) -> bool {
        self.bvh.node(n.a).is_leaf() && self.bvh.node(n.b).is_leaf()
    }

    #[inline]
    fn children(&self, n: NodePair, mut push: impl FnMut(NodePair, [&Bounds; 2])) -> u32 {
        let bvh = &self.bvh;
        let (a, b) = (bvh.node(n.a), bvh.node(n.b));
        let bounds = |i: u32| bvh.bounds(bvh.node(i));
        let mut test = |i: u32, j: u32| {
            let (own, other) = (bounds(i), bounds(j));
            if own.overlaps(&other) {
                push(NodePair { a: i, b: j }, [&own, &other]);
            }
        };
        if n.a == n.b && !a.is_leaf() {
            // A box always overlaps itself, so one of these is a test.
            let (l, r) = (a.left(), a.left() + 1);
            for (i, j) in [(l, l), (l, r), (r, r)] {
                test(i, j);
            }
            return 1;
        }
        match (a.is_leaf(), b.is_leaf()) {
            (false, false) => {
                for i in [a.left(), a.left() + 1] {
                    test(i, b.left());
                    test(i, b.left() + 1);
                }
                4
            }
            (false, true) => {
                test(a.left(), n.b);
                test(a.left() + 1, n.b);
                2
            }
            (true, false) => {
                test(n.a, b.left());
                test(n.a, b.left() + 1);
                2
            }
            (true, true) => 0,
        }
    }

    #[inline(always)]
    fn grandchildren(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32 {
        let a = self.bvh.family(n.a);
        if n.a == n.b {
            // Each with itself and those before it.
            family_pairs([&a, &a], |row| (2 << row) - 1, push);
            return a.len() * (a.len() - 1) / 2;
        }
        let b = self.bvh.family(n.b);
        let lanes = a.lanes();
        family_pairs([&a, &b], |_| lanes, push);
        a.len() * b.len()
    }

    #[inline(always)]
    fn leaf<S: Simd>(
        &self,
        n: NodePair,
        [kept_a, kept_b]: &mut [Blocks; 2],
        progress: &mut Progress,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        let mesh = self.bvh.mesh();
        let (a, b) = (self.bvh.node(n.a), self.bvh.node(n.b));
        let (own, others) = (self.bvh.leaf_triangles(a), self.bvh.leaf_triangles(b));
        let first = kept_a.get::<S>(n.a, mesh, own, &InPlace, self.fans);
        let second = kept_b.get::<S>(n.b, mesh, others, &InPlace, self.fans);
        let bounds = self.bvh.bounds(a);
        let allowed = if n.a == n.b { after(progress.skip) & BEFORE } else { after(progress.skip) };
        let pairs = if self.boxes_only {
            let tested = first.boxes::<S>(second, &bounds, allowed);
            Pairs { tested, left: tested, neighbours: 0 }
        } else {
            first.pairs::<S, true>(second, &bounds, allowed)
        };
        decide(pairs, progress, |bit| {
            let (i, j) = (bit % LANES as u32, bit / LANES as u32);
            let (t, u) = (*at(own, i), *at(others, j));
            let (a, b) = (t.min(u), t.max(u));
            let meet = if self.boxes_only {
                true
            } else if pairs.neighbours >> bit & 1 == 0 || !first.share_vertex(i, second, j) {
                meet(first, i, second, j, self.inexact)
            } else {
                intersects_in_mesh(mesh, a, b, self.adjacency, self.accuracy)
            };
            if meet { visit(TrianglePair { a, b }) } else { ControlFlow::Continue(()) }
        })
    }
}

/// Pairs of a leaf with itself, each once: of triangle j with those before it.
const BEFORE: u64 = 0x7f3f_1f0f_0703_0100;
