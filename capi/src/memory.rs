//! Where pointers of C become slices: the only place that follows one, but for what an allocator returns.
//!
//! Four things about a pointer can be checked: that it is not null, that it is aligned, that no array goes around the end of
//! the address space, and that what is written overlaps nothing else that the call uses. The rest is the caller's part of the
//! contract: that memory is there, as much as is said, and is no other thread's to write.
//!
//! Buffers that a call writes need not be initialised in C, and become references all the same: `pfront_core` reads nothing
//! of a buffer that it has not written, which miri and valgrind check.

#![expect(unsafe_code, reason = "C knows only pointers, and somebody has to follow them")]

#[cfg(feature = "std")]
mod handle;

use crate::status::pfront_status_t::{self, *};
use crate::status::{Fault, pfront_error_t};
use core::ffi::{CStr, c_void};
use core::marker::PhantomData;
use core::ops::Range;
use core::slice;
#[cfg(feature = "std")]
pub(crate) use handle::{Handle, reserve};
use pfront_core::Node;
use pfront_core::bvtt::TrianglePair;
use pfront_core::environment;
use pfront_core::front::{FrontNode, Part};

/// A type that may be read from memory that C has written, whatever it wrote.
///
/// # Safety
/// All bytes make a value.
pub(crate) unsafe trait Plain: Copy {}

/// Integers, floats and raw pointers, and arrays and structures of these.
macro_rules! plain {
    ($($type:ty),*) => { $(
        // SAFETY: see the macro.
        unsafe impl Plain for $type {}
    )* };
}
plain!(
    u8,
    u32,
    u64,
    [u8; 2],
    [u8; 4],
    [f32; 3],
    [f64; 3],
    [f32; 4],
    [f32; 16],
    [u32; 3],
    FrontNode,
    Node,
    Part,
    TrianglePair
);
plain!(
    crate::pfront_allocator_t,
    crate::pfront_buffers_t,
    crate::pfront_bvh_memory_t,
    crate::pfront_bvh_t,
    crate::pfront_contact_t,
    crate::pfront_cursor_t,
    crate::pfront_front_t,
    crate::pfront_mesh_t,
    crate::pfront_pair_list_t,
    crate::pfront_pose_t,
    crate::pfront_pose64_t,
    crate::pfront_query_t
);
#[cfg(feature = "std")]
plain!(
    crate::pfront_subject_t,
    crate::pfront_allowed_t,
    crate::pfront_gap_t,
    crate::pfront_motion_t,
    crate::pfront_body_end_t
);

/// The outcome of a function that C calls.
pub(crate) type Done = Result<(), Fault>;

/// Someone who keeps to the contract of the header.
pub(crate) struct Caller(());

impl Caller {
    /// # Safety
    /// Until [`Caller::call`] returns, each pointer that [`Call`] is given is null, or points to as many elements as
    /// [`Call`] is told, which nobody else writes meanwhile nor reads if [`Call`] may write them, and which are
    /// initialised if it reads them.
    pub(crate) unsafe fn trusted() -> Self {
        Self(())
    }

    /// Runs a function of the library and tells `error` and the caller what became of it.
    pub(crate) fn call(
        self,
        error: *mut pfront_error_t,
        body: impl for<'c> FnOnce(&mut Call<'c>) -> Done,
    ) -> pfront_status_t {
        if !error.is_aligned() {
            return PFRONT_MISALIGNED;
        }
        let mut call = Call {
            claims: [Claim::NONE; 6],
            count: 0,
            #[cfg(feature = "std")]
            inside: [const { None }; 2],
            lifetime: PhantomData,
        };
        let fault = match environment::with_default(|| guarded(|| body(&mut call))) {
            Ok(()) => Fault::new(PFRONT_OK),
            Err(fault) => fault,
        };
        if !error.is_null() {
            // SAFETY: it is aligned, and by the contract one is there.
            unsafe { error.write(fault) };
        }
        fault.status
    }
}

/// Nothing may unwind into C.
#[cfg(feature = "std")]
fn guarded(body: impl FnOnce() -> Done) -> Done {
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(body));
    caught.unwrap_or_else(|_| Err(Fault::new(PFRONT_DAMAGED)))
}

/// There is no unwinding.
#[cfg(not(feature = "std"))]
fn guarded(body: impl FnOnce() -> Done) -> Done {
    body()
}

/// Addresses that a call writes.
#[derive(Clone, Copy)]
struct Claim {
    start: usize,
    end: usize,
    /// Whether they are lent during the call, or written when it ends.
    lent: bool,
}

impl Claim {
    const NONE: Self = Self { start: 0, end: 0, lent: false };
}

/// The memory that one call uses. The references that it lends live as long as the call, `'c`.
///
/// Calls claim the buffers that they write first, so only these claims need to be kept.
pub(crate) struct Call<'c> {
    claims: [Claim; 6],
    count: usize,
    /// The structures that nobody else may free or change until the call ends.
    #[cfg(feature = "std")]
    inside: [Option<handle::Use>; 2],
    lifetime: PhantomData<&'c mut ()>,
}

