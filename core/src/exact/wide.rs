//! Integers of up to N limbs, for determinants of f64 coordinates whose exponents lie far apart.

use core::cmp::Ordering;
use core::ops::{Add, Mul, Sub};

/// An integer by its sign and its magnitude, of which only the first limbs are in use: most values are far shorter than
/// the longest.
///
/// Results must fit N limbs; the caller proves it.
#[derive(Clone, Copy)]
pub(super) struct Wide<const N: usize> {
    /// The magnitude, least significant limb first. Limbs from `len` on are zero.
    limbs: [u64; N],
    len: usize,
    is_negative: bool,
}

/// So many limbs are below the range of f64.
const AS_F64: usize = 14;

impl<const N: usize> Wide<N> {
    const ZERO: Self = Self { limbs: [0; N], len: 0, is_negative: false };

    /// `value · 2^shift`.
    pub(super) fn new(value: i64, shift: u32) -> Self {
        let mut out = Self { is_negative: value < 0, ..Self::ZERO };
        let shifted = u128::from(value.unsigned_abs()) << (shift % 64);
        let from = out.limbs.iter_mut().skip((shift / 64) as usize);
        for (limb, part) in from.zip([shifted as u64, (shifted >> 64) as u64]) {
            *limb = part;
        }
        out.trimmed((shift / 64) as usize + 2)
    }

    /// How many limbs are in use.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The value over a power of two that is the same for all values of up to so many limbs, within 2^-52 of the largest.
    pub(super) fn as_f64(&self, limbs: usize) -> f64 {
        const BASE: f64 = 18_446_744_073_709_551_616.0;
        let first = limbs.saturating_sub(AS_F64);
        let used = self.limbs.iter().skip(first).take(limbs - first);
        let magnitude = used.rev().fold(0.0, |x, &limb| x * BASE + limb as f64);
        if self.is_negative { -magnitude } else { magnitude }
    }

    pub(super) fn sign(&self) -> i32 {
        if self.len == 0 {
            0
        } else if self.is_negative {
            -1
        } else {
            1
        }
    }

    /// The same, with the limbs in use counted; all from `most` on are zero.
    fn trimmed(mut self, most: usize) -> Self {
        let in_use = self.limbs.iter().take(most);
        self.len = most.min(N) - in_use.rev().take_while(|&&limb| limb == 0).count();
        self
    }

    fn cmp_magnitude(&self, other: &Self) -> Ordering {
        let len = self.len.max(other.len);
        self.limbs.iter().take(len).rev().cmp(other.limbs.iter().take(len).rev())
    }

    /// The sum of the magnitudes, with the sign of `self`.
    fn plus_magnitude(mut self, other: &Self) -> Self {
        let most = self.len.max(other.len) + 1;
        let mut carry = false;
        for (x, y) in self.limbs.iter_mut().zip(other.limbs).take(most) {
            let (sum, first) = x.overflowing_add(y);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*x, carry) = (sum, first || second);
        }
        debug_assert!(!carry, "a sum fits N limbs");
        self.trimmed(most)
    }

    /// The difference of the magnitudes, with the sign of `self`, whose magnitude is not less.
    fn minus_magnitude(mut self, other: &Self) -> Self {
        let most = self.len;
        let mut borrow = false;
        for (x, y) in self.limbs.iter_mut().zip(other.limbs).take(most) {
            let (rest, first) = x.overflowing_sub(y);
            let (rest, second) = rest.overflowing_sub(u64::from(borrow));
            (*x, borrow) = (rest, first || second);
        }
        self.trimmed(most)
    }
}

impl<const N: usize> Add for Wide<N> {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        if self.is_negative == other.is_negative {
            self.plus_magnitude(&other)
        } else if self.cmp_magnitude(&other) == Ordering::Less {
            other.minus_magnitude(&self)
        } else {
            self.minus_magnitude(&other)
        }
    }
}

impl<const N: usize> Sub for Wide<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { is_negative: !other.is_negative, ..other }
    }
}

impl<const N: usize> Mul for Wide<N> {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let mut out = Self { is_negative: self.is_negative != other.is_negative, ..Self::ZERO };
        for (i, &x) in self.limbs.iter().take(self.len).enumerate() {
            let mut carry = 0;
            // One limb more takes the last carry.
            let factors = other.limbs.iter().copied().take(other.len).chain([0]);
            for (slot, y) in out.limbs.iter_mut().skip(i).zip(factors) {
                // (2^64 − 1)² + 2 (2^64 − 1) = 2^128 − 1: fits.
                let wide = u128::from(x) * u128::from(y) + u128::from(*slot) + carry;
                *slot = wide as u64;
                carry = wide >> 64;
            }
            debug_assert!(carry == 0, "a product fits N limbs");
        }
        out.trimmed(self.len + other.len)
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
