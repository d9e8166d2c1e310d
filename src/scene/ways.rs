//! An answer of the calling thread, and what one way came to.

use super::SceneHit;
use super::frame::{Found, Frame, Given};
use crate::answer::{End, Leash, Want, alone};
use std::ops::ControlFlow;

/// What one way came to.
pub(super) struct Outcome {
    pub(super) given: Found,
    /// In box tests, if they were counted.
    pub(super) cost: Option<f64>,
    /// If a GPU counted them.
    pub(super) leaf_pairs: Option<u32>,
    pub(super) end: End,
}

/// Answers on the calling thread, as long as `longer` allows.
pub(super) fn on_one(
    frame: &Frame<'_>,
    want: Want,
    hits: &mut Vec<SceneHit>,
    leash: Leash,
    longer: impl FnMut(f64, &dyn Fn() -> f64) -> Option<f64>,
) -> Outcome {
    let mut given = Given::default();
    let found = |bodies, pair| {
        let hit = SceneHit { bodies, pair };
        given.count += 1;
        match want {
            Want::All => hits.push(hit),
            Want::Count => {}
            Want::Any => {
                given.first = Some(hit);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    };
    let (cost, end) = alone(frame.queries(), || frame.len(), leash, found, longer);
    hits.chunk_by_mut(|x, y| x.bodies == y.bodies).for_each(<[_]>::sort_unstable);
    Outcome { given: Found::New(given), cost: Some(cost), leaf_pairs: None, end }
}
