//! The verbs of a query about motions.

use super::Impact;
use super::bvtt::{Hit, MovingBvtt, before};
use super::traversal::MovingTraversal;
use crate::bvtt::{NodePair, TrianglePair, Work};
use crate::simd::{Task, VECTORS, widest};
use core::ops::ControlFlow;

impl<const SELF: bool> MovingBvtt<'_, SELF> {
    /// Passes on the children of a node whose boxes overlap at a time, at most four, each with a time before which nothing below it meets.
    /// Returns the number of box tests: 0 for a leaf pair, which has no children.
    pub fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, f64)) -> u32 {
        self.descend(n, |child, time| push(child, before(time)))
    }

    /// Calls `visit` for each pair of triangles below a node pair that meet, until it breaks. Adds its tests to `work`.
    ///
    /// The order is fixed for given BVHs, and otherwise arbitrary. Triangles of one mesh are numbered a < b.
    ///
    /// # Complexity
    /// Four box tests a node pair; for two triangles whose boxes overlap at a time some ten nanoseconds if they stay well apart or cross at the start,
    /// else some microseconds; no allocation, no recursion, bounded stack.
    pub fn visit_below(
        &self,
        n: NodePair,
        work: &mut Work,
        mut visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let at_any_time = &mut |pair, impact| match visit(pair, impact) {
            ControlFlow::Continue(()) => ControlFlow::Continue(f64::INFINITY),
            ControlFlow::Break(()) => ControlFlow::Break(()),
        };
        self.visit_with_budget(n, work, u64::MAX, f64::INFINITY, at_any_time, &mut |_, _| ())
    }

    /// [`MovingBvtt::visit_below`] until `work` has so many tests or a few more: node pairs that are not visited by then are passed to `leave`,
    /// each with a time before which nothing below it meets, and what is below these is what is left.
    ///
    /// `limit` is the latest time that matters, and then what `visit` goes on with: most pairs that meet later are left out.
    ///
    /// # Complexity
    /// As [`MovingBvtt::visit_below`]; at most 3 [`MAX_DEPTH`](crate::bvh::MAX_DEPTH) + 1 node pairs are left.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, motion::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// # let at = |z| PosedBvh::new(bvh, &Pose::from_translation([0.0, 0.0, z]));
    /// # let query = PairBvtt::moving(MovingBvh::new(at(0.0)?, at(0.0)?)?, MovingBvh::new(at(1.0)?, at(-1.0)?)?);
    /// let (mut work, mut found, mut left) = (Work::default(), 0, Vec::from_iter(query.root()));
    /// while let Some(n) = left.pop() {
    ///     let budget = work.tests() + 1_000;
    ///     let mut add = |_, _| {
    ///         found += 1;
    ///         std::ops::ControlFlow::Continue(1.0)
    ///     };
    ///     let _ = query.visit_with_budget(n, &mut work, budget, 1.0, &mut add, &mut |n, _| left.push(n));
    /// }
    /// assert_eq!(found, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn visit_with_budget(
        &self,
        n: NodePair,
        work: &mut Work,
        budget: u64,
        limit: f64,
        visit: &mut dyn FnMut(TrianglePair, Impact) -> ControlFlow<(), f64>,
        leave: &mut dyn FnMut(NodePair, f64),
    ) -> ControlFlow<()> {
        let task = MovingTraversal { query: self, n, work, limit, budget, leave, visit };
        if VECTORS { widest(task) } else { task.run::<f32>() }
    }

    /// [`MovingBvtt::visit_below`] the root.
    pub fn visit(
        &self,
        visit: impl FnMut(TrianglePair, Impact) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match self.root() {
            Some(root) => self.visit_below(root, &mut Work::default(), visit),
            None => ControlFlow::Continue(()),
        }
    }

    /// The number of pairs that certainly meet, and that of all that `visit` is called for, those that are open included.
    #[must_use]
    pub fn count(&self) -> [u64; 2] {
        let mut counts = [0; 2];
        let _ = self.visit(|_, impact| {
            counts[0] += u64::from(impact.is_proven());
            counts[1] += 1;
            ControlFlow::Continue(())
        });
        counts
    }

    /// Some pair that meets, if any does: one that certainly does, the first that the traversal comes upon, unless all are open.
    #[must_use]
    pub fn any(&self) -> Option<(TrianglePair, Impact)> {
        let mut found = None;
        let _ = self.visit(|pair, impact| {
            if impact.is_proven() {
                found = Some((pair, impact));
                return ControlFlow::Break(());
            }
            found = found.or(Some((pair, impact)));
            ControlFlow::Continue(())
        });
        found
    }

    /// The pair that meets first, by `from` and then by the pair, if any does.
    ///
    /// # Complexity
    /// Node pairs that overlap first are visited first, and those that do so later than the answer are left out.
    #[must_use]
    pub fn first_impact(&self) -> Option<(TrianglePair, Impact)> {
        self.first_impact_below(self.root()?, &mut Work::default(), f64::INFINITY)
    }

    /// [`MovingBvtt::first_impact`] below a node pair, if its impact begins no later than `limit`.
    #[must_use]
    pub fn first_impact_below(
        &self,
        n: NodePair,
        work: &mut Work,
        limit: f64,
    ) -> Option<(TrianglePair, Impact)> {
        let (mut best, mut at_most): (Option<Hit>, f64) = (None, limit);
        let visit = &mut |pair, impact: Impact| {
            let is_first = best.is_none_or(|best| (impact.from, pair) < (best.1.from, best.0));
            if is_first && impact.from <= at_most {
                (best, at_most) = (Some((pair, impact)), impact.from);
            }
            ControlFlow::Continue(at_most)
        };
        let _ = self.visit_with_budget(n, work, u64::MAX, limit, visit, &mut |_, _| ());
        best
    }
}
