//! Outputs of the threads, one each so that no thread waits for a lock. Each thread sorts its own list while it is in its
//! cache, and the sorted lists are merged by all threads.

use crate::memory::{reserve, resize};
use crate::{MemoryError, Pool};
use pfront_core::bvtt::TrianglePair;
use pfront_core::environment::Environment;
use std::mem::take;
use std::ops::{ControlFlow, Range};

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

    /// Called once a frame, by the first thread that fills it, when that has no more parts to take. Pairs of threads that fill it
    /// afterwards still come.
    fn finish(&mut self) {}

    /// The error for which it ended the frame.
    fn failure(&self) -> Option<MemoryError> {
        None
    }
}

/// The most sorted runs of a list.
const RUNS: usize = 2;

/// The list that one thread makes, or several one after the other: sorted runs, and what came after the last.
#[derive(Clone, Debug, Default)]
pub struct OutputBuffer<T> {
    items: Vec<T>,
    /// The ends of the first `runs` runs.
    ends: [usize; RUNS],
    runs: usize,
    scratch: Vec<T>,
    failure: Option<MemoryError>,
}

impl<T> OutputBuffer<T> {
    pub(crate) fn clear(&mut self) {
        self.items.clear();
        (self.runs, self.failure) = (0, None);
    }

    fn ends(&self) -> &[usize] {
        &self.ends[..self.runs]
    }

    fn is_finished(&self) -> bool {
        self.ends().last().copied().unwrap_or(0) == self.items.len()
    }

