//! Lists that grow with an answer or with its front: memory that is not there is an error, and never the end of the process.

use std::fmt;

/// An answer, or the front by which it is divided, does not fit into memory. The traversal can be used as before.
///
/// # Examples
/// ```
/// let error = pfront_cpu::MemoryError { needed: 1 << 40 };
/// assert_eq!(error.to_string(), "no memory for a list of 1099511627776 bytes");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryError {
    /// The bytes of the list that could not grow.
    pub needed: usize,
}

impl fmt::Display for MemoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no memory for a list of {} bytes", self.needed)
    }
}

impl std::error::Error for MemoryError {}

/// Makes room for more items than there are.
#[inline]
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), MemoryError> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    grow(list, additional)
}

/// Makes a list so long, with default items where it is shorter.
pub(crate) fn resize<T: Clone + Default>(list: &mut Vec<T>, len: usize) -> Result<(), MemoryError> {
    let more = len.saturating_sub(list.len());
    reserve(list, more)?;
    list.resize(len, T::default());
    Ok(())
}

/// Adds an item.
#[inline]
pub(crate) fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), MemoryError> {
    if list.len() == list.capacity() {
        grow(list, 1)?;
    }
    list.push(item);
    Ok(())
}

#[cold]
fn grow<T>(list: &mut Vec<T>, additional: usize) -> Result<(), MemoryError> {
    let needed = list.len().saturating_add(additional).saturating_mul(size_of::<T>());
    list.try_reserve(additional).map_err(|_| MemoryError { needed })
}
