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
    /// Checks a distance. Of one in f64, take the f32 that is not less, and no pair is missed.
    ///
    /// # Errors
    /// [`DistanceError`] if it is NaN, infinite or negative.
    pub fn new(distance: f32) -> Result<Self, DistanceError> {
        if distance.is_finite() && distance >= 0.0 {
            Ok(Self(distance))
        } else {
            Err(DistanceError { distance })
        }
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
