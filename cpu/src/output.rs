//! Outputs of the threads, one each so that no thread waits for a lock. Each thread sorts its
//! list of pairs, and all merge them: see [`crate::merge`].

use crate::MemoryError;
use crate::memory::reserve;
use crate::sort::sort;
use pfront_core::bvtt::TrianglePair;
use pfront_core::environment::Environment;
use std::ops::ControlFlow;

/// An intersecting triangle pair of one query among many. Hits are ordered by `query`, then by `pair`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hit {
    /// The number of the query.
    pub query: u32,
    /// The triangles.
    pub pair: TrianglePair,
}

/// The output of one thread.
pub(crate) trait Output: Send {
    /// Called by each thread that is about to fill it, with the thread's own floating-point environment.
    fn begin(&mut self, _environment: Environment) {}

    /// Takes a pair that was found; a break ends the frame.
    fn add(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()>;

    /// Called by each thread that has filled it.
    fn finish(&mut self) {}

    /// The error for which it ended the frame.
    fn failure(&self) -> Option<MemoryError> {
        None
    }
}

/// The list that one thread makes, or several one after the other.
#[derive(Clone, Debug, Default)]
pub struct OutputBuffer<T> {
    pub(crate) items: Vec<T>,
    /// How many of them are known to be sorted.
    pub(crate) sorted: usize,
    /// Memory to sort in.
    pub(crate) scratch: Vec<T>,
    failure: Option<MemoryError>,
}

impl<T> OutputBuffer<T> {
    pub(crate) fn clear(&mut self) {
        self.items.clear();
        (self.sorted, self.failure) = (0, None);
    }

    /// Makes room for one more item.
    #[cold]
    fn grow(&mut self) -> ControlFlow<()> {
        self.failure = reserve(&mut self.items, 1).err();
        if self.failure.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl<T: Item> Output for OutputBuffer<T> {
    #[inline]
    fn add(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        if self.items.len() == self.items.capacity() {
            self.grow()?;
        }
        self.items.push(T::new(query, pair));
        ControlFlow::Continue(())
    }

    /// Sorts the list while it is in the cache of its thread, and others still traverse.
    fn finish(&mut self) {
        if self.sorted < self.items.len() {
            sort(&mut self.items, &mut self.scratch, T::key);
            self.sorted = self.items.len();
        }
    }

    fn failure(&self) -> Option<MemoryError> {
        self.failure
    }
}

impl Output for u64 {
    #[inline]
    fn add(&mut self, _: u32, _: TrianglePair) -> ControlFlow<()> {
        *self += 1;
        ControlFlow::Continue(())
    }
}

impl Output for Option<Hit> {
    fn add(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        *self = Some(Hit { query, pair });
        ControlFlow::Break(())
    }
}

/// Hands pairs to the caller, in the floating-point environment of the thread that calls.
pub(crate) struct Visitor<'v, V> {
    visit: &'v V,
    environment: Environment,
}

impl<'v, V> Visitor<'v, V> {
    pub(crate) fn new(visit: &'v V) -> Self {
        Self { visit, environment: Environment::DEFAULT }
    }
}

impl<V: Fn(Hit) -> ControlFlow<()> + Sync> Output for Visitor<'_, V> {
    fn begin(&mut self, environment: Environment) {
        self.environment = environment;
    }

    fn add(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        self.environment.run(|| (self.visit)(Hit { query, pair }))
    }
}

/// Lists of an answer's parts, one for each thread, whose memory is kept from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Storage {
    pairs: Vec<OutputBuffer<TrianglePair>>,
    hits: Vec<OutputBuffer<Hit>>,
}

/// An item of an answer: a triangle pair, or a hit, which tells the query too.
pub trait Item: Copy + Default + Ord + Send + Sync {
    fn new(query: u32, pair: TrianglePair) -> Self;

    fn storage(storage: &mut Storage) -> &mut Vec<OutputBuffer<Self>>;

    /// A number that sorts as the element does.
    fn key(&self) -> u128;
}

impl Item for TrianglePair {
    fn new(_: u32, pair: TrianglePair) -> Self {
        pair
    }

    fn storage(storage: &mut Storage) -> &mut Vec<OutputBuffer<Self>> {
        &mut storage.pairs
    }

    #[inline]
    fn key(&self) -> u128 {
        u128::from(self.a) << 32 | u128::from(self.b)
    }
}

impl Item for Hit {
    fn new(query: u32, pair: TrianglePair) -> Self {
        Self { query, pair }
    }

    fn storage(storage: &mut Storage) -> &mut Vec<OutputBuffer<Self>> {
        &mut storage.hits
    }

    #[inline]
    fn key(&self) -> u128 {
        u128::from(self.query) << 64 | self.pair.key()
    }
}
