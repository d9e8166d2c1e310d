//! The error for buffers that are too small.

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
