//! The BVTT of two meshes.

use super::{
    Blocks, Bvtt, NodePair, Progress, TrianglePair, Visit, after, decide, family_pairs, meet,
};
use crate::aabb::Bounds;
use crate::bvh::Layout;
use crate::index::at;
use crate::simd::{LANES, Simd};
use crate::transform::Placement;
use crate::triangle::Inexact;
use crate::{Bvh, Node, Triangle};
use core::ops::ControlFlow;
use glam::Vec3A;

/// A BVH, where it stands, and whence its boxes are looked at.
///
/// Boxes are transformed as they are met, with the rounding bound of [`Placement::bounds`]; nothing is
/// refitted, so a query pays only for the part of the tree it sees.
///
/// A box that is turned needs a larger one around it. So of two meshes that are both posed in a world it is
/// best to look at the boxes from one of them: `view` may be of any frame in which boxes of triangles that
/// meet overlap. What these triangles are is settled by `place` alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'a, P, V = P, L: Layout = Node> {
    pub(crate) bvh: Bvh<'a, L>,
    pub(crate) place: P,
    pub(crate) view: V,
}

/// Two BVHs in one frame, each a [`Side`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairTree<A, B> {
    pub(crate) a: A,
    pub(crate) b: B,
    pub(crate) inexact: Option<Inexact>,
}

impl<'a, P: Placement + Copy, L: Layout> Side<'a, P, P, L> {
    pub(crate) fn new(bvh: Bvh<'a, L>, place: P) -> Self {
        Self { bvh, place, view: place }
    }
}

impl<'a, P: Placement, V: Placement, L: Layout> Side<'a, P, V, L> {
    #[inline]
    pub(crate) fn node(&self, index: u32) -> &'a L {
        self.bvh.node(index)
    }

    #[inline]
    pub(crate) fn bounds(&self, node: &L) -> Bounds {
        self.view.bounds(&self.bvh.bounds(node))
    }

    #[inline]
    fn bounds_of(&self, node: u32) -> Bounds {
        self.bounds(self.node(node))
    }

    /// The triangles of a leaf.
    #[inline]
    fn leaf(&self, node: u32) -> &'a [u32] {
        self.bvh.leaf_triangles(self.node(node))
    }

    /// The placed corners of a triangle.
    pub(crate) fn triangle(&self, triangle: u32) -> Triangle {
        let corner = |p: [f32; 3]| self.place.point(Vec3A::from_array(p)).to_array();
        self.bvh.mesh().triangle(triangle).map(corner)
    }
}

impl<A: Placement, V: Placement, K: Layout, B: Placement, W: Placement, L: Layout> Bvtt
    for PairTree<Side<'_, A, V, K>, Side<'_, B, W, L>>
{
    fn root(&self) -> Option<NodePair> {
        let (a, b) = (self.a.bvh.root()?, self.b.bvh.root()?);
        self.a.bounds(a).overlaps(&self.b.bounds(b)).then_some(NodePair { a: 0, b: 0 })
    }

    #[inline]
    fn is_leaf(&self, n: NodePair) -> bool {
        self.a.node(n.a).is_leaf() && self.b.node(n.b).is_leaf()
    }

    #[inline]
    fn children(&self, n: NodePair, mut push: impl FnMut(NodePair, [&Bounds; 2])) -> u32 {
        let (a, b) = (self.a.node(n.a), self.b.node(n.b));
        let mut test = |a: u32, b: u32, bounds: [&Bounds; 2]| {
            if bounds[0].overlaps(bounds[1]) {
                push(NodePair { a, b }, bounds);
            }
        };
        match (a.is_leaf(), b.is_leaf()) {
            (false, false) => {
                let (l, r) = (b.left(), b.left() + 1);
                let [left, right] = [l, r].map(|child| self.b.bounds_of(child));
                for child in [a.left(), a.left() + 1] {
                    let own = self.a.bounds_of(child);
                    test(child, l, [&own, &left]);
                    test(child, r, [&own, &right]);
                }
                4
            }
            (false, true) => {
                let other = self.b.bounds(b);
                for child in [a.left(), a.left() + 1] {
                    test(child, n.b, [&self.a.bounds_of(child), &other]);
                }
                2
            }
            (true, false) => {
                let own = self.a.bounds(a);
                for child in [b.left(), b.left() + 1] {
                    test(n.a, child, [&own, &self.b.bounds_of(child)]);
                }
                2
            }
            (true, true) => 0,
        }
    }

    #[inline(always)]
    fn grandchildren(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32 {
        let [mut a, mut b] = [self.a.bvh.family(n.a), self.b.bvh.family(n.b)];
        a.boxes = self.a.view.boxes(&a.boxes);
        b.boxes = self.b.view.boxes(&b.boxes);
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
        let (own, others) = (self.a.leaf(n.a), self.b.leaf(n.b));
        let first = kept_a.get::<S>(n.a, self.a.bvh.mesh(), own, &self.a.place, &[]);
        let second = kept_b.get::<S>(n.b, self.b.bvh.mesh(), others, &self.b.place, &[]);
        let bounds = self.a.place.bounds(&self.a.bvh.bounds(self.a.node(n.a)));
        let pairs = first.pairs::<S, false>(second, &bounds, after(progress.skip));
        decide(pairs, progress, |bit| {
            let (i, j) = (bit % LANES as u32, bit / LANES as u32);
            if meet(first, i, second, j, self.inexact) {
                visit(TrianglePair { a: *at(own, i), b: *at(others, j) })
            } else {
                ControlFlow::Continue(())
            }
        })
    }
}
