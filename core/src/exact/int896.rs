//! Integers of a fixed 896 bits: the last stage of the predicates.

/// A two's complement integer of 14 limbs, least significant first.
///
/// On its lattice a difference of two finite f32 is below 2^278 (24 bits of significand, exponents
/// 253 apart, one bit for the difference), so a sum of six products of three is below 2^837: nothing
/// here can overflow.
#[derive(Clone, Copy)]
pub(super) struct Wide([u64; LIMBS]);

const LIMBS: usize = 14;

impl Wide {
    /// `value · 2^shift`; `value` is a 24-bit significand with its sign.
    pub(super) fn new(value: i64, shift: u32) -> Self {
        let mut limbs = [0; LIMBS];
        let shifted = u128::from(value.unsigned_abs()) << (shift % 64);
        let from = limbs.iter_mut().skip((shift / 64) as usize);
        for (limb, part) in from.zip([shifted as u64, (shifted >> 64) as u64]) {
            *limb = part;
        }
        if value < 0 { Self([0; LIMBS]).sub(Self(limbs)) } else { Self(limbs) }
    }

    pub(super) fn add(self, other: Self) -> Self {
        let mut out = self;
        let mut carry = false;
        for (x, y) in out.0.iter_mut().zip(other.0) {
            let (sum, c1) = x.overflowing_add(y);
            let (sum, c2) = sum.overflowing_add(u64::from(carry));
            (*x, carry) = (sum, c1 | c2);
        }
        out
    }

    pub(super) fn sub(self, other: Self) -> Self {
        let mut out = self;
        let mut borrow = false;
        for (x, y) in out.0.iter_mut().zip(other.0) {
            let (rest, b1) = x.overflowing_sub(y);
            let (rest, b2) = rest.overflowing_sub(u64::from(borrow));
            (*x, borrow) = (rest, b1 | b2);
        }
        out
    }

    /// The product modulo 2^896, which two's complement makes right for either sign.
    pub(super) fn mul(self, other: Self) -> Self {
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

    pub(super) fn sign(self) -> i32 {
        if self.is_negative() { -1 } else { i32::from(self.0.iter().any(|&x| x != 0)) }
    }

    /// The value divided by 2^`scale`, within a relative 2^-52.
    pub(super) fn to_f64(self, scale: i32) -> f64 {
        let negative = self.is_negative();
        let magnitude = if negative { Self([0; LIMBS]).sub(self) } else { self };
        let mut limbs = magnitude.0.as_slice();
        while let [lower @ .., 0] = limbs {
            limbs = lower;
        }
        let (top, below) = match limbs {
            [] => return 0.0,
            [top] => (top, &0),
            [.., below, top] => (top, below),
        };
        let leading = (u128::from(*top) << 64) | u128::from(*below);
        let value = scale_by_power(leading as f64, 64 * (limbs.len() as i32 - 2) - scale);
        if negative { -value } else { value }
    }

    /// The number of bits of the magnitude.
    pub(super) fn bits(self) -> u32 {
        let magnitude = if self.is_negative() { Self([0; LIMBS]).sub(self) } else { self };
        let mut leading = 0;
        for limb in magnitude.0.iter().rev() {
            leading += limb.leading_zeros();
            if *limb != 0 {
                break;
            }
        }
        64 * LIMBS as u32 - leading
    }

    fn is_negative(self) -> bool {
        self.0[LIMBS - 1] >> 63 != 0
    }
}

/// `x · 2^e` for results in the normal range, in steps that stay inside it.
fn scale_by_power(x: f64, e: i32) -> f64 {
    let power = |e: i32| f64::from_bits(((1023 + e) as u64) << 52);
    let half = e / 2;
    x * power(half) * power(e - half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_i128() {
        let values = [0_i64, 1, -1, 7, -12_345, (1 << 24) - 1, -(1 << 24) + 1];
        for x in values {
            for y in values {
                for shift in [0, 1, 31, 63].into_iter().skip(if cfg!(miri) { 3 } else { 0 }) {
                    let wide = Wide::new(x, shift);
                    let other = Wide::new(y, 3);
                    let (x, y) = (i128::from(x) << shift, i128::from(y) << 3);
                    assert_eq!(wide.add(other).sign(), (x + y).signum() as i32);
                    assert_eq!(wide.sub(other).sign(), (x - y).signum() as i32);
                    assert_eq!(
                        wide.mul(other).sub(Wide::new(1, 0)).sign(),
                        (x * y - 1).signum() as i32
                    );
                    assert_eq!(wide.mul(other).to_f64(0), (x * y) as f64);
                }
            }
        }
    }

    #[test]
    fn carries_run_through_every_limb() {
        let top = Wide::new(1, 800);
        let one = Wide::new(1, 0);
        assert_eq!(top.sub(one).add(one).sub(top).sign(), 0);
        assert_eq!(top.sub(one).bits(), 800);
        assert_eq!(Wide::new(-1, 400).mul(Wide::new(-1, 400)).sub(top).sign(), 0);
        assert_eq!(Wide::new(-3, 700).to_f64(700), -3.0);
    }
}
