//! Where the pairs go: each worker has a sink of its own, so that gathering needs no lock.

use pfront_core::bvtt::TrianglePair;
use std::ops::ControlFlow;

/// A triangle pair that meets, of one query among many. The order is that of `query`, then `pair`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hit {
    /// The number of the query.
    pub query: u32,
    /// The triangles.
    pub pair: TrianglePair,
}

/// What one worker does with the pairs it finds.
pub(crate) trait Sink: Send {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()>;

    /// Whether nothing in it would be missed.
    fn is_empty(&self) -> bool;
}

/// An element of an answer.
pub(crate) trait Element: Copy + Ord + Send {
    fn new(query: u32, pair: TrianglePair) -> Self;
}

impl Element for TrianglePair {
    fn new(_: u32, pair: TrianglePair) -> Self {
        pair
    }
}

impl Element for Hit {
    fn new(query: u32, pair: TrianglePair) -> Self {
        Self { query, pair }
    }
}

impl<T: Element> Sink for Vec<T> {
    #[inline]
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        self.push(T::new(query, pair));
        ControlFlow::Continue(())
    }

    fn is_empty(&self) -> bool {
        self.is_empty()
    }
}

/// Makes it one empty list for each worker.
pub(crate) fn clear<T>(sinks: &mut Vec<Vec<T>>, workers: usize) {
    sinks.resize_with(workers, Vec::new);
    sinks.iter_mut().for_each(Vec::clear);
}

impl Sink for u64 {
    #[inline]
    fn take(&mut self, _: u32, _: TrianglePair) -> ControlFlow<()> {
        *self += 1;
        ControlFlow::Continue(())
    }

    fn is_empty(&self) -> bool {
        *self == 0
    }
}

impl Sink for Option<Hit> {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        *self = Some(Hit { query, pair });
        ControlFlow::Break(())
    }

    fn is_empty(&self) -> bool {
        self.is_none()
    }
}

/// Hands pairs to the caller.
pub(crate) struct Visitor<'v, V>(pub(crate) &'v V);

impl<V: Fn(Hit) -> ControlFlow<()> + Sync> Sink for Visitor<'_, V> {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        (self.0)(Hit { query, pair })
    }

    fn is_empty(&self) -> bool {
        true
    }
}
