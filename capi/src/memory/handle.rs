//! Structures that only the library looks into: C holds them by pointer, from the call that makes them to the one that
//! frees them.
//!
//! Before the value lie two words by which calls know each other: the seal, which is zero again before the memory goes, and
//! how many calls are inside. So a call finds a structure that was never made, that was copied byte by byte, that another thread
//! is inside of, and that was freed, unless its memory has meanwhile become another structure of the same kind.

use super::{Call, Done, Out, addresses};
use crate::status::Fault;
use crate::status::pfront_status_t::{PFRONT_BUSY, PFRONT_NOT_MADE, PFRONT_OUT_OF_MEMORY};
use core::ffi::CStr;
use core::sync::atomic::AtomicU32;
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::alloc::{Layout, alloc};

/// A structure that C knows no member of. Where C's pointer leads lies a [`Sealed`] value.
pub(crate) trait Handle {
    type Value;
    const SEAL: u32;

    /// Whether another process has what the value holds: then its memory stays, and nothing of it is closed.
    fn is_foreign(_: &Self::Value) -> bool {
        false
    }
}

/// The seal lies first, whatever the value is, so that one of another kind is told.
#[repr(C)]
struct Sealed<T> {
    seal: AtomicU32,
    /// Calls that read the value, or [`WRITER`].
    users: AtomicU32,
    value: T,
}

/// One call that may change the value.
const WRITER: u32 = u32::MAX;

/// A call's part of the users of a structure.
pub(super) struct Use(*const AtomicU32);

impl Drop for Use {
    fn drop(&mut self) {
        // SAFETY: it is part of a structure that nobody frees while a call is inside.
        let users = unsafe { &*self.0 };
        if users.load(Relaxed) == WRITER {
            users.store(0, Release);
        } else {
            users.fetch_sub(1, Release);
        }
    }
}

/// Room for so many more.
pub(crate) fn reserve<T>(list: &mut Vec<T>, more: usize) -> Done {
    let bytes = more.saturating_mul(size_of::<T>());
    let fault = Fault::of(PFRONT_OUT_OF_MEMORY, c"malloc").numbers(bytes, 0);
    list.try_reserve(more).map_err(|_| fault)
}

/// Where an array goes that a structure keeps for C, and its length.
pub(crate) struct OutArray<T> {
    first: Out<*const T>,
    count: Out<usize>,
}

impl<T> OutArray<T> {
    /// Replaces what is kept.
    pub(crate) fn set(self, kept: &mut Vec<T>, with: impl ExactSizeIterator<Item = T>) -> Done {
        kept.clear();
        reserve(kept, with.len())?;
        kept.extend(with);
        self.first.set(kept.as_ptr());
        self.count.set(kept.len());
        Ok(())
    }
}

impl<'c> Call<'c> {
    /// Where the first element of an array goes, and how many there are.
    pub(crate) fn out_array<T>(
        &mut self,
        what: &'static CStr,
        first: *mut *const T,
        count: *mut usize,
    ) -> Result<OutArray<T>, Fault> {
        self.out_list(what, first, c"count", count)
    }

    /// The same where the number has a name of its own.
    pub(crate) fn out_list<T>(
        &mut self,
        what: &'static CStr,
        first: *mut *const T,
        number: &'static CStr,
        count: *mut usize,
    ) -> Result<OutArray<T>, Fault> {
        Ok(OutArray { first: self.out(what, first)?, count: self.out(number, count)? })
    }

    /// A structure for C, which frees it by [`Call::free`].
    pub(crate) fn boxed<T: Handle>(value: T::Value) -> Result<*mut T, Fault> {
        let layout = Layout::new::<Sealed<T::Value>>();
        // SAFETY: the layout has a size.
        let at = unsafe { alloc(layout) }.cast::<Sealed<T::Value>>();
        if at.is_null() {
            return Err(Fault::of(PFRONT_OUT_OF_MEMORY, c"malloc").numbers(layout.size(), 0));
        }
        let (seal, users) = (AtomicU32::new(seal(at.cast::<T>())), AtomicU32::new(0));
        // SAFETY: there is room for one.
        unsafe { at.write(Sealed { seal, users, value }) };
        Ok(at.cast())
    }

