//! Conversion between little-endian bytes and elements that consist of words of so many bytes.

use super::BlobError;
use bytemuck::Pod;
use pfront_core::CapacityError;

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
pub(super) fn copy_from<'s, const WORD: usize, T: Pod>(
    bytes: &[u8],
    buffer: &'static str,
    to: &'s mut [T],
) -> Result<&'s [T], CapacityError> {
    let count = bytes.len() / size_of::<T>();
    CapacityError::check(buffer, count, to.len())?;
    let to = &mut to[..count];
    copy::<WORD>(bytes, bytemuck::must_cast_slice_mut(to));
    Ok(to)
}

/// Writes the elements to as many bytes as they take.
pub(super) fn copy_to<const WORD: usize, T: Pod>(elements: &[T], out: &mut [u8]) {
    copy::<WORD>(bytemuck::must_cast_slice(elements), out);
}

/// Copies words of this machine to little-endian ones, or back.
fn copy<const WORD: usize>(from: &[u8], to: &mut [u8]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    if cfg!(target_endian = "big") {
        to.as_chunks_mut::<WORD>().0.iter_mut().for_each(|word| word.reverse());
    }
}
