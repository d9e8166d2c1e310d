//! Sorting 64-bit keys by their upper bits.
//!
//! Stable counting sorts from the lowest digit to the highest (LSD radix sort); few keys are inserted one by one.

use core::mem::replace;

const DIGIT_BITS: u32 = 9;
const DIGITS: usize = 1 << DIGIT_BITS;

/// The bits that keys are sorted by: three digits.
pub(super) const BITS: u32 = 3 * DIGIT_BITS;

/// Up to so many keys, counting digits does not pay.
const FEW: usize = 64;

/// Sorts distinct keys, which are in ascending order of their lowest `lowest` bits, by the [`BITS`] above. Moves them to
/// `to`, which is as long, and leaves anything in `from`.
pub(super) fn sort(from: &mut [u64], to: &mut [u64], lowest: u32) {
    if from.len() <= FEW {
        for (to, &from) in to.iter_mut().zip(&*from) {
            *to = from;
        }
        return insert_each(to);
    }
    sort_digit(from, to, lowest);
    sort_digit(to, from, lowest + DIGIT_BITS);
    sort_digit(from, to, lowest + 2 * DIGIT_BITS);
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

/// One stable counting sort.
#[inline(never)]
fn sort_digit(from: &[u64], to: &mut [u64], lowest: u32) {
    let digit = |key: u64| key.unbounded_shr(lowest) as usize % DIGITS;
    let mut ends = [0_u32; DIGITS];
    for &key in from {
        ends[digit(key)] += 1;
    }
    let mut start = 0;
    for end in &mut ends {
        start += replace(end, start);
    }
    for &key in from {
        let next = &mut ends[digit(key)];
        if let Some(slot) = to.get_mut(*next as usize) {
            *slot = key;
        }
        *next += 1;
    }
}
