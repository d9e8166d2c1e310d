//! Integers of N limbs, for determinants of coordinates whose exponents lie far apart.

use core::ops::{Add, Mul, Sub};

/// An integer by its sign and its magnitude, most of which are far shorter than the longest.
///
/// Results must fit N limbs; the caller proves it.
#[derive(Clone, Copy)]
pub(super) struct Wide<const N: usize> {
    /// The magnitude, least significant limb first.
    limbs: [u64; N],
    /// The sign, which means nothing in zero.
    is_negative: bool,
}

/// So many limbs are below the range of f64.
const AS_F64: usize = 14;

impl<const N: usize> Wide<N> {
    /// `value · 2^shift`.
    pub(super) fn new(value: i64, shift: u32) -> Self {
        let mut limbs = [0; N];
        let shifted = u128::from(value.unsigned_abs()) << (shift % 64);
        let from = limbs.iter_mut().skip((shift / 64) as usize);
        for (limb, part) in from.zip([shifted as u64, (shifted >> 64) as u64]) {
            *limb = part;
        }
        Self { limbs, is_negative: value < 0 }
    }

    /// The same in M limbs, of which there are no fewer.
    #[cfg(feature = "relation")]
    pub(super) fn widened<const M: usize>(self) -> Wide<M> {
        let mut limbs = [0; M];
        limbs[..N].copy_from_slice(&self.limbs);
        Wide { limbs, is_negative: self.is_negative }
    }

    /// How many limbs are in use.
    pub(super) fn len(&self) -> usize {
        N - self.limbs.iter().rev().take_while(|&&limb| limb == 0).count()
    }

    /// The value over a power of two that is the same for all values of up to so many limbs, within 2^-49 of the largest.
    pub(super) fn as_f64(&self, limbs: usize) -> f64 {
        const BASE: f64 = 18_446_744_073_709_551_616.0;
        let first = limbs.saturating_sub(AS_F64);
        let used = self.limbs.iter().skip(first).take(limbs - first);
        let magnitude = used.rev().fold(0.0, |x, &limb| x * BASE + limb as f64);
        if self.is_negative { -magnitude } else { magnitude }
    }

    /// The sum, or the difference. By reference, since copies of both would take as long as the sum.
    #[inline(never)]
    fn sum(&self, other: &Self, is_subtracted: bool) -> Self {
        let is_negative = other.is_negative != is_subtracted;
        let differ = self.is_negative != is_negative;
        // Most limbs of most numbers are zero.
        let len = self.len().max(other.len());
        let is_less =
            differ && self.limbs.iter().take(len).rev().lt(other.limbs.iter().take(len).rev());
        let (mut sum, other) =
            if is_less { (Self { is_negative, ..*other }, self) } else { (*self, other) };
        // The identity !x = −x − 1 makes a sum of the difference of the magnitudes.
        let flip = if differ { u64::MAX } else { 0 };
        let mut carry = false;
        let mut limbs = sum.limbs.iter_mut();
        for (x, y) in limbs.by_ref().take(len).zip(&other.limbs) {
            let (next, first) = (*x ^ flip).overflowing_add(*y);
            let (next, second) = next.overflowing_add(u64::from(carry));
            (*x, carry) = (next ^ flip, first || second);
        }
        if carry {
            let next = limbs.next();
            debug_assert!(next.is_some(), "a sum fits N limbs");
            next.into_iter().for_each(|next| *next = 1);
        }
        sum
    }

    #[inline(never)]
    fn product(&self, other: &Self) -> Self {
        let mut limbs = [0; N];
        let len = other.len();
        for (i, &x) in self.limbs.iter().enumerate().filter(|(_, x)| **x != 0) {
            let mut carry = 0;
            // One limb more takes the last carry.
            let factors = other.limbs.iter().copied().take(len).chain([0]);
            for (slot, y) in limbs.iter_mut().skip(i).zip(factors) {
                // (2^64 − 1)² + 2 (2^64 − 1) = 2^128 − 1: fits.
                let wide = u128::from(x) * u128::from(y) + u128::from(*slot) + carry;
                *slot = wide as u64;
                carry = wide >> 64;
            }
            debug_assert!(carry == 0, "a product fits N limbs");
        }
        Self { limbs, is_negative: self.is_negative != other.is_negative }
    }

    pub(super) fn sign(&self) -> i32 {
        match (self.len(), self.is_negative) {
            (0, _) => 0,
            (_, true) => -1,
            (_, false) => 1,
        }
    }
}

impl<const N: usize> Add for Wide<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.sum(&other, false)
    }
}

impl<const N: usize> Sub for Wide<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.sum(&other, true)
    }
}

impl<const N: usize> Mul for Wide<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.product(&other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_i128() {
        let values = [0_i64, 1, -1, 7, -12_345, (1 << 24) - 1, -(1 << 24) + 1];
        for x in values {
            for y in values {
                for shift in [0, 1, 31, 63] {
                    let (wide, other, one) =
                        (Wide::<14>::new(x, shift), Wide::<14>::new(y, 3), Wide::<14>::new(1, 0));
                    let (x, y) = (i128::from(x) << shift, i128::from(y) << 3);
                    assert_eq!((wide + other).sign(), (x + y).signum() as i32);
                    assert_eq!((wide - other).sign(), (x - y).signum() as i32);
                    assert_eq!((wide * other - one).sign(), (x * y - 1).signum() as i32);
                    assert_eq!((wide * other).as_f64(14), (x * y) as f64);
                }
            }
        }
    }

    #[test]
    fn carries_run_through_every_limb() {
        let (top, one) = (Wide::<14>::new(1, 800), Wide::<14>::new(1, 0));
        assert_eq!((top - one + one - top).sign(), 0);
        assert_eq!((top - one).sign(), 1);
        assert_eq!((one - top + top - one).sign(), 0);
        assert_eq!((Wide::<14>::new(-1, 400) * Wide::<14>::new(-1, 400) - top).sign(), 0);
        assert_eq!(Wide::<14>::new(-3, 700).as_f64(14), -3.0 * 2f64.powi(700));
        assert_eq!((top - one).as_f64(14), 2f64.powi(800));
    }
}
