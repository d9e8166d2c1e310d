//! Sorting keys by a range of their bits, side by side.
//!
//! Many keys are first dealt out to buckets by their highest bits, then each bucket by the next ones,
//! until one is small enough for counting sorts within the cache. To deal side by side into one array,
//! runs of the keys are counted first, and each gets a slice of its own in every bucket. Everything is
//! stable: keys that agree in those bits keep their order.

use super::parts::{Parts, worth_dividing};
use crate::index::split;
use core::array::from_fn;
use core::mem::{swap, take};
use core::ops::Range;

/// Bits by which keys are dealt to buckets: with a slice for each run and bucket, 24 KiB of stack.
const BUCKET_BITS: u32 = 6;
const BUCKETS: usize = 1 << BUCKET_BITS;
const RUNS: usize = 16;

/// The most bits of one counting sort.
const DIGIT_BITS: u32 = 11;

/// Up to so many keys, no table of digits pays.
const FEW: usize = 32;

/// Sorts `keys` by those bits. `spare` is as long and left with anything.
pub(super) fn sort(keys: &mut [u64], spare: &mut [u64], bits: Range<u32>, parts: Parts<'_>) {
    sort_to(keys, spare, bits, parts, true);
}

/// Leaves the sorted keys where they were, or else in `there`.
fn sort_to(here: &mut [u64], there: &mut [u64], bits: Range<u32>, parts: Parts<'_>, stay: bool) {
    if !worth_dividing(here.len()) || bits.is_empty() {
        return sort_small(here, there, bits, stay);
    }
    let lowest = bits.end - BUCKET_BITS.min(bits.end - bits.start);
    let sizes = deal(here, there, lowest, parts);
    let buckets = Buckets { bits: bits.start..lowest, parts, stay: !stay };
    buckets.sort(there, here, &sizes);
}

/// What is still to be done to each bucket.
struct Buckets<'b> {
    bits: Range<u32>,
    parts: Parts<'b>,
    stay: bool,
}

impl Buckets<'_> {
    fn sort(&self, here: &mut [u64], there: &mut [u64], sizes: &[usize]) {
        if let [_] = sizes {
            return sort_to(here, there, self.bits.clone(), self.parts, self.stay);
        }
        let (left, right) = sizes.split_at(sizes.len() / 2);
        let middle = left.iter().sum();
        let (left_here, right_here) = split(here, middle);
        let (left_there, right_there) = split(there, middle);
        self.parts.both(
            left_here.len() + right_here.len(),
            || self.sort(left_here, left_there, left),
            || self.sort(right_here, right_there, right),
        );
    }
}

/// Deals keys out by [`BUCKET_BITS`] from the `lowest` on; returns how many each bucket got.
///
/// The bits above are the same for all keys. Apart, so that few keys do without its 24 KiB of stack.
#[inline(never)]
fn deal(from: &[u64], to: &mut [u64], lowest: u32, parts: Parts<'_>) -> [usize; BUCKETS] {
    let dealer = Dealer { lowest, run: from.len().div_ceil(RUNS), parts };
    let mut counts = [[0; BUCKETS]; RUNS];
    dealer.count(from, &mut counts);
    // A constant is written in its place; what a closure makes is copied there, out of as much stack again.
    let mut slices = [const { [const { None }; BUCKETS] }; RUNS];
    let mut rest = to;
    for bucket in 0..BUCKETS {
        for run in 0..RUNS {
            let (slice, others) = split(take(&mut rest), counts[run][bucket]);
            (slices[run][bucket], rest) = (Some(slice), others);
        }
    }
    dealer.write(from, &mut slices);
    from_fn(|bucket| counts.iter().map(|run| run[bucket]).sum())
}

struct Dealer<'d> {
    lowest: u32,
    /// Keys of one run; the last may have fewer.
    run: usize,
    parts: Parts<'d>,
}

