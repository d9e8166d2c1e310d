//! Errors of the caller's buffers.

use core::fmt;

/// A buffer of the caller's is too small. Nothing was written that later calls rely on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CapacityError {
    /// Which buffer, by the name of the parameter.
    pub buffer: &'static str,
    /// How many elements it must hold.
    pub needed: usize,
    /// How many it holds.
    pub capacity: usize,
}

impl CapacityError {
    /// `Ok` when `capacity` elements are enough for `needed`.
    pub(crate) fn check(
        buffer: &'static str,
        needed: usize,
        capacity: usize,
    ) -> Result<(), CapacityError> {
        if capacity < needed { Err(Self { buffer, needed, capacity }) } else { Ok(()) }
    }
}

impl fmt::Display for CapacityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { buffer, needed, capacity } = self;
        write!(f, "`{buffer}` holds {capacity} elements, but {needed} are needed")
    }
}

impl core::error::Error for CapacityError {}
