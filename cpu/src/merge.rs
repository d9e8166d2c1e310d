//! Sorted lists out of the lists of the threads.
//!
//! Each thread sorts a list, and merges a range of all. The ranges come from regular samples of the lists, so that they are
//! nearly alike (Shi & Schaeffer, *Parallel Sorting by Regular Sampling*, 1992).

use crate::memory::{reserve, resize};
use crate::output::{Item, Output, OutputBuffer};
use crate::sort::{SORTED_ALONE, sort};
use crate::{MemoryError, Pool};
use std::mem::take;

/// The fewest elements of a range, which take about as long to merge as it takes to call another thread that is awake.
const RANGE: usize = 512;

/// Samples of all lists together for each range. With more of them ranges are more alike, and sorting the samples, which
/// one thread does, takes longer.
const SAMPLES: usize = 16;

/// Replaces the contents of `out` by those of some lists, sorted, on so many threads of a pool.
///
/// # Errors
/// [`MemoryError`] if `out`, or the memory to merge in, cannot grow.
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
        lists.first_mut().into_iter().for_each(|list| sort(out, &mut list.scratch, T::key));
        return Ok(());
    }
    // Threads of a divided frame have sorted theirs.
    if lists.iter().any(|list| list.sorted < list.items.len()) {
        pool.for_each(&mut *lists, Output::finish);
    }
    if let Some(only) = lists.iter_mut().find(|list| list.items.len() == len) {
        std::mem::swap(out, &mut only.items);
        return Ok(());
    }
    resize(out, len)?;
    let mut scratch = take(&mut lists[0].scratch);
    resize(&mut scratch, len)?;
    let merged = merge_lists(lists, threads, pool, out, &mut scratch);
    lists[0].scratch = scratch;
    merged
}

/// Merges sorted lists into `out`, which is as long as all of them together, as is `scratch`.
fn merge_lists<T: Item>(
    lists: &[OutputBuffer<T>],
    threads: usize,
    pool: &Pool,
    out: &mut [T],
    scratch: &mut [T],
) -> Result<(), MemoryError> {
    let len = out.len();
    let ranges = threads.clamp(1, len / RANGE);
    let step = (len / (ranges * SAMPLES)).max(1);
    let mut samples: Vec<T> = Vec::new();
    reserve(&mut samples, len / step + lists.len())?;
    samples.extend(lists.iter().flat_map(|list| list.items.iter().step_by(step)));
    samples.sort_unstable();
    let first = |range: usize| samples[range * samples.len() / ranges];
    // For each list the ends of its part of each range.
    let mut ends = Vec::new();
    resize(&mut ends, ranges * lists.len())?;
    pool.for_each(lists.iter().zip(ends.chunks_exact_mut(ranges)), |(list, ends)| {
        for (range, end) in (1..ranges).zip(&mut *ends) {
            *end = list.items.partition_point(|item| *item < first(range));
        }
        ends[ranges - 1] = list.items.len();
    });
    // The parts of a range, an empty one for each list without any.
    let mut parts: Vec<&[T]> = Vec::new();
    reserve(&mut parts, ends.len())?;
    for range in 0..ranges {
        parts.extend(lists.iter().zip(ends.chunks_exact(ranges)).map(|(list, ends)| {
            &list.items[range.checked_sub(1).map_or(0, |before| ends[before])..ends[range]]
        }));
    }
    let (mut rest, mut rest_of_scratch) = (out, scratch);
    let chunks = parts.chunks_exact(lists.len()).map(|parts| {
        let size = parts.iter().map(|part| part.len()).sum();
        let (chunk, others) = take(&mut rest).split_at_mut(size);
        let (scratch, more) = take(&mut rest_of_scratch).split_at_mut(size);
        (rest, rest_of_scratch) = (others, more);
        (parts, chunk, scratch)
    });
    pool.for_each(chunks, |(parts, chunk, scratch)| merge_parts(parts, chunk, scratch));
    Ok(())
}

/// Merges sorted parts, two at a time, into `out`, which is as long as all of them together, as is `scratch`.
fn merge_parts<T: Item>(parts: &[&[T]], out: &mut [T], scratch: &mut [T]) {
    match parts {
        [] => {}
        [only] => out.copy_from_slice(only),
        [a, b] => merge_two(a, b, out),
        _ => {
            let (left, right) = parts.split_at(parts.len() / 2);
            let middle = left.iter().map(|part| part.len()).sum();
            let (a, b) = scratch.split_at_mut(middle);
            let (scratch_a, scratch_b) = out.split_at_mut(middle);
            merge_parts(left, a, scratch_a);
            merge_parts(right, b, scratch_b);
            merge_two(a, b, out);
        }
    }
}

/// Merges two sorted lists. The choice between two items is no branch, since it could not be predicted.
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

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::bvtt::TrianglePair;
    use pfront_testkit::rng::{RngExt, seeded};

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
                    // The last list is short.
                    let last = if i + 1 == lists { 7 } else { most };
                    for _ in 0..last {
                        let pair = TrianglePair { a: random(key), b: random(key) };
                        assert!(list.add(0, pair).is_continue());
                        expected.push(pair);
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
