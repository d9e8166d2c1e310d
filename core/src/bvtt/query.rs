//! Queries over borrowed meshes, in memory the caller already has.
//!
//! [`PairQuery`](super::PairQuery) and [`SelfQuery`](super::SelfQuery) are the queries, [`Query`] has their verbs, and a
//! [`Cursor`] holds the progress of one.

use super::{Bvtt, Cursor, TrianglePair};
use crate::triangle::Contact;
use core::ops::ControlFlow;

/// The verbs of a query about two meshes, or about one.
pub trait Query: Bvtt {
    /// A cursor before the first triangle pair.
    #[inline]
    fn start(&self) -> Cursor {
        Cursor::at(self.root())
    }

    /// Goes on from `cursor`, calling `visit` for each intersecting triangle pair, until it breaks or
    /// all have been visited. The pair at which it broke counts as visited.
    ///
    /// The order is fixed for given BVHs, and otherwise arbitrary.
    ///
    /// # Complexity
    /// Up to 16 box tests per step of two levels of the BVTT and one triangle test per pair of overlapping
    /// triangle boxes; no allocation, no recursion, below 28 KiB of stack.
    fn visit(
        &self,
        cursor: &mut Cursor,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.step(cursor, u64::MAX, visit)
    }

    /// [`Query::visit`] for at most about `budget` tests, to spread a query over frames: stops when as
    /// many box and triangle tests are done, as [`Cursor::work`] counts them, and goes on from there with
    /// the next call. Pairs and their order are the same for every sequence of budgets; a budget
    /// of 0 does nothing.
    ///
    /// `Break` if `visit` broke, else [`Cursor::is_done`] tells whether anything is left. A `visit` that
    /// breaks when a page is full, or at the first pair, does in steps what [`Query::page`] and
    /// [`Query::any`] do.
    ///
    /// # Complexity
    /// At most `budget` + 15 tests: box tests come up to 16 at a time, triangle tests one by one. A leaf
    /// pair without triangle tests counts as one test against the budget, so at most `budget` of
    /// them are visited. Each loads at most 16 triangles, again if the last step ended inside it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvtt::*;
    /// # use std::ops::ControlFlow;
    /// # fn frames(query: &impl Query) -> u64 {
    /// let (mut cursor, mut pairs) = (query.start(), 0);
    /// while !cursor.is_done() {
    ///     // One frame.
    ///     let _ = query.step(&mut cursor, 1_000, |_| {
    ///         pairs += 1;
    ///         ControlFlow::Continue(())
    ///     });
    /// }
    /// # pairs }
    /// ```
    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// The contact of a pair that a visit reported, in the frame of the query; `None` for a pair
    /// that does not intersect.
    ///
    /// # Panics
    /// If an index is out of range.
    fn contact(&self, pair: TrianglePair) -> Option<Contact>;

    /// Goes on from `cursor` into `out` and returns how many pairs it wrote. It stops when `out` is
    /// full or nothing is left: nothing is ever dropped, and when [`Cursor::is_done`] all pages
    /// together are the whole answer. Only the last page may be empty, if `out` is not.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvtt::*;
    /// # fn pages(query: &impl Query) -> usize {
    /// let mut page = [TrianglePair::default(); 16];
    /// let mut cursor = query.start();
    /// let mut total = 0;
    /// while !cursor.is_done() {
    ///     let n = query.page(&mut cursor, &mut page);
    ///     total += page[..n].len();
    /// }
    /// # total }
    /// ```
    fn page(&self, cursor: &mut Cursor, out: &mut [TrianglePair]) -> usize {
        let capacity = out.len();
        if capacity == 0 {
            return 0;
        }
        let mut free = out.iter_mut();
        // The cursor tells whether the visit broke or ended.
        let _ = self.visit(cursor, |pair| {
            if let Some(slot) = free.next() {
                *slot = pair;
            }
            if free.len() == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        capacity - free.len()
    }

    /// The number of intersecting pairs.
    fn count(&self) -> u64 {
        let mut count = 0;
        let _ = self.visit(&mut self.start(), |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Some intersecting pair, if there is one; the traversal stops at the first.
    fn any(&self) -> Option<TrianglePair> {
        let mut found = None;
        let _ = self.visit(&mut self.start(), |pair| {
            found = Some(pair);
            ControlFlow::Break(())
        });
        found
    }
}
