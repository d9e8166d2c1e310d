//! The BVTT of two meshes.

use super::{Bvtt, LeafBoxes, NodePair, TrianglePair, Work};
use crate::aabb::Bounds;
use crate::pose::Placement;
use crate::triangle::{Accuracy, intersects};
use crate::{Bvh, Triangle};
use core::ops::ControlFlow;
use glam::Vec3A;

/// Two BVHs, the second placed in the frame of the first.
///
/// Boxes of the second are transformed as they are met, with the rounding bound of
/// [`Placement::bounds`]; nothing is re-fitted, so a query pays only for the part of the tree it sees.
pub(crate) struct PairTree<'a, P> {
    pub(crate) a: Bvh<'a>,
    pub(crate) b: Bvh<'a>,
    pub(crate) place: P,
    pub(crate) accuracy: Accuracy,
}

impl<P: Placement> Bvtt for PairTree<'_, P> {
    fn root(&self) -> Option<NodePair> {
        let (a, b) = (self.a.root()?, self.b.root()?);
        a.bounds().overlaps(&self.place.bounds(&b.bounds())).then_some(NodePair { a: 0, b: 0 })
    }

    #[inline]
    fn is_leaf(&self, n: NodePair) -> bool {
        self.a.nodes()[n.a as usize].is_leaf() && self.b.nodes()[n.b as usize].is_leaf()
    }

    #[inline]
    fn children(&self, n: NodePair, mut push: impl FnMut(NodePair)) -> u32 {
        let (a, b) = (&self.a.nodes()[n.a as usize], &self.b.nodes()[n.b as usize]);
        match (a.is_leaf(), b.is_leaf()) {
            (false, false) => {
                let [left, right] = self.placed_children(b.first);
                for child in [a.first, a.first + 1] {
                    let bounds = self.a.nodes()[child as usize].bounds();
                    if bounds.overlaps(&left) {
                        push(NodePair { a: child, b: b.first });
                    }
                    if bounds.overlaps(&right) {
                        push(NodePair { a: child, b: b.first + 1 });
                    }
                }
                4
            }
            (false, true) => {
                let placed = self.place.bounds(&b.bounds());
                for child in [a.first, a.first + 1] {
                    if self.a.nodes()[child as usize].bounds().overlaps(&placed) {
                        push(NodePair { a: child, b: n.b });
                    }
                }
                2
            }
            (true, false) => {
                let bounds = a.bounds();
                let placed = self.placed_children(b.first);
                for (child, placed) in [b.first, b.first + 1].into_iter().zip(&placed) {
                    if bounds.overlaps(placed) {
                        push(NodePair { a: n.a, b: child });
                    }
                }
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
        let (a_leaf, b_leaf) = (&self.a.nodes()[n.a as usize], &self.b.nodes()[n.b as usize]);
        let (a_bounds, b_bounds) = (a_leaf.bounds(), self.place.bounds(&b_leaf.bounds()));
        let own = self.a.leaf_triangles(a_leaf);
        let boxes = LeafBoxes::new(&self.a, own, &b_bounds);
        for (row, &b) in self.b.leaf_triangles(b_leaf).iter().enumerate() {
            let tb = self.placed(b);
            let bounds = Bounds::of(&tb);
            if !bounds.overlaps(&a_bounds) {
                continue;
            }
            let tb = tb.map(|p| p.to_array());
            for (column, &a) in own.iter().enumerate() {
                let before = (row * own.len() + column) as u32;
                if !boxes.overlap(column, &bounds) || before < skip {
                    continue;
                }
                work.triangle_tests += 1;
                let ta = self.a.mesh().triangle(a);
                if intersects(&ta, &tb, self.accuracy) && visit(TrianglePair { a, b }).is_break() {
                    return ControlFlow::Break(before + 1);
                }
            }
        }
        ControlFlow::Continue(())
    }
}

impl<P: Placement> PairTree<'_, P> {
    /// A triangle of the second mesh in the frame of the first.
    pub(crate) fn placed_triangle(&self, b: u32) -> Triangle {
        self.placed(b).map(|p| p.to_array())
    }

    #[inline]
    fn placed(&self, b: u32) -> [Vec3A; 3] {
        self.b.mesh().triangle(b).map(|p| self.place.point(Vec3A::from_array(p)))
    }

    #[inline]
    fn placed_children(&self, first: u32) -> [Bounds; 2] {
        let [left, right] = [first, first + 1].map(|child| self.b.nodes()[child as usize].bounds());
        [self.place.bounds(&left), self.place.bounds(&right)]
    }
}
