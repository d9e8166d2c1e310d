//! A frame that is divided between workers and a device.

use super::Traversal;
use crate::beside::Crew;
use crate::pool::in_pool;
use crate::{Schedule, Settings, Share, sink};
use pfront_core::bvtt::{NodePair, Query, TrianglePair};
use std::slice::from_ref;
use std::time::Instant;

impl Traversal {
    /// [`Traversal::all`] of a part of the query, while a device, such as a GPU, finds the rest.
    ///
    /// The device gets about `share` of the expected cost, 0 to 1, as whole nodes of the front, which may be
    /// none: `device` is called with them once and starts the device on what lies below them, while workers
    /// walk the others. What they find replaces the contents of `out`, sorted; what `device` returns, from
    /// which the rest of the pairs may be had later, is returned. Both together are the answer, and no pair
    /// is in both.
    ///
    /// [`device_share`](crate::Report::device_share) tells what the device got,
    /// [`walk_time`](crate::Report::walk_time) how long workers took.
    /// Under [`Schedule::Stealing`], which has no front, this works as under [`Schedule::Hybrid`].
    ///
    /// # Examples
    /// With a device that is done at once:
    /// ```
    /// # use pfront_core::{*, bvtt::*};
    /// # use std::ops::ControlFlow;
    /// # fn frame(traversal: &mut pfront_cpu::Traversal, query: &(impl Query + Sync)) {
    /// let (mut pairs, mut found) = (Vec::new(), Vec::new());
    /// let device = |nodes: &[NodePair]| {
    ///     let mut each = |pair| ControlFlow::Continue(found.push(pair));
    ///     nodes.iter().try_for_each(|&node| query.visit(&mut Cursor::at(node), &mut each))
    /// };
    /// let _ = traversal.all_beside(query, 0.25, device, &mut pairs);
    /// pairs.extend(found);
    /// pairs.sort();
    /// # }
    /// ```
    pub fn all_beside<Q: Query + Sync, D: Send>(
        &mut self,
        query: &Q,
        share: f64,
        device: impl FnOnce(&[NodePair]) -> D + Send,
        out: &mut Vec<TrianglePair>,
    ) -> D {
        let mut sinks = std::mem::take(&mut self.pairs);
        sink::clear(&mut sinks, self.workers);
        let Self { workers, settings, pool, plan, deal, report, .. } = self;
        let schedule = match settings.schedule {
            Schedule::Stealing => Schedule::Hybrid,
            other => other,
        };
        let (crew, settings) =
            (Crew::of(*workers).beside(share), Settings { schedule, ..*settings });
        let queries = from_ref(query);
        report.reset(settings.triangle_cost);
        report.shares.resize(*workers, Share::default());
        let (started, device_time) = in_pool(pool.as_deref(), || {
            plan.make(queries, crew, &settings, report);
            let start = || {
                let clock = Instant::now();
                (device(plan.device()), clock.elapsed())
            };
            let (started, _) =
                rayon::join(start, || deal.walk(plan, queries, schedule, None, &mut sinks, report));
            plan.remember(deal.costs());
            started
        });
        self.report.device_time = device_time;
        self.gather(&sinks, out);
        self.pairs = sinks;
        started
    }
}
