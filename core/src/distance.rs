//! The distance within which pairs are asked for.

/// A distance: finite, and not negative. The default is 0.
///
/// # Examples
/// ```
/// use pfront_core::{Distance, DistanceError};
/// assert_eq!(Distance::new(0.25)?.get(), 0.25);
/// assert!(Distance::new(-1.0).is_err() && Distance::new(f32::NAN).is_err());
/// # Ok::<(), DistanceError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Distance(f32);

impl Distance {
    /// Checks a distance. [`Distance::at_least`] takes one in f64.
    ///
    /// # Errors
    /// [`DistanceError`] if it is NaN, infinite or negative.
    pub fn new(distance: f32) -> Result<Self, DistanceError> {
        // By their bits, the floats up to infinity, and −0, are told in every floating-point environment.
        match distance.to_bits() {
            bits if bits < f32::INFINITY.to_bits() => Ok(Self(distance)),
            bits if bits == (-0.0_f32).to_bits() => Ok(Self(0.0)),
            _ => Err(DistanceError { distance }),
        }
    }

    /// The least distance in f32 that is not less than one in f64, so that no pair is missed.
    ///
    /// # Errors
    /// As [`Distance::new`], also if no f32 is as large.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::Distance;
    /// assert_eq!(Distance::at_least(0.5)?.get(), 0.5);
    /// assert!(f64::from(Distance::at_least(0.02)?.get()) > 0.02);
    /// assert!(Distance::at_least(-1e-300).is_err());
    /// assert!(Distance::at_least(1e300).is_err());
    /// # Ok::<(), pfront_core::DistanceError>(())
    /// ```
    pub fn at_least(distance: f64) -> Result<Self, DistanceError> {
        let nearest = distance as f32;
        if distance < 0.0 {
            // It may round to zero, and is refused nevertheless.
            return Err(DistanceError { distance: nearest });
        }
        Self::new(if f64::from(nearest) < distance { nearest.next_up() } else { nearest })
    }

    /// The distance, in the units of the query.
    #[must_use]
    pub fn get(self) -> f32 {
        self.0
    }
}

/// A distance is NaN, infinite or negative.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a distance must be finite and not negative, which {distance} is not")]
#[non_exhaustive]
pub struct DistanceError {
    /// The distance.
    pub distance: f32,
}
