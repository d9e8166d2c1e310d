//! Outputs of the threads, one each so that gathering needs no lock, and the radix sort of what was gathered.

use pfront_core::bvtt::TrianglePair;
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
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()>;

    /// Whether nothing has been put into it.
    fn is_empty(&self) -> bool;
}

impl<T: Item> Output for Vec<T> {
    #[inline]
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        self.push(T::new(query, pair));
        ControlFlow::Continue(())
    }

    fn is_empty(&self) -> bool {
        self.is_empty()
    }
}

impl Output for u64 {
    #[inline]
    fn take(&mut self, _: u32, _: TrianglePair) -> ControlFlow<()> {
        *self += 1;
        ControlFlow::Continue(())
    }

    fn is_empty(&self) -> bool {
        *self == 0
    }
}

impl Output for Option<Hit> {
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

impl<V: Fn(Hit) -> ControlFlow<()> + Sync> Output for Visitor<'_, V> {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        (self.0)(Hit { query, pair })
    }

    fn is_empty(&self) -> bool {
        true
    }
}

/// Lists of an answer's parts, one for each thread, whose memory is kept from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Storage {
    pairs: Vec<Vec<TrianglePair>>,
    hits: Vec<Vec<Hit>>,
}

/// An item of an answer: a triangle pair, or a hit, which tells the query too.
pub trait Item: Copy + Default + Ord + Send {
    fn new(query: u32, pair: TrianglePair) -> Self;

    fn storage(storage: &mut Storage) -> &mut Vec<Vec<Self>>;

    /// A number that sorts as the element does.
    fn key(&self) -> u128;
}

impl Item for TrianglePair {
    fn new(_: u32, pair: TrianglePair) -> Self {
        pair
    }

    fn storage(storage: &mut Storage) -> &mut Vec<Vec<Self>> {
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

    fn storage(storage: &mut Storage) -> &mut Vec<Vec<Self>> {
        &mut storage.hits
    }

    #[inline]
    fn key(&self) -> u128 {
        u128::from(self.query) << 64 | self.pair.key()
    }
}

/// Whether an answer of so many elements is sorted faster on so many threads than by a radix sort on one.
pub(crate) fn is_worth_threads(len: usize, threads: usize) -> bool {
    len >= 1 << 16 && threads >= 8
}

/// Shorter answers are sorted by comparison.
const RADIX_FROM: usize = 512;

/// Sorts an answer.
pub(crate) fn sort<T: Item>(items: &mut Vec<T>, scratch: &mut Vec<T>) {
    if items.len() < RADIX_FROM {
        items.sort_unstable();
    } else {
        radix_sort(items, scratch);
    }
}

/// Sorts by one byte of the key after the other, from the least on, leaving out those in which all keys agree.
fn radix_sort<T: Item>(items: &mut Vec<T>, scratch: &mut Vec<T>) {
    let bits = |(any, all), item: &T| (any | item.key(), all & item.key());
    let (any, all) = items.iter().fold((0, u128::MAX), bits);
    scratch.resize(items.len(), T::default());
    for shift in (0..128).step_by(8).filter(|shift| (any ^ all) >> shift & 255 != 0) {
        let byte = |item: &T| (item.key() >> shift) as usize & 255;
        let mut ends = [0; 256];
        items.iter().for_each(|item| ends[byte(item)] += 1);
        let mut sum = 0;
        ends.iter_mut().for_each(|end| sum += std::mem::replace(end, sum));
        for item in items.iter() {
            let place = &mut ends[byte(item)];
            scratch[*place] = *item;
            *place += 1;
        }
        std::mem::swap(items, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn radix_sort_sorts() {
        let mut rng = seeded(1);
        let mut random = |most: u32| rng.random_range(0..most);
        let mut scratch = Vec::new();
        for (count, most) in
            [(0, 1), (1, 1), (600, 1), (700, 300), (5_000, 70_000), (900, u32::MAX)]
        {
            let mut hit = || Hit {
                query: random(most),
                pair: TrianglePair { a: random(most), b: random(most) },
            };
            let mut hits: Vec<Hit> = (0..count).map(|_| hit()).collect();
            let mut expected = hits.clone();
            expected.sort();
            radix_sort(&mut hits, &mut scratch);
            assert!(hits == expected, "{count} {most}");
        }
    }
}
