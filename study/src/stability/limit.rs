//! How far a frame may be out of balance, and how good it could have been.
//!
//! Limits are those that the project set itself. `w_max` is the dearest BVTT node that no front splits, a
//! leaf pair or one that is not worth it: whatever partition there is, its worker takes that long, which is
//! what p·w_max/W says relative to the mean. It comes from the BVTT and not from the front that is judged.
//!
//! One exception: below [`THIN`] box tests a worker, about a microsecond, a single node that is too small to
//! be worth splitting is most of what a worker does. What dominates then counts everywhere, and more so the
//! further its estimate is off: no forecast meets the limits (measured with 1024 workers of 26 tests each: 12
//! in a first frame, where p·w_max/W is 2.4).

use pfront::core::query::{Cursor, NodePair, Query};
use pfront::threads::Report;
use std::ops::ControlFlow;

/// Box tests per worker below which limits are wider.
pub const THIN: f64 = 100.0;

/// As in [`pfront::core::front`]: nodes that cost less are not split.
const WORTH_SPLITTING: f64 = 64.0;

/// What is asked of the imbalance of a frame: busiest worker over mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Nothing: a first frame, where there is no limit for those.
    None,
    /// A frame like the last: at most max(1.5, 1.1·p·w_max/W).
    Coherent,
    /// A frame like the last in which no node dominates: at most 1.5.
    Even,
    /// A frame unlike the last, whose costs are estimates: at most 2.5.
    Estimated,
    /// Little to divide: at most 1.1·max(1.36, p·w_max/W); workers may be idle.
    Scarce,
}

impl Bound {
    /// The limit where p·w_max/W is `dominance`, for workers with so much to do that it holds, or `thin`
    /// ones.
    #[must_use]
    pub fn limit(self, dominance: f64, thin: bool) -> f64 {
        match (self, thin) {
            (Self::None, _) => f64::INFINITY,
            (Self::Even, false) => 1.5,
            (Self::Coherent, _) | (Self::Even, true) => f64::max(1.5, 1.1 * dominance),
            (Self::Scarce, _) => 1.1 * f64::max(1.36, dominance),
            (Self::Estimated, false) => 2.5,
            (Self::Estimated, true) => f64::max(4.0, 5.0 * dominance),
        }
    }
}

/// What the dearest BVTT node costs that no front splits, w_max, with the costs of `report`.
///
/// # Complexity
/// Visits the whole BVTT.
#[must_use]
pub fn w_max(query: &impl Query, report: &Report) -> f64 {
    query.root().map_or(0.0, |root| cost_and_w_max(query, root, report).1)
}

/// What a BVTT node costs, and the dearest at or below it that no front splits.
fn cost_and_w_max(query: &impl Query, node: NodePair, report: &Report) -> (f64, f64) {
    let (mut children, mut count) = ([NodePair::default(); 4], 0);
    let tests = query.expand(node, &mut |child| {
        children[count] = child;
        count += 1;
    });
    if tests == 0 {
        let mut cursor = Cursor::at(node);
        // Never broken off.
        let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
        let cost = report.cost(cursor.work());
        return (cost, cost);
    }
    let below = children[..count].iter().map(|&child| cost_and_w_max(query, child, report));
    let (cost, w_max) = below
        .fold((f64::from(tests), 0.0), |(sum, most), (cost, w)| (sum + cost, f64::max(most, w)));
    (cost, if cost < WORTH_SPLITTING { cost } else { w_max })
}
