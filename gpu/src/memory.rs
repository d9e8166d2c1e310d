//! Lists of the host, whose growth may fail.

use crate::GpuError;
use bytemuck::Pod;

/// Makes room in a list of the host.
///
/// # Errors
/// [`GpuError::Memory`]; the list is as it was.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), GpuError> {
    let needed = list.len().saturating_add(additional).saturating_mul(size_of::<T>());
    list.try_reserve(additional).map_err(|_| GpuError::Memory { needed })
}

/// Adds the elements that some bytes are. Nothing says how mapped memory is aligned.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn append<T: Pod>(list: &mut Vec<T>, bytes: &[u8]) -> Result<(), GpuError> {
    reserve(list, bytes.len() / size_of::<T>())?;
    match bytemuck::try_cast_slice(bytes) {
        Ok(elements) => list.extend_from_slice(elements),
        Err(_) => {
            let elements = bytes.chunks_exact(size_of::<T>());
            list.extend(elements.map(bytemuck::pod_read_unaligned::<T>));
        }
    }
    Ok(())
}
