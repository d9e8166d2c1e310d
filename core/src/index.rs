//! Indices that were checked long before, in data that a caller vouches for.
//!
//! With std a wrong one panics, as indexing does, and costs no more. Firmware had better not link what
//! panics need, so without std a stand-in is found there that no query makes anything of: see
//! `firmware/examples/panics.rs`.

use crate::Node;
use crate::bvh::CompactNode;

/// What stands in for an element that is not there.
pub(crate) trait StandIn: Sized + 'static {
    const NOTHING: &'static Self;
}

/// An empty leaf, which overlaps nothing.
impl StandIn for Node {
    const NOTHING: &'static Self = &Self { count: u32::MAX, ..Self::EMPTY };
}

/// Likewise.
impl StandIn for CompactNode {
    const NOTHING: &'static Self = &Self::NOTHING;
}

/// A triangle of vertices that are not there.
impl StandIn for [u32; 3] {
    const NOTHING: &'static Self = &[u32::MAX; 3];
}

/// A vertex that is in no place.
impl StandIn for [f32; 3] {
    const NOTHING: &'static Self = &[f32::NAN; 3];
}

/// A triangle that is not there.
impl StandIn for u32 {
    const NOTHING: &'static Self = &u32::MAX;
}

/// Likewise, though one that may be.
impl StandIn for u16 {
    const NOTHING: &'static Self = &u16::MAX;
}

/// Likewise.
impl StandIn for [u8; 3] {
    const NOTHING: &'static Self = &[u8::MAX; 3];
}

/// An element, by an index that is in range.
#[inline(always)]
pub(crate) fn item<T: StandIn>(items: &[T], index: u32) -> &T {
    if cfg!(feature = "std") {
        return &items[index as usize];
    }
    items.get(index as usize).unwrap_or(T::NOTHING)
}

/// A run of elements, by a range that is in range.
#[inline(always)]
pub(crate) fn run<T>(items: &[T], first: u32, count: u32) -> &[T] {
    if cfg!(feature = "std") {
        return &items[first as usize..][..count as usize];
    }
    let rest = items.get(first as usize..).unwrap_or_default();
    rest.get(..count as usize).unwrap_or_default()
}

/// Divides a slice at `middle`, or at its end if that comes before.
#[inline]
pub(crate) fn split<T>(items: &mut [T], middle: usize) -> (&mut [T], &mut [T]) {
    items.split_at_mut(middle.min(items.len()))
}
