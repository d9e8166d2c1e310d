//! Families in f64: what is made of those in f32.

use super::Family;
use crate::Point;
use rand::{Rng, RngExt};

/// A triangle in f64.
pub type Triangle64 = [[f64; 3]; 3];

/// The largest coordinate that a mesh in f64 may have: 2^125.
const LIMIT: f64 = 4.253529586511731e37;

/// A change to the coordinates of a family in f32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InF64 {
    /// Nothing.
    Widened,
    /// Each is off by up to two steps of f64.
    Noise,
    /// Each axis has a scale of its own, a power of two from 2^-1000 to 2^90, so that one may be subnormal beside another.
    Scaled,
    /// All are moved by up to 1e7, where they lose digits.
    Moved,
    /// Each is replaced by one of other bits, the same for the same.
    Replaced,
}

impl InF64 {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Widened, Self::Noise, Self::Scaled, Self::Moved, Self::Replaced];

    /// The name, as in the source.
    pub fn name(self) -> String {
        format!("{self:?}")
    }

    /// A pair of triangles; `None` if a coordinate would be beyond 2^125.
    pub fn pair(self, family: Family, rng: &mut impl Rng) -> Option<(Triangle64, Triangle64)> {
        let ([p, q, r], [u, v, w]) = family.pair(rng);
        let [p, q, r, u, v, w] = self.points([p, q, r, u, v, w], rng)?;
        Some(([p, q, r], [u, v, w]))
    }

    /// Other positions; `None` if a coordinate would be beyond 2^125.
    pub fn points(self, points: [Point; 6], rng: &mut impl Rng) -> Option<[[f64; 3]; 6]> {
        let scales = [0; 3].map(|_| 2_f64.powi(rng.random_range(-1000..=90)));
        let offset = [0; 3].map(|_| 1e7 * rng.random_range(-1.0..1.0));
        let salt: u64 = rng.random();
        let mut noise =
            |x: f64| f64::from_bits(x.to_bits().wrapping_add_signed(rng.random_range(-2..=2)));
        let made = points.map(|p| {
            [0, 1, 2].map(|k| {
                let x = f64::from(p[k]);
                match self {
                    Self::Widened => x,
                    Self::Noise if x == 0.0 => x,
                    Self::Noise => noise(x),
                    Self::Scaled => x * scales[k],
                    Self::Moved => x + offset[k],
                    Self::Replaced => {
                        let bits = (x.to_bits() ^ salt).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                        f64::from_bits(bits ^ (bits >> 29))
                    }
                }
            })
        });
        made.as_flattened().iter().all(|x| x.abs() <= LIMIT).then_some(made)
    }
}
