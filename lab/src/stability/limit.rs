//! How far a frame may be out of balance, and how good it could have been.
//!
//! Limits are those that the project set itself. `w_max` is the dearest BVTT node that no front splits, a
//! leaf pair or one that is not worth it: whatever partition there is, its worker takes that long, which is
//! what p·w_max/W says relative to the mean. It comes from the BVTT and not from the front that is judged.
//!
//! Two exceptions, where workers have little to do:
//! - A contact that comes where there was none, or hardly any, adds its cost to a worker that has its full
//!   share. Nothing in the last frame tells of it, so that the most by which a node has risen that was not worth
//!   splitting comes on top of 1. (With 1024 workers of 452 box tests each a sheet has one frame in 60 with 1.95.)
//! - Below [`THIN`] box tests a worker, about a microsecond, a single node that is too small to be worth
//!   splitting is most of what a worker does. The node that dominates then counts in every limit, and more so the
//!   further its estimate is off: no forecast meets the limits (measured with 1024 workers of 26 tests each: 12 in a
//!   first frame, where p·w_max/W is 2.4).

use pfront::pfront_core::bvtt::{Cursor, NodePair, Query};
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Box tests per worker below which limits are wider.
pub const THIN: f64 = 100.0;

/// As in [`pfront::pfront_core::front`]: nodes that cost less are not split.
const WORTH_SPLITTING: f64 = 64.0;

/// The limit on the imbalance of a frame: busiest worker over mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Nothing: a first frame, where there is no limit for those.
    None,
    /// A frame like the last: at most max(1.5, 1.1·p·w_max/W), but for new contacts.
    Coherent,
    /// A frame like the last in which no node dominates: at most 1.5.
    Even,
    /// A frame unlike the last, whose costs are estimates: at most 2.5.
    Estimated,
    /// Little to divide: at most 1.1·max(1.36, p·w_max/W); workers may be idle.
    Scarce,
}

/// The imbalance that no partition can avoid, and what it comes from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hardness {
    /// p·w_max/W.
    pub dominance: f64,
    /// The most by which a node has become dearer that was a leaf pair, or not worth splitting, in the last
    /// frame.
    pub rise: f64,
    /// Whether workers have less than [`THIN`] to do.
    pub thin: bool,
}

impl Bound {
    /// The limit.
    pub fn limit(self, of: Hardness) -> f64 {
        let usual = self.usual(of);
        match self {
            Self::Coherent => usual.max(1.1 * (1.0 + of.rise)),
            Self::Even if of.thin => usual.max(1.1 * of.dominance),
            Self::Estimated if of.thin => f64::max(4.0, 5.0 * of.dominance),
            _ => usual,
        }
    }

    /// The limit where workers have much to do.
    pub fn usual(self, Hardness { dominance, .. }: Hardness) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::Coherent => f64::max(1.5, 1.1 * dominance),
            Self::Even => 1.5,
            Self::Estimated => 2.5,
            Self::Scarce => 1.1 * f64::max(1.36, dominance),
        }
    }
}

/// The BVTT of a frame, node by node, compared with that of the last.
#[derive(Debug, Default)]
pub struct Census {
    costs: HashMap<NodePair, f64>,
    last: HashMap<NodePair, f64>,
    /// w_max: the cost of the dearest node that no front splits.
    pub w_max: f64,
    /// The most by which the cost of a node has risen that no front split.
    pub w_rise: f64,
}

impl Census {
    /// Goes on to another frame.
    ///
    /// # Complexity
    /// Visits the whole BVTT.
    pub fn take(&mut self, query: &impl Query) {
        std::mem::swap(&mut self.costs, &mut self.last);
        self.costs.clear();
        self.w_rise = 0.0;
        let root = query.root();
        self.w_max = root.map_or(0.0, |root| self.cost_and_w_max(query, root).1);
    }

    fn keep(&mut self, n: NodePair, cost: f64, is_leaf: bool) {
        let last = self.last.get(&n).copied().unwrap_or(0.0);
        if is_leaf || last < WORTH_SPLITTING {
            self.w_rise = self.w_rise.max(cost - last);
        }
        self.costs.insert(n, cost);
    }

    /// The cost of a BVTT node, and that of the dearest node at or below it that no front splits.
    fn cost_and_w_max(&mut self, query: &impl Query, n: NodePair) -> (f64, f64) {
        let (mut children, mut count) = ([NodePair::default(); 4], 0);
        let tests = query.children(n, &mut |child, _| {
            children[count] = child;
            count += 1;
        });
        if tests == 0 {
            let mut cursor = Cursor::at(n);
            // Never broken off.
            let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
            let cost = cursor.work.cost();
            self.keep(n, cost, true);
            return (cost, cost);
        }
        let (mut cost, mut w_max) = (f64::from(tests), 0.0);
        for &child in &children[..count] {
            let (below, dearest) = self.cost_and_w_max(query, child);
            (cost, w_max) = (cost + below, f64::max(w_max, dearest));
        }
        self.keep(n, cost, false);
        (cost, if cost < WORTH_SPLITTING { cost } else { w_max })
    }
}
