//! Elements by indices that a proof bounds, or that [`Bvh::new`](crate::Bvh::new) has checked.
//!
//! Where the proof fails, or arrays were given to `new_unchecked` that break its contract, these functions end in
//! the one panic of this crate. Its message is constant, so that firmware links no formatting: `.ci/firmware` allows
//! no other.

use core::slice::SliceIndex;

/// The element at `index`.
#[inline(always)]
pub(crate) fn at<T>(slice: &[T], index: impl TryInto<usize>) -> &T {
    match index.try_into().ok().and_then(|index| slice.get(index)) {
        Some(element) => element,
        None => out_of_range(),
    }
}

/// The element at `index`, to be changed.
#[inline(always)]
pub(crate) fn at_mut<T>(slice: &mut [T], index: impl TryInto<usize>) -> &mut T {
    match index.try_into().ok().and_then(|index| slice.get_mut(index)) {
        Some(element) => element,
        None => out_of_range(),
    }
}

/// The `count` elements from `first` on.
#[inline(always)]
pub(crate) fn range<T>(slice: &[T], first: u32, count: u32) -> &[T] {
    part(part(slice, first as usize..), ..count as usize)
}

/// The `count` elements from `first` on, to be changed.
#[inline(always)]
pub(crate) fn range_mut<T>(slice: &mut [T], first: u32, count: u32) -> &mut [T] {
    part_mut(part_mut(slice, first as usize..), ..count as usize)
}

/// The elements in a range.
#[inline(always)]
pub(crate) fn part<T>(slice: &[T], range: impl SliceIndex<[T], Output = [T]>) -> &[T] {
    match slice.get(range) {
        Some(elements) => elements,
        None => out_of_range(),
    }
}

/// The elements in a range, to be changed.
#[inline(always)]
pub(crate) fn part_mut<T>(slice: &mut [T], range: impl SliceIndex<[T], Output = [T]>) -> &mut [T] {
    match slice.get_mut(range) {
        Some(elements) => elements,
        None => out_of_range(),
    }
}

/// Divides a slice at `middle`, or at its end if that comes before: builds that run out of nodes go on counting.
#[inline]
pub(crate) fn split<T>(slice: &mut [T], middle: usize) -> (&mut [T], &mut [T]) {
    slice.split_at_mut(middle.min(slice.len()))
}

/// Panics: see the module.
#[cold]
#[inline(never)]
#[expect(clippy::panic, reason = "fewer pairs without a word would be worse")]
pub(crate) fn out_of_range() -> ! {
    panic!(
        "index out of range: arrays passed to `new_unchecked` are not those of a valid mesh and BVH"
    )
}
