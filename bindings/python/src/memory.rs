//! Lists that grow, or say that there is no memory for them.

use pfront::Error;

/// Makes room for more items.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), Error> {
    let needed = list.len().saturating_add(additional).saturating_mul(size_of::<T>());
    list.try_reserve(additional).map_err(|_| Error::Memory { needed })
}

pub(crate) fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), Error> {
    if list.len() == list.capacity() {
        reserve(list, 1)?;
    }
    list.push(item);
    Ok(())
}

pub(crate) fn extend<T>(
    list: &mut Vec<T>,
    items: impl ExactSizeIterator<Item = T>,
) -> Result<(), Error> {
    reserve(list, items.len())?;
    list.extend(items);
    Ok(())
}

/// A list of items whose number is known.
pub(crate) fn collect<T>(items: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    list.try_reserve_exact(items.len())
        .map_err(|_| Error::Memory { needed: items.len().saturating_mul(size_of::<T>()) })?;
    list.extend(items);
    Ok(list)
}

pub(crate) fn copy<T: Copy>(items: &[T]) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    list.try_reserve_exact(items.len())
        .map_err(|_| Error::Memory { needed: size_of_val(items) })?;
    list.extend_from_slice(items);
    Ok(list)
}
