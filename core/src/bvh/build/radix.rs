//! Sorting 64-bit keys by their upper bits.
//!
//! Stable counting sorts from the lowest digit to the highest (LSD radix sort). Many keys are divided into buckets by
//! their highest digit before, so that the other digits are sorted within the cache and side by side. To fill buckets
//! side by side, each of several runs of keys is sorted by bucket for itself.

use crate::parallel::{GRAIN, Join, both, each, split};
use crate::simd::VECTORS;
use core::array::from_fn;
use core::iter::once;
use core::mem::replace;
use core::ops::Range;

/// Two digits of 10 bits, whose counters take 4 KiB, and one of the 7 bits that are left of a code.
const DIGIT_BITS: u32 = 10;
const DIGITS: usize = 1 << DIGIT_BITS;
const BUCKET_BITS: u32 = 7;
const BUCKETS: usize = 1 << BUCKET_BITS;
/// Runs of keys, of which each may have a thread. A policy: their counters take 8 KiB of stack.
const RUNS: usize = 16;

/// The bits that keys are sorted by.
pub(super) const BITS: u32 = 2 * DIGIT_BITS + BUCKET_BITS;

/// The most keys for which counting digits does not pay: to insert each moves a quarter of their square, as many as a digit has
/// counters.
const FEW: usize = 64;

/// Sorts distinct keys, which are in ascending order of their lowest `lowest` bits, by the [`BITS`] above. Moves them to
/// `to`, which is as long, and leaves anything in `from`.
pub(super) fn sort(from: &mut [u64], to: &mut [u64], lowest: u32, join: Option<&Join<'_>>) {
    if from.len() <= FEW {
        for (to, &from) in to.iter_mut().zip(&*from) {
            *to = from;
        }
        return insert_each(to);
    }
    // Firmware, which has no vectors, has no meshes so large either.
    if VECTORS && from.len() > 8 * GRAIN {
        return sort_buckets(from, to, lowest, join);
    }
    sort_digit(once(&*from), to, lowest);
    sort_digit(once(&*to), from, lowest + DIGIT_BITS);
    sort_digit(once(&*from), to, lowest + 2 * DIGIT_BITS);
}

fn insert_each(keys: &mut [u64]) {
    for end in 1..keys.len() {
        for i in (0..end).rev() {
            if keys[i] <= keys[i + 1] {
                break;
            }
            keys.swap(i, i + 1);
        }
    }
}

#[inline(never)]
fn sort_buckets(from: &mut [u64], to: &mut [u64], lowest: u32, join: Option<&Join<'_>>) {
    let length = from.len().div_ceil(RUNS);
    let mut ends = [[0; BUCKETS]; RUNS];
    let mut chunks = from.chunks(length).zip(to.chunks_mut(length)).zip(&mut ends);
    let mut runs: [_; RUNS] = from_fn(|_| chunks.next());
    each(join, &mut runs, &|run| {
        if let Some(((from, to), ends)) = run {
            sort_into(ends, once(*from), to, lowest + 2 * DIGIT_BITS);
        }
    });
    let range = |run: usize, bucket: usize| {
        let ends = &ends[run];
        let start = if bucket == 0 { 0 } else { ends[bucket - 1] };
        start as usize..ends[bucket] as usize
    };
    let buckets = Buckets {
        join,
        sizes: from_fn(|bucket| (0..RUNS).map(|run| range(run, bucket).len()).sum()),
    };
    // While runs are read, nothing is written to `to`.
    buckets.each(0..BUCKETS, from, &mut [], &|bucket, keys, _| {
        let runs = to.chunks(length).enumerate();
        sort_digit(runs.map(|(run, keys)| &keys[range(run, bucket)]), keys, lowest);
    });
    buckets.each(0..BUCKETS, from, to, &|_, from, to| {
        sort_digit(once(&*from), to, lowest + DIGIT_BITS);
    });
}

/// Work on one bucket, by its number, in two slices of keys.
type BucketTask<'t> = dyn Fn(usize, &mut [u64], &mut [u64]) + Sync + 't;

struct Buckets<'b> {
    join: Option<&'b Join<'b>>,
    sizes: [usize; BUCKETS],
}

impl Buckets<'_> {
    /// Calls `task` on each bucket in two slices.
    fn each(&self, buckets: Range<usize>, a: &mut [u64], b: &mut [u64], task: &BucketTask<'_>) {
        if buckets.len() == 1 {
            return task(buckets.start, a, b);
        }
        let middle = buckets.start + buckets.len() / 2;
        let size = self.sizes[buckets.start..middle].iter().sum();
        // The second slice may be empty.
        let ((a, right_a), (b, right_b)) = (a.split_at_mut(size), split(b, size));
        both(
            self.join,
            || self.each(buckets.start..middle, a, b, task),
            || self.each(middle..buckets.end, right_a, right_b, task),
        );
    }
}

#[inline(never)]
fn sort_digit<'k>(from: impl Iterator<Item = &'k [u64]> + Clone, to: &mut [u64], lowest: u32) {
    sort_into(&mut [0; DIGITS], from, to, lowest);
}

/// One stable counting sort. Leaves in `ends`, which are 0, where the keys of each digit end.
#[inline(always)]
fn sort_into<'k, const DIGITS: usize>(
    ends: &mut [u32; DIGITS],
    from: impl Iterator<Item = &'k [u64]> + Clone,
    to: &mut [u64],
    lowest: u32,
) {
    let digit = |key: u64| key.unbounded_shr(lowest) as usize % DIGITS;
    for keys in from.clone() {
        for &key in keys {
            ends[digit(key)] += 1;
        }
    }
    let mut start = 0;
    for end in ends.iter_mut() {
        start += replace(end, start);
    }
    for keys in from {
        for &key in keys {
            let next = &mut ends[digit(key)];
            if let Some(slot) = to.get_mut(*next as usize) {
                *slot = key;
            }
            *next += 1;
        }
    }
}
