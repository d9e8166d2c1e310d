//! Conversion between little-endian bytes and elements that consist of 32-bit words, or points in f64.

use super::BlobError;
use crate::CapacityError;
use crate::index::part_mut;
use bytemuck::Pod;

/// The elements where they lie.
pub(super) fn borrow<T: Pod>(bytes: &[u8]) -> Result<&[T], BlobError> {
    if cfg!(target_endian = "big") {
        return Err(BlobError::BigEndian);
    }
    // An empty section may have any offset.
    if bytes.is_empty() {
        return Ok(&[]);
    }
    // A section is a whole number of elements, so only its place can be wrong.
    bytemuck::try_cast_slice(bytes).map_err(|_| BlobError::Misaligned { needed: align_of::<T>() })
}

/// The elements, copied to the beginning of `to`.
pub(super) fn copy_from<'s, T: Pod>(
    bytes: &[u8],
    buffer: &'static str,
    to: &'s mut [T],
) -> Result<&'s [T], CapacityError> {
    let count = bytes.len() / size_of::<T>();
    CapacityError::check(buffer, count, to.len())?;
    let to = part_mut(to, ..count);
    let words = bytemuck::must_cast_slice_mut::<T, u32>(to).iter_mut();
    words.zip(bytes.as_chunks().0).for_each(|(to, from)| *to = u32::from_le_bytes(*from));
    Ok(to)
}

/// Writes the elements to as many bytes as they take.
pub(super) fn copy_to<T: Pod>(elements: &[T], out: &mut [u8]) {
    let words = bytemuck::must_cast_slice::<T, u32>(elements).iter();
    words.zip(out.as_chunks_mut().0).for_each(|(from, to)| *to = from.to_le_bytes());
}

/// Copies points in f64 to the beginning of `to`.
pub(super) fn copy_points_from<'s>(
    bytes: &[u8],
    buffer: &'static str,
    to: &'s mut [[f64; 3]],
) -> Result<&'s [[f64; 3]], CapacityError> {
    let count = bytes.len() / size_of::<[f64; 3]>();
    CapacityError::check(buffer, count, to.len())?;
    let to = part_mut(to, ..count);
    let words = to.as_flattened_mut().iter_mut().zip(bytes.as_chunks().0);
    words.for_each(|(to, from)| *to = f64::from_le_bytes(*from));
    Ok(to)
}

/// Writes points in f64 to as many bytes as they take.
pub(super) fn copy_points_to(points: &[[f64; 3]], out: &mut [u8]) {
    let words = points.as_flattened().iter().zip(out.as_chunks_mut().0);
    words.for_each(|(from, to)| *to = from.to_le_bytes());
}
