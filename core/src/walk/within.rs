//! The BVTT of one mesh with itself: each unordered pair of triangles once.
//!
//! The node (n, n) has the children (l, l), (r, r) and (l, r); a pair of different nodes branches as
//! two meshes do. Overlapping boxes of neighbours are the rule here, so the walk reaches all of
//! them; the shared-index rule decides in the leaves.

use super::{Bvtt, NodePair, TrianglePair, Work};
use crate::aabb::Bounds;
use crate::triangle::{Accuracy, Adjacency, intersects_in_mesh};
use crate::{Bvh, Mesh};
use core::ops::ControlFlow;
use glam::Vec3A;

/// One BVH against itself.
pub(crate) struct SelfTree<'a> {
    pub(crate) bvh: Bvh<'a>,
    pub(crate) accuracy: Accuracy,
    pub(crate) adjacency: Adjacency,
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
    fn children(&self, n: NodePair, mut push: impl FnMut(NodePair)) -> u32 {
        let nodes = self.bvh.nodes();
        let (a, b) = (&nodes[n.a as usize], &nodes[n.b as usize]);
        let mut test = |i: u32, j: u32| {
            if nodes[i as usize].bounds().overlaps(&nodes[j as usize].bounds()) {
                push(NodePair { a: i, b: j });
            }
        };
        if n.a == n.b && !a.is_leaf() {
            let (l, r) = (a.first, a.first + 1);
            test(l, r);
            push(NodePair { a: l, b: l });
            push(NodePair { a: r, b: r });
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
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<u32> {
        let nodes = self.bvh.nodes();
        let (first, second) = (&nodes[n.a as usize], &nodes[n.b as usize]);
        let (mesh, second_bounds) = (self.bvh.mesh(), second.bounds());
        let others = self.bvh.leaf_triangles(second);
        let mut done = 0;
        for (i, &a) in self.bvh.leaf_triangles(first).iter().enumerate() {
            let bounds = triangle_bounds(mesh, a);
            // Within one leaf, only what comes after.
            let others = if n.a == n.b { &others[i + 1..] } else { others };
            if n.a != n.b && !bounds.overlaps(&second_bounds) {
                done += others.len() as u32;
                continue;
            }
            for &b in others {
                done += 1;
                if done <= skip || !triangle_bounds(mesh, b).overlaps(&bounds) {
                    continue;
                }
                work.triangle_tests += 1;
                let (a, b) = if a < b { (a, b) } else { (b, a) };
                if intersects_in_mesh(mesh, a, b, self.adjacency, self.accuracy)
                    && visit(TrianglePair { a, b }).is_break()
                {
                    return ControlFlow::Break(done);
                }
            }
        }
        ControlFlow::Continue(())
    }
}

#[inline]
fn triangle_bounds(mesh: Mesh<'_>, triangle: u32) -> Bounds {
    Bounds::of(&mesh.triangle(triangle).map(Vec3A::from_array))
}