    /// A structure to change.
    pub(crate) fn owned<T: Handle>(
        &mut self,
        what: &'static CStr,
        at: *mut T,
    ) -> Result<&'c mut T::Value, Fault> {
        let sealed = sealed(what, at)?;
        self.claim(what, addresses(what, sealed, 1)?, true)?;
        // SAFETY: by the seal it was made, and by the contract not freed since.
        let users = unsafe { &(*sealed).users };
        let taken = users.compare_exchange(0, WRITER, Acquire, Relaxed);
        taken.map_err(|_| Fault::of(PFRONT_BUSY, what))?;
        self.inside(Use(users));
        // SAFETY: nobody else is inside until the call ends.
        Ok(unsafe { &mut (*sealed.cast_mut()).value })
    }

    /// A structure to look into.
    pub(crate) fn shared<T: Handle>(
        &mut self,
        what: &'static CStr,
        at: *const T,
    ) -> Result<&'c T::Value, Fault> {
        let (sealed, used) = self.used(what, at)?;
        self.inside(used);
        // SAFETY: nobody changes it until the call ends.
        Ok(unsafe { &(*sealed).value })
    }

    /// A copy of the value of a structure, which is free again at once.
    pub(crate) fn cloned<T: Handle<Value: Clone>>(
        &self,
        what: &'static CStr,
        at: *const T,
    ) -> Result<T::Value, Fault> {
        let (sealed, _used) = self.used(what, at)?;
        // SAFETY: nobody changes it as long as it is in use.
        Ok(unsafe { &(*sealed).value }.clone())
    }

    /// A structure with one more user who reads.
    fn used<T: Handle>(
        &self,
        what: &'static CStr,
        at: *const T,
    ) -> Result<(*const Sealed<T::Value>, Use), Fault> {
        let sealed = sealed(what, at)?;
        self.apart(what, &addresses(what, sealed, 1)?, |_| true)?;
        // SAFETY: by the seal it was made, and by the contract not freed since.
        let users = unsafe { &(*sealed).users };
        let more = |users: u32| users.checked_add(1).filter(|&users| users != WRITER);
        let counted = users.fetch_update(Acquire, Relaxed, more);
        counted.map_err(|_| Fault::of(PFRONT_BUSY, what))?;
        Ok((sealed, Use(users)))
    }

    /// Frees a structure, unless it is null.
    pub(crate) fn free<T: Handle>(&mut self, what: &'static CStr, at: *mut T) -> Done {
        if at.is_null() {
            return Ok(());
        }
        let sealed = sealed(what, at)?;
        {
            // SAFETY: by the seal it was made, and by the contract not freed since. The value may be another call's to change.
            let (seal, users) = unsafe { (&(*sealed).seal, &(*sealed).users) };
            let taken = users.compare_exchange(0, WRITER, Acquire, Relaxed);
            taken.map_err(|_| Fault::of(PFRONT_BUSY, what))?;
            seal.store(0, Relaxed);
        }
        // SAFETY: `boxed` has made it, in memory of the same layout, and nobody is inside.
        let boxed = unsafe { Box::from_raw(sealed.cast_mut()) };
        if T::is_foreign(&boxed.value) {
            Box::leak(boxed);
        }
        Ok(())
    }

    /// Remembers a structure that this call is inside of.
    fn inside(&mut self, used: Use) {
        let free = self.inside.iter_mut().find(|used| used.is_none());
        debug_assert!(free.is_some(), "no call uses more than two structures");
        if let Some(free) = free {
            *free = Some(used);
        }
    }
}

/// The seal of a structure that lies there, and of no copy of it.
fn seal<T: Handle>(at: *const T) -> u32 {
    T::SEAL ^ at.addr() as u32
}

/// Checks the seal.
fn sealed<T: Handle>(what: &'static CStr, at: *const T) -> Result<*const Sealed<T::Value>, Fault> {
    let sealed = at.cast::<Sealed<T::Value>>();
    addresses(what, sealed, 1)?;
    // SAFETY: by the contract a structure is there, whoever made it.
    let found = unsafe { &(*sealed).seal }.load(Relaxed);
    if found == seal(at) { Ok(sealed) } else { Err(Fault::of(PFRONT_NOT_MADE, what)) }
}
