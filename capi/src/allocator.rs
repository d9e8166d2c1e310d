//! Memory of the caller's allocator, or of the standard library's.

#![expect(unsafe_code, reason = "an allocator is two functions of C")]

use crate::memory::Call;
use crate::status::Fault;
use crate::status::pfront_status_t::{PFRONT_MISALIGNED, PFRONT_NULL, PFRONT_OUT_OF_MEMORY};
use core::ffi::c_void;
use core::ptr::NonNull;
use core::slice;

/// A pair of functions that a call gets memory by. They are called on the calling thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_allocator_t {
    /// Returns so many bytes, at least 8, at a multiple of 8 bytes; or null if there are not as many.
    pub allocate: Option<unsafe extern "C" fn(context: *mut c_void, bytes: usize) -> *mut c_void>,
    /// Takes back what `allocate` has returned for so many bytes.
    pub release:
        Option<unsafe extern "C" fn(context: *mut c_void, memory: *mut c_void, bytes: usize)>,
    /// Handed to both; may be null.
    pub context: *mut c_void,
}

impl pfront_allocator_t {
    /// The caller's allocator, with both functions; or the standard library's, if that is there and `at` is null.
    pub(crate) fn of(call: &Call<'_>, at: *const Self) -> Result<Self, Fault> {
        #[cfg(feature = "std")]
        if at.is_null() {
            return Ok(standard::ALLOCATOR);
        }
        let allocator = call.get(c"allocator", at)?;
        allocator.allocate.ok_or(Fault::of(PFRONT_NULL, c"allocate"))?;
        allocator.release.ok_or(Fault::of(PFRONT_NULL, c"release"))?;
        Ok(allocator)
    }
}

/// Rust's own allocator, which is malloc wherever there is one.
#[cfg(feature = "std")]
mod standard {
    use super::{c_void, pfront_allocator_t};
    use core::ptr::null_mut;
    use std::alloc::{Layout, alloc, dealloc};

    pub(super) const ALLOCATOR: pfront_allocator_t = pfront_allocator_t {
        allocate: Some(allocate),
        release: Some(release),
        context: null_mut(),
    };

    unsafe extern "C" fn allocate(_: *mut c_void, bytes: usize) -> *mut c_void {
        let Ok(layout) = Layout::from_size_align(bytes, align_of::<u64>()) else {
            return null_mut();
        };
        // SAFETY: `Block` asks for at least one word.
        unsafe { alloc(layout) }.cast()
    }

    unsafe extern "C" fn release(_: *mut c_void, memory: *mut c_void, bytes: usize) {
        let Ok(layout) = Layout::from_size_align(bytes, align_of::<u64>()) else { return };
        // SAFETY: `allocate` has returned it for the same layout.
        unsafe { dealloc(memory.cast(), layout) }
    }
}

/// Words from an allocator, which get back there when this is dropped. Like the caller's arrays they need not be
/// initialised, and nothing reads what it has not written.
pub(crate) struct Block {
    first: NonNull<u64>,
    count: usize,
    allocator: pfront_allocator_t,
}

impl Block {
    /// No word takes no memory.
    pub(crate) fn new(allocator: pfront_allocator_t, count: usize) -> Result<Self, Fault> {
        let none = Self { first: NonNull::dangling(), count: 0, allocator };
        if count == 0 {
            return Ok(none);
        }
        let bytes = count.saturating_mul(size_of::<u64>());
        let out = Fault::of(PFRONT_OUT_OF_MEMORY, c"allocator").numbers(bytes, 0);
        let allocate = allocator.allocate.filter(|_| bytes <= isize::MAX as usize).ok_or(out)?;
        // SAFETY: the contract of the header: it is an allocator.
        let first = unsafe { allocate(allocator.context, bytes) }.cast::<u64>();
        let block = Self { first: NonNull::new(first).ok_or(out)?, count, ..none };
        if !first.is_aligned() {
            return Err(Fault::of(PFRONT_MISALIGNED, c"allocate").numbers(align_of::<u64>(), 0));
        }
        Ok(block)
    }

    pub(crate) fn words(&mut self) -> &mut [u64] {
        // SAFETY: so many words are there, aligned, and nobody else knows of them.
        unsafe { slice::from_raw_parts_mut(self.first.as_ptr(), self.count) }
    }

    /// The address and the number of the words, which a structure of C's keeps for [`Block::from_raw`].
    pub(crate) fn into_raw(self) -> (*mut u64, usize) {
        let raw = (self.first.as_ptr(), self.count);
        core::mem::forget(self);
        raw
    }

    /// # Safety
    /// [`Block::into_raw`] has returned the first two for a block of this allocator; they make no other block.
    pub(crate) unsafe fn from_raw(
        first: *mut u64,
        count: usize,
        allocator: pfront_allocator_t,
    ) -> Option<Self> {
        Some(Self { first: NonNull::new(first)?, count, allocator })
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        if let (Some(release), 1..) = (self.allocator.release, self.count) {
            let bytes = self.count * size_of::<u64>();
            // SAFETY: the contract of the header: it is an allocator; and it has returned as much there.
            unsafe { release(self.allocator.context, self.first.as_ptr().cast(), bytes) };
        }
    }
}
