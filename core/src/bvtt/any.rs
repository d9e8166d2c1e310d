//! A BVTT of either kind.

use super::cursor::Cursor;
use super::query::{Estimated, Query};
use super::trees::{PairBvtt, SelfBvtt};
use super::{NodePair, TrianglePair};
use crate::Aabb;
use crate::triangle::Contact;
use core::ops::ControlFlow;

/// The BVTT of two meshes, or of one and itself, for lists that hold both.
///
/// # Examples
/// ```
/// use pfront_core::{bvtt::*, *};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// # let root = Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 };
/// # let bvh = Bvh::new_unchecked(mesh, std::slice::from_ref(&root), &[0]);
/// let pair = PairBvtt::new(bvh, bvh, Pose::IDENTITY)?;
/// let questions = [AnyBvtt::Pair(pair), AnyBvtt::Itself(SelfBvtt::new(bvh))];
/// assert_eq!(questions.map(|question| question.count()), [1, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub enum AnyBvtt<'q> {
    /// Two meshes.
    Pair(PairBvtt<'q>),
    /// A mesh and itself.
    Itself(SelfBvtt<'q>),
}

/// Asks whichever it is.
macro_rules! either {
    ($any:ident, $tree:ident => $answer:expr) => {
        match $any {
            Self::Pair($tree) => $answer,
            Self::Itself($tree) => $answer,
        }
    };
}

impl Estimated for AnyBvtt<'_> {
    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        either!(self, tree => tree.boxes(n))
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        either!(self, tree => tree.triangles_below(n))
    }

    fn leaf_edge(&self) -> f32 {
        either!(self, tree => tree.leaf_edge())
    }
}

impl Query for AnyBvtt<'_> {
    #[inline]
    fn root(&self) -> Option<NodePair> {
        either!(self, tree => tree.root())
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        either!(self, tree => tree.children(n, push))
    }

    #[inline]
    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        either!(self, tree => tree.step(cursor, budget, visit))
    }

    fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        either!(self, tree => tree.contact_f64(pair))
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        either!(self, tree => tree.contact(pair))
    }
}
