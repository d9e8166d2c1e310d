//! Outputs of the threads, one each so that no thread waits for a lock. Each thread sorts its own list while it is in its
//! cache, and the sorted lists are merged by all threads.

use crate::workers::for_each;
use pfront_core::bvtt::TrianglePair;
use rayon::ThreadPool;
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

    /// Called by the first thread when it has no more of its own.
    fn finish(&mut self) {}
}

/// The list that one thread makes, or several one after the other: sorted runs, and what came after the last.
#[derive(Clone, Debug, Default)]
pub struct OutputBuffer<T> {
    items: Vec<T>,
    /// The ends of the runs.
    ends: Vec<usize>,
    scratch: Vec<T>,
}

impl<T> OutputBuffer<T> {
    pub(crate) fn clear(&mut self) {
        self.items.clear();
        self.ends.clear();
    }

    fn is_finished(&self) -> bool {
        self.ends.last().copied().unwrap_or(0) == self.items.len()
    }

    /// The sorted runs, of which none is empty.
    fn runs(&self) -> impl Iterator<Item = &[T]> {
        let begins = std::iter::once(&0).chain(&self.ends);
        begins.zip(&self.ends).map(|(&begin, &end)| &self.items[begin..end])
    }
}

impl<T: Item> Output for OutputBuffer<T> {
    #[inline]
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        self.items.push(T::new(query, pair));
        ControlFlow::Continue(())
    }

    fn finish(&mut self) {
        let begin = self.ends.last().copied().unwrap_or(0);
        let (end, run) = (self.items.len(), &mut self.items[begin..]);
        if !run.is_empty() {
            sort(run, &mut self.scratch);
            self.ends.push(end);
        }
    }
}

impl Output for u64 {
    #[inline]
    fn take(&mut self, _: u32, _: TrianglePair) -> ControlFlow<()> {
        *self += 1;
        ControlFlow::Continue(())
    }
}

impl Output for Option<Hit> {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        *self = Some(Hit { query, pair });
        ControlFlow::Break(())
    }
}

/// Hands pairs to the caller.
pub(crate) struct Visitor<'v, V>(pub(crate) &'v V);

