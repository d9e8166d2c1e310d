//! The BVTT of one mesh with itself: each unordered pair of triangles once.
//!
//! The node (n, n) has the children (l, l), (r, r) and (l, r); a pair of different nodes branches as
//! two meshes do. Overlapping boxes of neighbours are the rule here, so the walk reaches all of
//! them; the shared-index rule decides in the leaves.

use super::{Bvtt, LeafBoxes, NodePair, TrianglePair, Visit, Work};
use crate::Bvh;
use crate::aabb::Bounds;
use crate::triangle::{Accuracy, Adjacency, intersects_in_mesh};
use core::ops::ControlFlow;
use glam::Vec3A;

/// One BVH against itself.
pub(crate) struct SelfTree<'a> {
    pub(crate) bvh: Bvh<'a>,
    pub(crate) accuracy: Accuracy,
    pub(crate) adjacency: Adjacency,
    /// Whether triangles meet as soon as their boxes do.
    pub(crate) boxes_only: bool,
}

impl Bvtt for SelfTree<'_> {
    fn root(&self) -> Option<NodePair> {
        self.bvh.root().map(|_| NodePair { a: 0, b: 0 })
    }

    #[inline]
    fn is_leaf(&self, n: NodePair) -> bool {
        self.bvh.nodes()[n.a as usize].is_leaf() && self.bvh.nodes()[n.b as usize].is_leaf()
    }

    #[inline]
    fn children(&self, n: NodePair, mut push: impl FnMut(NodePair, [&Bounds; 2])) -> u32 {
        let nodes = self.bvh.nodes();
        let (a, b) = (&nodes[n.a as usize], &nodes[n.b as usize]);
        let bounds = |i: u32| nodes[i as usize].bounds();
        let mut test = |i: u32, j: u32| {
            let (own, other) = (bounds(i), bounds(j));
            if own.overlaps(&other) {
                push(NodePair { a: i, b: j }, [&own, &other]);
            }
        };
        if n.a == n.b && !a.is_leaf() {
            // A box always overlaps itself, so one of these is a test.
            let (l, r) = (a.first, a.first + 1);
            for (i, j) in [(l, l), (l, r), (r, r)] {
                test(i, j);
            }
            return 1;
        }
        match (a.is_leaf(), b.is_leaf()) {
            (false, false) => {
                for i in [a.first, a.first + 1] {
                    test(i, b.first);
                    test(i, b.first + 1);
                }
                4
            }
            (false, true) => {
                test(a.first, n.b);
                test(a.first + 1, n.b);
                2
            }
            (true, false) => {
                test(n.a, b.first);
                test(n.a, b.first + 1);
                2
            }
            (true, true) => 0,
        }
    }

    #[inline]
    fn leaf(
        &self,
        n: NodePair,
        skip: u32,
        work: &mut Work,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<u32> {
        let nodes = self.bvh.nodes();
        let (first, second) = (&nodes[n.a as usize], &nodes[n.b as usize]);
        let (mesh, first_bounds) = (self.bvh.mesh(), first.bounds());
        let own = self.bvh.leaf_triangles(first);
        let corners = |triangle| {
            let [p, q, r] = mesh.triangle(triangle);
            [Vec3A::from_array(p), Vec3A::from_array(q), Vec3A::from_array(r)]
        };
        let boxes = LeafBoxes::new(own, &second.bounds(), corners);
        for (row, &b) in self.bvh.leaf_triangles(second).iter().enumerate() {
            let bounds = Bounds::of(&corners(b));
            if !bounds.overlaps(&first_bounds) {
                continue;
            }
            // Within one leaf, only what comes before.
            let own = if n.a == n.b { &own[..row] } else { own };
            for (column, &a) in own.iter().enumerate() {
                let before = row as u32 * first.count + column as u32;
                if !boxes.overlap(column, &bounds) || before < skip {
                    continue;
                }
                work.triangle_tests += 1;
                let (a, b) = if a < b { (a, b) } else { (b, a) };
                let meet = self.boxes_only
                    || intersects_in_mesh(mesh, a, b, self.adjacency, self.accuracy);
                if meet && visit(TrianglePair { a, b }).is_break() {
                    return ControlFlow::Break(before + 1);
                }
            }
        }
        ControlFlow::Continue(())
    }
}
