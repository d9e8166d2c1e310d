//! Lists that grow with an answer or an input: memory that is not there is an error, and never the end of the process.

use crate::Error;

/// Makes room for more items than there are.
///
/// # Errors
/// [`Error::Memory`] with the bytes of the whole list; the list is as it was.
#[inline]
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), Error> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    grow(list, additional)
}

/// Adds an item.
///
/// # Errors
/// As [`reserve`].
#[inline]
pub(crate) fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), Error> {
    if list.len() == list.capacity() {
        grow(list, 1)?;
    }
    list.push(item);
    Ok(())
}

/// Adds all items of an iterator that knows how many there are.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn extend<T>(
    list: &mut Vec<T>,
    items: impl ExactSizeIterator<Item = T>,
) -> Result<(), Error> {
    reserve(list, items.len())?;
    list.extend(items);
    Ok(())
}

/// A list of so many items, all alike.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn filled<T: Clone>(item: T, len: usize) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    reserve(&mut list, len)?;
    list.resize(len, item);
    Ok(list)
}

/// A copy of a list.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn copy<T: Copy>(items: &[T]) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    reserve(&mut list, items.len())?;
    list.extend_from_slice(items);
    Ok(list)
}

#[cold]
fn grow<T>(list: &mut Vec<T>, additional: usize) -> Result<(), Error> {
    let needed = list.len().saturating_add(additional).saturating_mul(size_of::<T>());
    list.try_reserve(additional).map_err(|_| Error::Memory { needed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_much_is_an_error_that_says_how_much() {
        let mut list = vec![1_u64; 3];
        let most = isize::MAX as usize / 8;
        assert_eq!(reserve(&mut list, most), Err(Error::Memory { needed: 8 * (most + 3) }));
        assert_eq!(reserve(&mut list, usize::MAX), Err(Error::Memory { needed: usize::MAX }));
        assert_eq!(list, [1; 3]);
        assert_eq!((0..100).try_for_each(|i| push(&mut list, i)), Ok(()));
        assert_eq!(list.len(), 103);
    }
}