impl<V: Fn(Hit) -> ControlFlow<()> + Sync> Output for Visitor<'_, V> {
    fn take(&mut self, query: u32, pair: TrianglePair) -> ControlFlow<()> {
        (self.0)(Hit { query, pair })
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

/// Elements that one thread sorts in the time that it takes to call others three times, some 40 us.
const SORTED_ALONE: usize = 4096;

/// The fewest elements of a range, which take about as long to merge as it takes to call another thread that is awake.
const RANGE: usize = 512;

/// Samples of all runs together for each range. With more of them ranges are more alike, and sorting the samples, which
/// one thread does, takes longer.
const SAMPLES: usize = 16;

/// Replaces the contents of `out` by those of some lists, sorted, on so many threads of a pool.
///
/// Each thread merges a range. The ranges come from regular samples of the runs, so that they are nearly alike
/// (Shi & Schaeffer, *Parallel Sorting by Regular Sampling*, 1992).
pub(crate) fn merge<T: Item>(
    lists: &mut [OutputBuffer<T>],
    threads: usize,
    pool: Option<&ThreadPool>,
    out: &mut Vec<T>,
) {
    let len: usize = lists.iter().map(|list| list.items.len()).sum();
    if len < SORTED_ALONE {
        out.clear();
        lists.iter().for_each(|list| out.extend_from_slice(&list.items));
        lists.first_mut().into_iter().for_each(|list| sort(out, &mut list.scratch));
        return;
    }
    for_each(pool, lists.iter_mut().filter(|list| !list.is_finished()), Output::finish);
    if let Some(only) = lists.iter_mut().find(|list| list.items.len() == len && list.ends.len() < 2)
    {
        std::mem::swap(out, &mut only.items);
        return;
    }
    let ranges = threads.clamp(1, len / RANGE);
    let runs = || lists.iter().flat_map(OutputBuffer::runs);
    let step = (len / (ranges * SAMPLES)).max(1);
    let mut samples: Vec<T> =
        runs().flat_map(|items| items.iter().step_by(step)).copied().collect();
    samples.sort_unstable();
    let first = |range: usize| samples[range * samples.len() / ranges];
    // Each run with the ends of its part of each range.
    let mut runs: Vec<(&[T], Vec<usize>)> = runs().map(|items| (items, Vec::new())).collect();
    for_each(pool, &mut runs, |(items, ends)| {
        ends.extend((1..ranges).map(|next| items.partition_point(|item| *item < first(next))));
        ends.push(items.len());
    });
    out.resize(len, T::default());
    let (mut rest, mut begin, mut chunks) = (&mut out[..], 0, Vec::with_capacity(ranges));
    for range in 0..ranges {
        let end: usize = runs.iter().map(|(_, ends)| ends[range]).sum();
        let (chunk, others) = std::mem::take(&mut rest).split_at_mut(end - begin);
        chunks.push((chunk, range));
        (rest, begin) = (others, end);
    }
    for_each(pool, chunks, |(chunk, range)| {
        let mut rest = &mut chunk[..];
        for (items, ends) in &runs {
            let from = range.checked_sub(1).map_or(0, |before| ends[before]);
            let (own, others) = std::mem::take(&mut rest).split_at_mut(ends[range] - from);
            own.copy_from_slice(&items[from..ends[range]]);
            rest = others;
        }
        chunk.sort();
    });
}

/// Sorts a list that may be sorted already.
fn sort<T: Item>(items: &mut [T], scratch: &mut Vec<T>) {
    if items.len() < RADIX_FROM {
        items.sort_unstable();
    } else if !items.is_sorted() {
        radix_sort(items, scratch);
    }
}

/// Sorts by one byte of the key after the other, from the least on, leaving out those in which all keys agree.
fn radix_sort<T: Item>(items: &mut [T], scratch: &mut Vec<T>) {
    let bits = |(any, all), item: &T| (any | item.key(), all & item.key());
    let (any, all) = items.iter().fold((0, u128::MAX), bits);
    scratch.resize(items.len(), T::default());
    let (mut from, mut to) = (items, &mut scratch[..]);
    let mut is_in_scratch = false;
    for shift in (0..128).step_by(8).filter(|shift| (any ^ all) >> shift & 255 != 0) {
        let byte = |item: &T| (item.key() >> shift) as usize & 255;
        let mut ends = [0; 256];
        from.iter().for_each(|item| ends[byte(item)] += 1);
        let mut sum = 0;
        ends.iter_mut().for_each(|end| sum += std::mem::replace(end, sum));
        for item in from.iter() {
            let place = &mut ends[byte(item)];
            to[*place] = *item;
            *place += 1;
        }
        std::mem::swap(&mut from, &mut to);
        is_in_scratch = !is_in_scratch;
    }
    if is_in_scratch {
        to.copy_from_slice(from);
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
            // All of many equal elements have to stay.
            for key in [3, u32::MAX] {
                let mut random = |most: u32| rng.random_range(0..most);
                let mut expected = Vec::new();
                let mut made = vec![OutputBuffer::<TrianglePair>::default(); lists];
                for (i, list) in made.iter_mut().enumerate() {
                    // Several runs, one of them empty; the last list is short.
                    let last = if i + 1 == lists { 7 } else { most };
                    for count in [last, 0, 3] {
                        for _ in 0..count {
                            let pair = TrianglePair { a: random(key), b: random(key) };
                            assert!(list.take(0, pair).is_continue());
                            expected.push(pair);
                        }
                        list.finish();
                    }
                }
                expected.sort();
                for threads in [1, 2, 16, 64] {
                    let mut out = vec![TrianglePair::default(); 3];
                    merge(&mut made.clone(), threads, None, &mut out);
                    assert!(out == expected, "{lists} lists, {most} each, {threads} threads");
                }
            }
        }
    }
}
