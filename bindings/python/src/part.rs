//! Part i of n of a question: a pure function of the question, so that parts may be answered anywhere, in any order and
//! more than once, and together are the whole answer.

use crate::memory::{push, reserve};
use pfront::Error;
use pfront::pfront_core::bvtt::{NodePair, Query};

/// So many node pairs a part, if there are as many: parts are then about equally long.
const NODES: usize = 64;

/// The node pairs of part `i` of `n`. The BVTT is descended level by level to a front of [`NODES`] node pairs a part; every
/// n-th of these belongs to a part, so that no part gets one place alone.
pub(crate) fn starts(query: &impl Query, i: usize, n: usize) -> Result<Vec<NodePair>, Error> {
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
        if !is_deeper || front.len() >= NODES * n {
            break;
        }
    }
    let mut own = Vec::new();
    front.into_iter().skip(i).step_by(n).try_for_each(|node| push(&mut own, node))?;
    Ok(own)
}