    /// The sorted runs, of which none is empty.
    fn sorted(&self) -> impl Iterator<Item = &[T]> {
        let begins = std::iter::once(&0).chain(self.ends());
        begins.zip(self.ends()).map(|(&begin, &end)| &self.items[begin..end])
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

    fn finish(&mut self) {
        if self.is_finished() {
            return;
        }
        // Where there is no place for another run, the last one becomes longer.
        self.runs = self.runs.min(RUNS - 1);
        let begin = self.ends().last().copied().unwrap_or(0);
        sort(&mut self.items[begin..], &mut self.scratch);
        self.ends[self.runs] = self.items.len();
        self.runs += 1;
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
///
/// # Errors
/// [`MemoryError`] if `out` cannot grow.
pub(crate) fn merge<T: Item>(
    lists: &mut [OutputBuffer<T>],
    threads: usize,
    pool: &Pool,
    out: &mut Vec<T>,
) -> Result<(), MemoryError> {
    let len: usize = lists.iter().map(|list| list.items.len()).sum();
    if len < SORTED_ALONE {
        out.clear();
        reserve(out, len)?;
        lists.iter().for_each(|list| out.extend_from_slice(&list.items));
        lists.first_mut().into_iter().for_each(|list| sort(out, &mut list.scratch));
        return Ok(());
    }
    pool.for_each(lists.iter_mut().filter(|list| !list.is_finished()), Output::finish);
    if let Some(only) = lists.iter_mut().find(|list| list.items.len() == len && list.runs < 2) {
        std::mem::swap(out, &mut only.items);
        return Ok(());
    }
    resize(out, len)?;
    let mut scratch = lists.first_mut().map(|list| take(&mut list.scratch)).unwrap_or_default();
    let merged = merge_lists(lists, threads, pool, out, &mut scratch);
    lists.first_mut().into_iter().for_each(|list| list.scratch = take(&mut scratch));
    merged
}

/// Merges the runs of finished lists into `out`, which is as long as all of them together.
fn merge_lists<T: Item>(
    lists: &[OutputBuffer<T>],
    threads: usize,
    pool: &Pool,
    out: &mut [T],
    scratch: &mut Vec<T>,
) -> Result<(), MemoryError> {
    let len = out.len();
    let ranges = threads.clamp(1, len / RANGE);
    let mut runs: Vec<&[T]> = Vec::new();
    reserve(&mut runs, RUNS * lists.len())?;
    runs.extend(lists.iter().flat_map(OutputBuffer::sorted));
    let step = (len / (ranges * SAMPLES)).max(1);
    let mut samples: Vec<T> = Vec::new();
    reserve(&mut samples, len / step + runs.len())?;
    samples.extend(runs.iter().flat_map(|run| run.iter().step_by(step)));
    samples.sort_unstable();
    let first = |range: usize| samples[range * samples.len() / ranges];
    // For each run the ends of its part of each range.
    let mut ends = Vec::new();
    resize(&mut ends, ranges * runs.len())?;
    pool.for_each(runs.iter().zip(ends.chunks_exact_mut(ranges)), |(run, ends)| {
        for (range, end) in (1..ranges).zip(&mut *ends) {
            *end = run.partition_point(|item| *item < first(range));
        }
        ends[ranges - 1] = run.len();
    });
    let part = |run: usize, range: usize| {
        let ends = &ends[run * ranges..][..ranges];
        &runs[run][range.checked_sub(1).map_or(0, |before| ends[before])..ends[range]]
    };
    // Without it, or where none is needed, as of two runs, ranges are merged or sorted in place.
    if runs.len() > 2 {
        let _ = resize(scratch, len.max(scratch.len()));
    }
    let (mut rest, mut rest_of_scratch) = (out, &mut scratch[..]);
    let chunks = (0..ranges).map(|range| {
        let size: usize = (0..runs.len()).map(|run| part(run, range).len()).sum();
        let (chunk, others) = take(&mut rest).split_at_mut(size);
        let own = size.min(rest_of_scratch.len());
        let (scratch, more) = take(&mut rest_of_scratch).split_at_mut(own);
        (rest, rest_of_scratch) = (others, more);
        (chunk, scratch, range)
    });
    pool.for_each(chunks, |(chunk, scratch, range)| {
        merge_runs(&|run| part(run, range), 0..runs.len(), chunk, scratch);
    });
    Ok(())
}

/// Merges sorted runs, two at a time, into `out`, which is as long as all of them together. Sorts in place where `scratch` is
/// shorter than that.
fn merge_runs<'r, T: Item + 'r>(
    run: &impl Fn(usize) -> &'r [T],
    numbers: Range<usize>,
    out: &mut [T],
    scratch: &mut [T],
) {
    let (begin, middle) = (numbers.start, numbers.start + numbers.len() / 2);
    match numbers.len() {
        0 => {}
        1 => out.copy_from_slice(run(begin)),
        2 => merge_two(run(begin), run(middle), out),
        _ if scratch.len() < out.len() => {
            let mut rest = &mut *out;
            for number in numbers {
                let (own, others) = take(&mut rest).split_at_mut(run(number).len());
                own.copy_from_slice(run(number));
                rest = others;
            }
            out.sort_unstable();
        }
        _ => {
            let left: usize = (begin..middle).map(|number| run(number).len()).sum();
            let (a, b) = scratch[..out.len()].split_at_mut(left);
            let (scratch_a, scratch_b) = out.split_at_mut(left);
            merge_runs(run, begin..middle, a, scratch_a);
            merge_runs(run, middle..numbers.end, b, scratch_b);
            merge_two(a, b, out);
        }
    }
}

/// Merges two sorted runs. The choice between two items is no branch, since it could not be predicted.
fn merge_two<T: Item>(a: &[T], b: &[T], out: &mut [T]) {
    let (mut i, mut j, mut slots) = (0, 0, out.iter_mut());
    while let (Some(x), Some(y)) = (a.get(i), b.get(j))
        && let Some(slot) = slots.next()
    {
        let is_second = y.key() < x.key();
        *slot = if is_second { *y } else { *x };
        i += usize::from(!is_second);
        j += usize::from(is_second);
    }
    slots.into_slice().copy_from_slice(if i < a.len() { &a[i..] } else { &b[j..] });
}

/// Sorts a list that may be sorted already.
fn sort<T: Item>(items: &mut [T], scratch: &mut Vec<T>) {
    if items.len() < RADIX_FROM {
        items.sort_unstable();
    } else if !items.is_sorted() {
        radix_sort(items, scratch);
    }
}

/// Sorts by one byte of the key after the other, from the least on, leaving out those in which all keys agree; by comparison
/// where there is no memory for `scratch`.
fn radix_sort<T: Item>(items: &mut [T], scratch: &mut Vec<T>) {
    let bits = |(any, all), item: &T| (any | item.key(), all & item.key());
    let (any, all) = items.iter().fold((0, u128::MAX), bits);
    if resize(scratch, items.len()).is_err() {
        return items.sort_unstable();
    }
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
                            assert!(list.add(0, pair).is_continue());
                            expected.push(pair);
                        }
                        list.finish();
                    }
                }
                expected.sort();
                for threads in [1, 2, 16, 64] {
                    let mut out = vec![TrianglePair::default(); 3];
                    let merged = merge(&mut made.clone(), threads, &Pool::new(1), &mut out);
                    assert!(
                        merged.is_ok() && out == expected,
                        "{lists} lists, {most} each, {threads} threads"
                    );
                }
            }
        }
    }
}
