//! The errors for buffers that are too small, and for distances.

/// A buffer that the caller passed is too small. Nothing was written that later calls rely on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{buffer}` holds {capacity} elements, but {needed} are needed")]
#[non_exhaustive]
pub struct CapacityError {
    /// The name of the parameter.
    pub buffer: &'static str,
    /// The number of elements that it must hold.
    pub needed: usize,
    /// The number of elements that it holds.
    pub capacity: usize,
}

impl CapacityError {
    /// Checks that `capacity` elements are enough for `needed`.
    ///
    /// # Errors
    /// The error that names the buffer, if they are not.
    pub fn check(
        buffer: &'static str,
        needed: usize,
        capacity: usize,
    ) -> Result<(), CapacityError> {
        if capacity < needed { Err(Self { buffer, needed, capacity }) } else { Ok(()) }
    }
}

/// A distance is NaN, infinite or negative.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a distance must be finite and not negative, and {distance} is not")]
#[non_exhaustive]
pub struct DistanceError {
    /// The distance.
    pub distance: f32,
}

impl DistanceError {
    /// Checks that a distance is finite and not negative.
    ///
    /// # Errors
    /// The error that tells the distance, if it is not.
    pub fn check(distance: f32) -> Result<(), DistanceError> {
        if distance.is_finite() && distance >= 0.0 { Ok(()) } else { Err(Self { distance }) }
    }
}
