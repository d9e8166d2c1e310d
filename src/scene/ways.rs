//! An answer of the calling thread, and what one way came to.

use super::SceneHit;
use super::frame::{Found, Frame, Given};
use crate::answer::{self, Leash, Want, alone};

pub(super) type Outcome = answer::Outcome<Found>;

/// Answers on the calling thread, as long as `longer` allows.
pub(super) fn on_one(
    frame: &Frame<'_>,
    want: Want,
    hits: &mut Vec<SceneHit>,
    leash: Leash,
    longer: impl FnMut(f64, &dyn Fn() -> f64) -> Option<f64>,
) -> Outcome {
    let mut given = Given::default();
    let found = |bodies, pair| given.add(SceneHit { bodies, pair }, want, hits);
    let (cost, end) = alone(frame.queries(), || frame.len(), leash, found, longer);
    hits.chunk_by_mut(|x, y| x.bodies == y.bodies).for_each(<[_]>::sort_unstable);
    Outcome { given: Found::New(given), cost: Some(cost), leaf_pairs: None, end }
}