impl<'c> Call<'c> {
    /// An array to read.
    pub(crate) fn read<T: Plain>(
        &self,
        what: &'static CStr,
        first: *const T,
        len: usize,
    ) -> Result<&'c [T], Fault> {
        let addresses = addresses(what, first, len)?;
        if addresses.is_empty() {
            return Ok(&[]);
        }
        self.apart(what, &addresses, |_| true)?;
        // SAFETY: by the contract so many elements are there and nobody writes them, nor do we, since they overlap
        // nothing of what is to be written; any bytes make a `T`; they are aligned and at most isize::MAX bytes.
        Ok(unsafe { slice::from_raw_parts(first, len) })
    }

    /// An array to write.
    pub(crate) fn write<T: Plain>(
        &mut self,
        what: &'static CStr,
        first: *mut T,
        len: usize,
    ) -> Result<&'c mut [T], Fault> {
        let addresses = addresses(what, first, len)?;
        if addresses.is_empty() {
            return Ok(&mut []);
        }
        self.claim(what, addresses, true)?;
        // SAFETY: as for `read`; besides, whatever else is lent during this call does not overlap it, and nothing that
        // was not initialised is read.
        Ok(unsafe { slice::from_raw_parts_mut(first, len) })
    }

    /// A structure to write in place.
    pub(crate) fn one<T: Plain>(
        &mut self,
        what: &'static CStr,
        at: *mut T,
    ) -> Result<&'c mut T, Fault> {
        let [one] = self.write(what, at, 1)? else { return Err(Fault::of(PFRONT_NULL, what)) };
        Ok(one)
    }

    /// Scratch of any alignment to mark the triangles of an order in: at least a word.
    pub(crate) fn marks(
        &mut self,
        scratch: *mut c_void,
        bytes: usize,
    ) -> Result<&'c mut [u32], Fault> {
        Fault::room(c"scratch", bytes, size_of::<u32>() + align_of::<u32>() - 1)?;
        let scratch = self.write(c"scratch", scratch.cast::<u8>(), bytes)?;
        let (_, words, _) = bytemuck::pod_align_to_mut(scratch);
        Ok(words)
    }

    /// A copy of a structure, which may lie where a result goes.
    pub(crate) fn get<T: Plain>(&self, what: &'static CStr, at: *const T) -> Result<T, Fault> {
        self.apart(what, &addresses(what, at, 1)?, |claim| claim.lent)?;
        // SAFETY: by the contract one is there and nobody writes it; any bytes make a `T`; it is aligned.
        Ok(unsafe { at.read() })
    }

    /// Where a result goes in the end.
    pub(crate) fn out<T: Copy>(
        &mut self,
        what: &'static CStr,
        at: *mut T,
    ) -> Result<Out<T>, Fault> {
        self.claim(what, addresses(what, at, 1)?, false)?;
        Ok(Out(at))
    }

    /// Remembers what is to be written.
    fn claim(&mut self, what: &'static CStr, addresses: Range<usize>, lent: bool) -> Done {
        self.apart(what, &addresses, |_| true)?;
        let free = self.claims.get_mut(self.count).ok_or(Fault::new(PFRONT_DAMAGED))?;
        (*free, self.count) =
            (Claim { start: addresses.start, end: addresses.end, lent }, self.count + 1);
        Ok(())
    }

    /// `Ok` if addresses overlap none of those claims.
    fn apart(
        &self,
        what: &'static CStr,
        addresses: &Range<usize>,
        which: impl Fn(&Claim) -> bool,
    ) -> Done {
        let overlaps = |claim: &Claim| addresses.start < claim.end && claim.start < addresses.end;
        if self.claims.iter().any(|claim| which(claim) && overlaps(claim)) {
            return Err(Fault::of(PFRONT_OVERLAP, what));
        }
        Ok(())
    }
}

/// The addresses of an array, if they can be some.
fn addresses<T>(what: &'static CStr, first: *const T, len: usize) -> Result<Range<usize>, Fault> {
    let start = first.addr();
    if len == 0 {
        return Ok(start..start);
    }
    if first.is_null() {
        return Err(Fault::of(PFRONT_NULL, what));
    }
    if !first.is_aligned() {
        return Err(Fault::of(PFRONT_MISALIGNED, what).numbers(align_of::<T>(), 0));
    }
    let bytes = len.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= isize::MAX as usize);
    let Some(end) = bytes.and_then(|bytes| start.checked_add(bytes)) else {
        return Err(Fault::of(PFRONT_TOO_LONG, what).numbers(0, len));
    };
    Ok(start..end)
}

/// Where a result goes.
pub(crate) struct Out<T>(*mut T);

impl<T: Copy> Out<T> {
    /// A result that there may be none of, and whether there is.
    pub(crate) fn set_some(self, found: Out<u32>, value: Option<T>) {
        found.set(value.is_some().into());
        if let Some(value) = value {
            self.set(value);
        }
    }

    pub(crate) fn set(self, value: T) {
        // SAFETY: `Call::out` has checked that it is aligned and not null, and by the contract one is there; what is
        // lent overlaps none of it, or is not used any more.
        unsafe { self.0.write(value) };
    }
}
