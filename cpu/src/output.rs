//! Outputs of the threads, one each so that no thread waits for a lock. Each thread sorts its own list while it is in its
//! cache, and the sorted lists are merged by all threads.

use pfront_core::bvtt::TrianglePair;
use rayon::prelude::*;
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

    /// Called by the thread that is done with it.
    fn finish(&mut self) {}
}

/// The list that one thread makes, which ends up sorted.
#[derive(Clone, Debug, Default)]
pub struct OutputBuffer<T> {
    pub(crate) items: Vec<T>,
    scratch: Vec<T>,
}

impl<T: Item> Output for OutputBuffer<T> {
    #[inline]
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        self.items.push(T::new(query, pair));
        ControlFlow::Continue(())
    }

    fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    fn finish(&mut self) {
        if self.items.len() < RADIX_FROM {
            self.items.sort_unstable();
        } else if !self.items.is_sorted() {
            radix_sort(&mut self.items, &mut self.scratch);
        }
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

/// Shorter lists are sorted by comparison.
const RADIX_FROM: usize = 512;

/// Elements that take about as long to merge as it takes to call another thread that is awake.
const MERGED_ALONE: usize = 512;

/// The number of ranges of keys in which lists are merged: one for each thread that is worth it.
pub(crate) fn ranges<T: Item>(lists: &[OutputBuffer<T>], threads: usize) -> usize {
    let is_several = lists.iter().filter(|list| !list.is_empty()).nth(1).is_some();
    let len: usize = lists.iter().map(|list| list.items.len()).sum();
    if is_several { threads.min(len / MERGED_ALONE).max(1) } else { 1 }
}

/// Replaces the contents of `out` by those of sorted lists, sorted, range by range.
///
/// The ranges come from regular samples of the lists, so that none has much more than its
/// share of the elements (Shi & Schaeffer, *Parallel Sorting by Regular Sampling*, 1992).
pub(crate) fn merge<T: Item>(lists: &mut [OutputBuffer<T>], ranges: usize, out: &mut Vec<T>) {
    let len: usize = lists.iter().map(|list| list.items.len()).sum();
    if let Some(only) = lists.iter_mut().find(|list| list.items.len() == len) {
        std::mem::swap(out, &mut only.items);
        return;
    }
    out.clear();
    let lists = || lists.iter().map(|list| &list.items[..]).filter(|items| !items.is_empty());
    if ranges == 1 {
        lists().for_each(|items| out.extend_from_slice(items));
        // This sort finds runs and merges them.
        out.sort();
        return;
    }
    let step = (len / (ranges * ranges)).max(1);
    let mut samples: Vec<T> =
        lists().flat_map(|items| items.iter().step_by(step)).copied().collect();
    samples.sort_unstable();
    let lists: Vec<&[T]> = lists().collect();
    let begin = |range: usize| {
        let first = samples.get(range * samples.len() / ranges);
        let begin = |items: &&[T]| match first {
            _ if range == 0 => 0,
            Some(first) => items.partition_point(|item| item < first),
            None => items.len(),
        };
        lists.iter().map(begin).collect()
    };
    let begins: Vec<Vec<usize>> = (0..=ranges).into_par_iter().map(begin).collect();
    out.resize(len, T::default());
    let (mut rest, mut chunks) = (&mut out[..], Vec::with_capacity(ranges));
    for bounds in begins.windows(2) {
        let [len, before] = [1, 0].map(|i: usize| bounds[i].iter().sum::<usize>());
        let (chunk, others) = std::mem::take(&mut rest).split_at_mut(len - before);
        chunks.push((chunk, bounds));
        rest = others;
    }
    chunks.into_par_iter().for_each(|(chunk, bounds)| {
        let mut rest = &mut chunk[..];
        for (items, (&from, &to)) in lists.iter().zip(bounds[0].iter().zip(&bounds[1])) {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(to - from);
            own.copy_from_slice(&items[from..to]);
            rest = others;
        }
        chunk.sort();
    });
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

    #[test]
    fn lists_are_merged() {
        let mut rng = seeded(2);
        for (lists, most) in [(0, 1), (1, 5_000), (2, 300), (3, 2_000), (40, 900), (5, 1 << 15)] {
            // Of many equal elements, all have to stay.
            for key in [3, u32::MAX] {
                let mut random = |most: u32| rng.random_range(0..most);
                let mut lists: Vec<OutputBuffer<TrianglePair>> = (0..lists)
                    .map(|_| {
                        let mut pair = |_| TrianglePair { a: random(key), b: random(key) };
                        let items = (0..most).map(&mut pair).collect();
                        OutputBuffer { items, scratch: Vec::new() }
                    })
                    .collect();
                if let Some(last) = lists.last_mut() {
                    last.items.truncate(7);
                }
                let mut expected: Vec<_> = lists.iter().flat_map(|l| l.items.clone()).collect();
                expected.sort();
                lists.iter_mut().for_each(Output::finish);
                for threads in [1, 2, 16, 64] {
                    let mut out = vec![TrianglePair::default(); 3];
                    merge(&mut lists.clone(), ranges(&lists, threads), &mut out);
                    assert!(
                        out == expected,
                        "{} lists, {most} each, {threads} threads",
                        lists.len()
                    );
                }
            }
        }
    }
}
