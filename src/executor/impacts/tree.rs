//! The BVTT of a subject that moves or rests.

use crate::{Impact, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Cursor, NodePair, Query, Work};
use pfront_core::motion::MovingBvtt;
use std::ops::ControlFlow;

/// The BVTT of two meshes that move, of one that deforms and itself, or of what rests.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyMovingBvtt<'q> {
    Pair(MovingBvtt<'q, false>),
    Itself(MovingBvtt<'q, true>),
    /// Its pairs are those that intersect, from the start on.
    Still(AnyBvtt<'q>),
}

/// The impact of what intersects from the start on.
pub(crate) const AT_START: Impact = Impact { from: 0.0, to: 0.0 };

impl AnyMovingBvtt<'_> {
    /// The first time at which the boxes of the root overlap; before that, nothing below meets.
    pub(crate) fn first_overlap(&self) -> Option<f64> {
        match self {
            Self::Pair(tree) => tree.first_overlap(),
            Self::Itself(tree) => tree.first_overlap(),
            Self::Still(tree) => tree.root().map(|_| 0.0),
        }
    }

    /// Passes on the children of a node pair, each with a time before which nothing below it meets. Returns the number of box tests.
    pub(super) fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, f64)) -> u32 {
        match self {
            Self::Pair(tree) => tree.children(n, push),
            Self::Itself(tree) => tree.children(n, push),
            Self::Still(tree) => tree.children(n, &mut |child, _| push(child, 0.0)),
        }
    }

    /// [`MovingBvtt::visit_with_budget`]; of what rests, too.
    pub(super) fn visit_with_budget(
        &self,
        n: NodePair,
        budget: u64,
        limit: f64,
        visit: &mut dyn FnMut(TrianglePair, Impact) -> ControlFlow<(), f64>,
        leave: &mut dyn FnMut(NodePair, f64),
    ) {
        let work = &mut Work::default();
        let _ = match self {
            Self::Pair(tree) => tree.visit_with_budget(n, work, budget, limit, visit, leave),
            Self::Itself(tree) => tree.visit_with_budget(n, work, budget, limit, visit, leave),
            Self::Still(tree) => {
                let mut visit = |pair| match visit(pair, AT_START) {
                    ControlFlow::Continue(_) => ControlFlow::Continue(()),
                    ControlFlow::Break(()) => ControlFlow::Break(()),
                };
                let mut cursor = Cursor::at(n);
                let mut end = tree.step(&mut cursor, budget, &mut visit);
                if end.is_continue() {
                    cursor.take_pending().iter().for_each(|&n| leave(n, 0.0));
                    // At most one leaf pair is left.
                    end = tree.visit(&mut cursor, visit);
                }
                end
            }
        };
    }
}
