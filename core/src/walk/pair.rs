//! The BVTT of two meshes.

use super::{Bvtt, LeafBoxes, NodePair, TrianglePair, Visit, Work};
use crate::aabb::Bounds;
use crate::bvh::Node;
use crate::pose::Placement;
use crate::triangle::{Accuracy, intersects};
use crate::{Bvh, Triangle};
use core::ops::ControlFlow;
use glam::Vec3A;

/// A BVH and where it stands.
///
/// Boxes are transformed as they are met, with the rounding bound of [`Placement::bounds`]; nothing is
/// refitted, so a query pays only for the part of the tree it sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'a, P> {
    pub(crate) bvh: Bvh<'a>,
    pub(crate) place: P,
}

/// Two BVHs in one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairTree<'a, A, B> {
    pub(crate) a: Side<'a, A>,
    pub(crate) b: Side<'a, B>,
    pub(crate) accuracy: Accuracy,
}

impl<'a, P: Placement> Side<'a, P> {
    #[inline]
    pub(crate) fn node(&self, index: u32) -> &'a Node {
        &self.bvh.nodes()[index as usize]
    }

    #[inline]
    pub(crate) fn bounds(&self, node: &Node) -> Bounds {
        self.place.bounds(&node.bounds())
    }

    #[inline]
    fn bounds_of(&self, node: u32) -> Bounds {
        self.bounds(self.node(node))
    }

    #[inline]
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3A; 3] {
        let mesh = self.bvh.mesh();
        let corner = |v: u32| self.place.point(Vec3A::from_array(mesh.positions()[v as usize]));
        let [p, q, r] = mesh.triangles()[triangle as usize];
        [corner(p), corner(q), corner(r)]
    }

    #[inline]
    pub(crate) fn triangle(&self, triangle: u32) -> Triangle {
        let [p, q, r] = self.corners(triangle);
        [p.to_array(), q.to_array(), r.to_array()]
    }
}

impl<'a, A: Placement, B: Placement> PairTree<'a, A, B> {
    /// The same tree, seen through other placements.
    pub(crate) fn through<C, D>(&self, a: C, b: D) -> PairTree<'a, C, D> {
        let (a, b) = (Side { bvh: self.a.bvh, place: a }, Side { bvh: self.b.bvh, place: b });
        PairTree { a, b, accuracy: self.accuracy }
    }
}

impl<A: Placement, B: Placement> Bvtt for PairTree<'_, A, B> {
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
                let [left, right] = [b.first, b.first + 1].map(|child| self.b.bounds_of(child));
                for child in [a.first, a.first + 1] {
                    let own = self.a.bounds_of(child);
                    test(child, b.first, [&own, &left]);
                    test(child, b.first + 1, [&own, &right]);
                }
                4
            }
            (false, true) => {
                let other = self.b.bounds(b);
                for child in [a.first, a.first + 1] {
                    test(child, n.b, [&self.a.bounds_of(child), &other]);
                }
                2
            }
            (true, false) => {
                let own = self.a.bounds(a);
                for child in [b.first, b.first + 1] {
                    test(n.a, child, [&own, &self.b.bounds_of(child)]);
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
        visit: &mut Visit<'_>,
    ) -> ControlFlow<u32> {
        let (a_leaf, b_leaf) = (self.a.node(n.a), self.b.node(n.b));
        let (a_bounds, b_bounds) = (self.a.bounds(a_leaf), self.b.bounds(b_leaf));
        let own = self.a.bvh.leaf_triangles(a_leaf);
        let boxes = LeafBoxes::new(own, &b_bounds, |a| self.a.corners(a));
        for (row, &b) in self.b.bvh.leaf_triangles(b_leaf).iter().enumerate() {
            let tb = self.b.corners(b);
            let bounds = Bounds::of(&tb);
            if !bounds.overlaps(&a_bounds) {
                continue;
            }
            let tb = [tb[0].to_array(), tb[1].to_array(), tb[2].to_array()];
            for (column, &a) in own.iter().enumerate() {
                let before = (row * own.len() + column) as u32;
                if !boxes.overlap(column, &bounds) || before < skip {
                    continue;
                }
                work.triangle_tests += 1;
                let ta = self.a.triangle(a);
                if intersects(&ta, &tb, self.accuracy) && visit(TrianglePair { a, b }).is_break() {
                    return ControlFlow::Break(before + 1);
                }
            }
        }
        ControlFlow::Continue(())
    }
}