impl Dealer<'_> {
    fn bucket(&self, key: u64) -> usize {
        (key >> self.lowest) as usize % BUCKETS
    }

    fn count(&self, from: &[u64], counts: &mut [[usize; BUCKETS]]) {
        if let [counts] = counts {
            return from.iter().for_each(|&key| counts[self.bucket(key)] += 1);
        }
        let (left, right) = self.halves(from, counts.len());
        let (left_counts, right_counts) = counts.split_at_mut(counts.len() / 2);
        self.parts.both(
            from.len(),
            || self.count(left, left_counts),
            || self.count(right, right_counts),
        );
    }

    fn write(&self, from: &[u64], slices: &mut [[Option<&mut [u64]>; BUCKETS]]) {
        if let [slices] = slices {
            let slices = slices.each_mut().map(|slice| slice.take().unwrap_or_default());
            let mut used = [0; BUCKETS];
            for &key in from {
                let bucket = self.bucket(key);
                if let Some(slot) = slices[bucket].get_mut(used[bucket]) {
                    *slot = key;
                }
                used[bucket] += 1;
            }
            return;
        }
        let (left, right) = self.halves(from, slices.len());
        let (left_slices, right_slices) = slices.split_at_mut(slices.len() / 2);
        self.parts.both(
            from.len(),
            || self.write(left, left_slices),
            || self.write(right, right_slices),
        );
    }

    /// The keys of the first half of so many runs, and the others.
    fn halves<'k>(&self, from: &'k [u64], runs: usize) -> (&'k [u64], &'k [u64]) {
        from.split_at((runs / 2 * self.run).min(from.len()))
    }
}

/// Counting sorts from the lowest digit to the highest; few keys take their places one by one.
fn sort_small(here: &mut [u64], there: &mut [u64], bits: Range<u32>, stay: bool) {
    if here.len() <= FEW {
        let keys = if stay {
            here
        } else {
            for (to, &from) in there.iter_mut().zip(&*here) {
                *to = from;
            }
            there
        };
        return insert_each(keys, bits);
    }
    // As few as there can be that end in the right place. A digit of no bits just copies.
    let width = bits.end - bits.start;
    let fewest = width.div_ceil(DIGIT_BITS);
    let passes = if fewest.is_multiple_of(2) == stay { fewest } else { fewest + 1 };
    let digit_bits = width.div_ceil(passes.max(1));
    let (mut from, mut to) = (here, there);
    for pass in 0..passes {
        let lowest = bits.start + (pass * digit_bits).min(width);
        sort_pass(from, to, lowest, digit_bits.min(bits.end - lowest));
        (from, to) = (to, from);
    }
}

/// A stable insertion sort.
fn insert_each(keys: &mut [u64], bits: Range<u32>) {
    let mask = !u64::MAX.unbounded_shl(bits.end - bits.start);
    let part = |key: u64| key.unbounded_shr(bits.start) & mask;
    for end in 1..=keys.len() {
        let mut run = keys.get_mut(..end).unwrap_or_default();
        while let Some((last, rest)) = run.split_last_mut()
            && let Some(before) = rest.last_mut()
            && part(*before) > part(*last)
        {
            swap(before, last);
            run = rest;
        }
    }
}

/// One stable counting sort by so many bits from the `lowest` on. Apart, so that what comes after does
/// without its 8 KiB of stack.
#[inline(never)]
fn sort_pass(from: &[u64], to: &mut [u64], lowest: u32, bits: u32) {
    const DIGITS: usize = 1 << DIGIT_BITS;
    let mask = (1 << bits) - 1;
    let digit = |key: u64| (key.unbounded_shr(lowest) & mask) as usize % DIGITS;
    let mut ends = [0_u32; DIGITS];
    for &key in from {
        ends[digit(key)] += 1;
    }
    let mut start = 0;
    for end in ends.iter_mut().take(1 << bits) {
        start += core::mem::replace(end, start);
    }
    for &key in from {
        let next = &mut ends[digit(key)];
        if let Some(slot) = to.get_mut(*next as usize) {
            *slot = key;
        }
        *next += 1;
    }
}
