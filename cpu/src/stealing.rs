//! The rival of static partition: rayon's recursion from the root, in which idle threads steal.

use crate::deal;
use crate::sink::Sink;
use pfront_core::bvtt::{Cursor, NodePair, Query, Work};
use std::collections::LinkedList;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A node with no more triangles than this below both sides together is walked as a whole.
const CUT_OFF: u32 = 512;

/// A traversal by stealing: the queries, how to make a sink, and whether to stop.
pub(crate) struct Stealing<'s, Q, N> {
    pub(crate) queries: &'s [Q],
    pub(crate) new_sink: N,
    pub(crate) stop: AtomicBool,
}

/// What a subtree gave. Lists are appended in O(1), so nothing is copied on the way up.
pub(crate) struct Found<S> {
    pub(crate) sinks: LinkedList<S>,
    pub(crate) work: Work,
}

impl<Q: Query + Sync, S: Sink, N: Fn() -> S + Sync> Stealing<'_, Q, N> {
    /// All queries.
    pub(crate) fn run(&self) -> Found<S> {
        self.halves(self.queries.len(), 0, &|number| match self.queries[number as usize].root() {
            Some(root) => self.node(number, root),
            None => Found::nothing(),
        })
    }

    /// `count` things from `first` on, by halves.
    fn halves(
        &self,
        count: usize,
        first: u32,
        each: &(impl Fn(u32) -> Found<S> + Sync),
    ) -> Found<S> {
        if count <= 1 {
            return if count == 1 { each(first) } else { Found::nothing() };
        }
        let (half, rest) = (count / 2, count - count / 2);
        let (left, right) = rayon::join(
            || self.halves(half, first, each),
            || self.halves(rest, first + half as u32, each),
        );
        left.and(right)
    }

    fn node(&self, number: u32, pair: NodePair) -> Found<S> {
        let query = &self.queries[number as usize];
        if self.stop.load(Relaxed) {
            return Found::nothing();
        }
        if query.triangles_below(pair).iter().sum::<u32>() <= CUT_OFF {
            return self.leaf(number, pair);
        }
        let (mut children, mut count) = ([NodePair::default(); 4], 0);
        let tests = query.expand(pair, &mut |child| {
            children[count] = child;
            count += 1;
        });
        if tests == 0 {
            return self.leaf(number, pair);
        }
        let mut found = self.halves(count, 0, &|child| self.node(number, children[child as usize]));
        found.work.box_tests += u64::from(tests);
        found
    }

    fn leaf(&self, number: u32, pair: NodePair) -> Found<S> {
        let (mut sink, mut cursor) = ((self.new_sink)(), Cursor::at(pair));
        deal::walk(&self.queries[number as usize], number, &mut cursor, &mut sink, &self.stop);
        let sinks = if sink.is_empty() { LinkedList::new() } else { LinkedList::from([sink]) };
        Found { sinks, work: cursor.work() }
    }
}

impl<S> Found<S> {
    fn nothing() -> Self {
        Self { sinks: LinkedList::new(), work: Work::default() }
    }

    fn and(mut self, mut other: Self) -> Self {
        self.sinks.append(&mut other.sinks);
        self.work.box_tests += other.work.box_tests;
        self.work.triangle_tests += other.work.triangle_tests;
        self
    }
}
