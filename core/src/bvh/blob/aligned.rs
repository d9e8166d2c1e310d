//! Bytes that begin where a cache line does.

/// What it holds begins at a multiple of 64 bytes, as a [`Blob`](super::Blob) that is borrowed had better.
///
/// # Examples
/// ```
/// use pfront_core::blob::Aligned;
/// # macro_rules! include_bytes { ($file:literal) => { b"64 bytes and more" } }
/// static GEAR: &Aligned<[u8]> = &Aligned(*include_bytes!("gear.pfb"));
/// assert!(GEAR.0.as_ptr().addr().is_multiple_of(64));
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Aligned<T: ?Sized>(
    /// What it holds.
    pub T,
);
