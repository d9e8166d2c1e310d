//! What a frame did, counted: the figures that the paper plots.

use pfront_core::bvtt::Work;
use std::time::Duration;

/// What one worker was dealt, and what it did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The cost it was expected to have, in box tests.
    pub predicted: f64,
    /// What it really did.
    pub work: Work,
}

/// A frame of a [`Traversal`](crate::Traversal). Under [`Static`](crate::Schedule::Static) the counts are the
/// same on every machine, but for fronts of thousands of nodes, which several threads generate: there the
/// rounding of sums may shift a node, and where [`most_nodes`](crate::Settings::most_nodes) are too few,
/// which nodes stay coarse depends on the number of threads. Durations are measured.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Each worker; under [`Stealing`](crate::Schedule::Stealing) one entry for all of them.
    pub shares: Vec<Share>,
    /// Whether time ran out before the front was walked to its end.
    pub late: bool,
    /// The k that costs are counted with.
    pub triangle_cost: f32,
    /// Whether the costs of the last frame could be used.
    pub coherent: bool,
    /// How much of the last frame's cost lay in nodes that overlap again, 0 to 1.
    pub found: f64,
    /// Depth d_s of the starting front.
    pub depth: u32,
    /// Nodes of the starting front, N_s.
    pub starting_nodes: usize,
    /// Nodes of the p-partition front, N_p.
    pub nodes: usize,
    /// Box tests spent on the front; the shares do not include them.
    pub front_box_tests: u64,
    /// How many workers could still have helped, eq. 6, by predicted costs.
    pub p_optimal: u32,
    /// True cost of the dearest front node: no schedule that deals out this front has a makespan below.
    pub dearest_node: f64,
    /// Bytes of memory held for fronts and their costs; 48 a node of this front are in use.
    pub front_bytes: usize,
    /// Generating the front.
    pub front_time: Duration,
    /// Dealing it out.
    pub partition_time: Duration,
    /// Walking.
    pub walk_time: Duration,
    /// Gathering and sorting what was found.
    pub gather_time: Duration,
}

impl Report {
    /// Busiest worker over mean, in counted cost; 1 where there was nothing to do. NaN under
    /// [`Stealing`](crate::Schedule::Stealing), which does not count what each worker did.
    #[must_use]
    pub fn imbalance(&self) -> f64 {
        let costs = || self.shares.iter().map(|share| self.cost(share.work));
        let total: f64 = costs().sum();
        let dealt_out = self.nodes > 0;
        if total > 0.0 && !dealt_out {
            f64::NAN
        } else if total > 0.0 {
            costs().fold(0.0, f64::max) * self.shares.len() as f64 / total
        } else {
            1.0
        }
    }

    /// All box and triangle tests, those for the front included.
    #[must_use]
    pub fn work(&self) -> Work {
        let front = Work { box_tests: self.front_box_tests, triangle_tests: 0 };
        self.shares.iter().fold(front, |sum, Share { work, .. }| Work {
            box_tests: sum.box_tests + work.box_tests,
            triangle_tests: sum.triangle_tests + work.triangle_tests,
        })
    }

    /// Work as one figure, in box tests.
    #[must_use]
    pub fn cost(&self, work: Work) -> f64 {
        work.box_tests as f64 + f64::from(self.triangle_cost) * work.triangle_tests as f64
    }

    /// Adds a frame that continues this one: counts and durations are summed, of what does not add up the largest is
    /// kept, and both have to be coherent.
    pub fn add(&mut self, next: &Self) {
        let shares = self.shares.len().max(next.shares.len());
        self.shares.resize(shares, Share::default());
        for (share, more) in self.shares.iter_mut().zip(&next.shares) {
            share.predicted += more.predicted;
            share.work.box_tests += more.work.box_tests;
            share.work.triangle_tests += more.work.triangle_tests;
        }
        self.late |= next.late;
        self.coherent &= next.coherent;
        self.found = self.found.min(next.found);
        self.depth = self.depth.max(next.depth);
        self.starting_nodes += next.starting_nodes;
        self.nodes += next.nodes;
        self.front_box_tests += next.front_box_tests;
        self.p_optimal = self.p_optimal.max(next.p_optimal);
        self.dearest_node = self.dearest_node.max(next.dearest_node);
        self.front_bytes = self.front_bytes.max(next.front_bytes);
        self.front_time += next.front_time;
        self.partition_time += next.partition_time;
        self.walk_time += next.walk_time;
        self.gather_time += next.gather_time;
    }

    /// Forgets the last frame, keeping memory.
    pub(crate) fn reset(&mut self, triangle_cost: f32) {
        let mut shares = std::mem::take(&mut self.shares);
        shares.clear();
        *self = Self { shares, triangle_cost, ..Self::default() };
    }
}
