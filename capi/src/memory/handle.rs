//! Structures that only the library looks into: C holds them by pointer, from the call that makes them to the one that
//! frees them.

use super::{Call, addresses};
use crate::status::Fault;
use crate::status::pfront_status_t::PFRONT_NOT_MADE;
use core::ffi::CStr;

/// A structure that C knows no member of.
///
/// # Safety
/// At `SEAL_AT` bytes lies a `u32`, which is `SEAL` in each value of this type.
pub(crate) unsafe trait Handle {
    const SEAL: u32;
    const SEAL_AT: usize;
}

impl<'c> Call<'c> {
    /// A structure to change.
    pub(crate) fn owned<T: Handle>(
        &mut self,
        what: &'static CStr,
        at: *mut T,
    ) -> Result<&'c mut T, Fault> {
        sealed(what, at)?;
        self.claim(what, addresses(what, at, 1)?, true)?;
        // SAFETY: by the seal it was made, and by the contract not freed since, and nobody else uses it.
        Ok(unsafe { &mut *at })
    }

    /// A structure to look into.
    pub(crate) fn shared<T: Handle>(
        &self,
        what: &'static CStr,
        at: *const T,
    ) -> Result<&'c T, Fault> {
        sealed(what, at)?;
        self.apart(what, &addresses(what, at, 1)?, |_| true)?;
        // SAFETY: by the seal it was made, and by the contract not freed since, and nobody changes it.
        Ok(unsafe { &*at })
    }

    /// Frees a structure, unless it is null.
    pub(crate) fn free<T: Handle>(&mut self, what: &'static CStr, at: *mut T) -> Result<(), Fault> {
        if at.is_null() {
            return Ok(());
        }
        sealed(what, at)?;
        // SAFETY: by the seal it was made, in a box, and by the contract not freed since, and nobody else uses it.
        drop(unsafe { Box::from_raw(at) });
        Ok(())
    }
}

/// Checks the seal.
fn sealed<T: Handle>(what: &'static CStr, at: *const T) -> Result<(), Fault> {
    addresses(what, at, 1)?;
    // SAFETY: by the contract a structure is there, whoever made it.
    let seal = unsafe { at.byte_add(T::SEAL_AT).cast::<u32>().read() };
    if seal == T::SEAL { Ok(()) } else { Err(Fault::of(PFRONT_NOT_MADE, what)) }
}
