//! Part i of n of a question: a pure function of the question, so that parts may be answered anywhere, in any order and
//! more than once, and together are the whole answer.

use crate::memory::{push, reserve};
use pfront::pfront_core::bvtt::{AnyBvtt, Cursor, NodePair, Query};
use pfront::{Error, TrianglePair};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// So many node pairs a part, if there are as many: parts are then about equally long.
const NODES: usize = 64;
/// Parts whose node pairs take longer to find than signals may wait.
const PARTS: usize = 1 << 10;
/// Tests between two looks at the flag: less than a millisecond.
const STEP: u64 = 1 << 12;

/// Part `i` of `n`.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    i: usize,
    n: usize,
}

impl FromPyObject<'_, '_> for Part {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let (i, n) = given.extract()?;
        if i >= n {
            return Err(PyValueError::new_err(format!("part {i} of {n} is none")));
        }
        Ok(Self { i, n })
    }
}

impl Part {
    /// Whether to find where it begins takes longer than signals may wait.
    pub(crate) fn is_long(self) -> bool {
        self.n > PARTS
    }

    /// The node pairs of this part. The BVTT is descended level by level to a front of [`NODES`] node pairs a part; every
    /// n-th of these belongs to a part, so that no part gets one place alone.
    fn starts(self, query: &impl Query) -> Result<Vec<NodePair>, Error> {
        let mut front: Vec<NodePair> = query.root().into_iter().collect();
        loop {
            // A node pair has at most four children.
            let mut next = Vec::new();
            reserve(&mut next, 4 * front.len())?;
            let mut is_deeper = false;
            for &node in &front {
                let before = next.len();
                let tests = query.children(node, &mut |child, _| next.push(child));
                if tests == 0 {
                    // A leaf pair.
                    next.truncate(before);
                    next.push(node);
                } else {
                    is_deeper = true;
                }
            }
            front = next;
            if !is_deeper || front.len() >= NODES * self.n {
                break;
            }
        }
        let mut own = Vec::new();
        front.into_iter().skip(self.i).step_by(self.n).try_for_each(|node| push(&mut own, node))?;
        Ok(own)
    }
}

/// A question about a part of a BVTT, until the flag is set.
pub(crate) struct PartQuery<'q> {
    pub(crate) tree: &'q AnyBvtt<'q>,
    pub(crate) part: Part,
    pub(crate) cancel: &'q AtomicBool,
}

impl PartQuery<'_> {
    /// Visits the pairs that meet, in no particular order.
    pub(crate) fn visit(
        &self,
        mut visit: impl FnMut(TrianglePair) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut visited = Ok(());
        for node in self.part.starts(self.tree)? {
            let mut cursor = Cursor::at(node);
            while !cursor.is_done() {
                if self.cancel.load(Relaxed) {
                    return Err(Error::Cancelled);
                }
                let step = self.tree.step(&mut cursor, STEP, &mut |pair| {
                    visited = visit(pair);
                    if visited.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                });
                if step.is_break() {
                    return visited;
                }
            }
        }
        Ok(())
    }
}
