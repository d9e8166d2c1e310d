//! Integers of 896 bits, wide enough for every determinant of finite f32 coordinates.

use core::ops::{Add, Mul, Not, Sub};

/// A two's complement integer of 14 limbs, least significant first.
///
/// In units of the smallest f32 a difference of two finite f32 is below 2^278 (24 bits of significand,
/// exponents 253 apart, one bit for the difference), so a sum of six products of three is below 2^837:
/// nothing here can overflow.
#[derive(Clone, Copy)]
pub(super) struct Int896([u64; LIMBS]);

const LIMBS: usize = 14;

impl Int896 {
    const ZERO: Self = Self([0; LIMBS]);

    /// `value · 2^shift`; `value` is a 24-bit significand with its sign.
    pub(super) fn new(value: i64, shift: u32) -> Self {
        let mut limbs = [0; LIMBS];
        let shifted = u128::from(value.unsigned_abs()) << (shift % 64);
        let from = limbs.iter_mut().skip((shift / 64) as usize);
        for (limb, part) in from.zip([shifted as u64, (shifted >> 64) as u64]) {
            *limb = part;
        }
        if value < 0 { Self::ZERO - Self(limbs) } else { Self(limbs) }
    }

    pub(super) fn sign(self) -> i32 {
        if self.is_negative() { -1 } else { i32::from(self.0.iter().any(|&limb| limb != 0)) }
    }

    /// The nearest f64 within a relative 2^-49: one rounding a limb.
    pub(super) fn to_f64(self) -> f64 {
        const BASE: f64 = 18_446_744_073_709_551_616.0;
        let magnitude = if self.is_negative() { Self::ZERO - self } else { self };
        let value = magnitude.0.iter().rev().fold(0.0, |x, &limb| x * BASE + limb as f64);
        if self.is_negative() { -value } else { value }
    }

    fn is_negative(self) -> bool {
        self.0[LIMBS - 1] >> 63 != 0
    }
}

impl Not for Int896 {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|limb| !limb))
    }
}

impl Add for Int896 {
    type Output = Self;
    #[inline(never)]
    fn add(mut self, other: Self) -> Self {
        let mut carry = false;
        for (x, y) in self.0.iter_mut().zip(other.0) {
            let (sum, first) = x.overflowing_add(y);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*x, carry) = (sum, first || second);
        }
        self
    }
}

impl Sub for Int896 {
    type Output = Self;
    /// The identity !x = −x − 1 makes a sum of the difference.
    fn sub(self, other: Self) -> Self {
        !(!self + other)
    }
}

impl Mul for Int896 {
    type Output = Self;
    /// The product modulo 2^896, which two's complement makes right for either sign.
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let mut out = [0; LIMBS];
        for (i, &x) in self.0.iter().enumerate().filter(|(_, x)| **x != 0) {
            let mut carry = 0;
            for (slot, &y) in out.iter_mut().skip(i).zip(&other.0) {
                // (2^64 − 1)² + 2 (2^64 − 1) = 2^128 − 1: fits.
                let wide = u128::from(x) * u128::from(y) + u128::from(*slot) + carry;
                *slot = wide as u64;
                carry = wide >> 64;
            }
        }
        Self(out)
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
                        (Int896::new(x, shift), Int896::new(y, 3), Int896::new(1, 0));
                    let (x, y) = (i128::from(x) << shift, i128::from(y) << 3);
                    assert_eq!((wide + other).sign(), (x + y).signum() as i32);
                    assert_eq!((wide - other).sign(), (x - y).signum() as i32);
                    assert_eq!((wide * other - one).sign(), (x * y - 1).signum() as i32);
                    assert_eq!((wide * other).to_f64(), (x * y) as f64);
                }
            }
        }
    }

    #[test]
    fn carries_run_through_every_limb() {
        let (top, one) = (Int896::new(1, 800), Int896::new(1, 0));
        assert_eq!((top - one + one - top).sign(), 0);
        assert_eq!((top - one).sign(), 1);
        assert_eq!((one - top + top - one).sign(), 0);
        assert_eq!((Int896::new(-1, 400) * Int896::new(-1, 400) - top).sign(), 0);
        assert_eq!(Int896::new(-3, 700).to_f64(), -3.0 * 2f64.powi(700));
        assert_eq!((top - one).to_f64(), 2f64.powi(800));
    }
}
