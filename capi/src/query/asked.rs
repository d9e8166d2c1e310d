//! Either kind of query.

use core::ops::ControlFlow;
use pfront_core::bvtt::{Cursor, NodePair, PairBvtt, Query, SelfBvtt, TrianglePair};
use pfront_core::triangle::Contact;
use pfront_core::{Aabb, Bvh, Mesh};

/// A query that C has made.
#[derive(Clone, Copy)]
pub(crate) enum Asked<'c> {
    /// Two meshes.
    Pair(PairBvtt<'c>),
    /// One mesh.
    Within(SelfBvtt<'c>),
}

impl Asked<'_> {
    /// A query about an empty mesh, which has no answers.
    pub(crate) fn nothing() -> Self {
        Self::Within(SelfBvtt::new(Bvh::new_unchecked(Mesh::new_unchecked(&[], &[]), &[], &[])))
    }
}

/// Asks whichever it is.
macro_rules! either {
    ($asked:ident, $query:ident => $answer:expr) => {
        match $asked {
            Asked::Pair($query) => $answer,
            Asked::Within($query) => $answer,
        }
    };
}

impl Query for Asked<'_> {
    fn root(&self) -> Option<NodePair> {
        either!(self, query => query.root())
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        either!(self, query => query.children(n, push))
    }

    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        either!(self, query => query.boxes(n))
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        either!(self, query => query.triangles_below(n))
    }

    fn leaf_edge(&self) -> f32 {
        either!(self, query => query.leaf_edge())
    }

    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        either!(self, query => query.step(cursor, budget, visit))
    }

    fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        either!(self, query => query.contact_f64(pair))
    }
}
