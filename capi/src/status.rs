//! Error codes, and what is told besides.

use core::ffi::{CStr, c_char};
use core::ptr::null;
use pfront_core::pose::PoseError;
use pfront_core::{BvhError, CapacityError, MeshError};

/// What became of a call. All but PFRONT_OK are errors: then nothing was done, unless the function says otherwise.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum pfront_status_t {
    /// Done.
    PFRONT_OK = 0,
    /// `what` is null and must not be.
    PFRONT_NULL = 1,
    /// `what` is not at a multiple of `needed` bytes.
    PFRONT_MISALIGNED = 2,
    /// `what` has more elements, `given`, than memory can hold.
    PFRONT_TOO_LONG = 3,
    /// `what`, which is to be written or read, overlaps another array that is to be written.
    PFRONT_OVERLAP = 4,
    /// `what` holds `given` elements, or bytes where it is scratch; `needed` are needed.
    PFRONT_TOO_SMALL = 5,
    /// `what` was not filled in by the function that makes it.
    PFRONT_NOT_MADE = 6,
    /// `what` is `given`, at `index` if it is an array, and must be below `needed`.
    PFRONT_OUT_OF_RANGE = 7,
    /// Vertex `index` has a coordinate that is infinite or no number.
    PFRONT_NOT_FINITE = 8,
    /// Triangle `index` names vertex `given`; there are `needed` vertices.
    PFRONT_NO_SUCH_VERTEX = 9,
    /// A mesh has `given` triangles, more than the `needed` that are supported.
    PFRONT_TOO_MANY_TRIANGLES = 10,
    /// `given` positions, for a mesh of `needed` vertices.
    PFRONT_VERTEX_COUNT = 11,
    /// Entry `index` (four to a row) of the pose `what` is infinite or no number.
    PFRONT_POSE_NOT_FINITE = 12,
    /// Row `index` of the pose `what` takes the mesh too far from the origin, beyond 2^125.
    PFRONT_POSE_RANGE = 13,
    /// Entry `index` of an order names no triangle, one that was named before, or is in no leaf; or there are `given`
    /// entries for `needed` triangles.
    PFRONT_BVH_ORDER = 14,
    /// Node `index` names children or triangles that it cannot have, or lies too deep; or there are `given` nodes of
    /// which `needed` can be reached.
    PFRONT_BVH_NODE = 15,
    /// The box of node `index` is not finite or does not contain what lies below.
    PFRONT_BVH_BOX = 16,
    /// The cursor was made for a query of BVHs of other sizes.
    PFRONT_FOREIGN_CURSOR = 17,
    /// The arrays of a BVH were damaged since it was built, or there is a fault in pfront. Standard error says more.
    PFRONT_DAMAGED = 18,
}
use pfront_status_t::*;

/// Where a call went wrong: see `pfront_status_t` for what the numbers mean. Functions that take a pointer to one
/// write it whatever becomes of the call; it may be null.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_error_t {
    /// What the function returned.
    pub status: pfront_status_t,
    /// The parameter or member at fault, by name; null where there is none. The string lives for ever.
    pub what: *const c_char,
    /// The vertex, triangle, node, entry or row at fault.
    pub index: usize,
    /// What is needed, or the limit.
    pub needed: usize,
    /// What was given.
    pub given: usize,
}

/// An error on its way to the caller.
pub(crate) type Fault = pfront_error_t;

impl Fault {
    pub(crate) fn new(status: pfront_status_t) -> Self {
        Self { status, what: null(), index: 0, needed: 0, given: 0 }
    }

    pub(crate) fn of(status: pfront_status_t, what: &'static CStr) -> Self {
        Self { what: what.as_ptr(), ..Self::new(status) }
    }

    pub(crate) fn at(self, index: usize) -> Self {
        Self { index, ..self }
    }

    pub(crate) fn numbers(self, needed: usize, given: usize) -> Self {
        Self { needed, given, ..self }
    }

    /// `Ok` if `given` is below `limit`.
    pub(crate) fn below(what: &'static CStr, given: usize, limit: usize) -> Result<(), Self> {
        if given < limit {
            return Ok(());
        }
        Err(Self::of(PFRONT_OUT_OF_RANGE, what).numbers(limit, given))
    }

    /// `Ok` if `given` elements are enough.
    pub(crate) fn room(what: &'static CStr, given: usize, needed: usize) -> Result<(), Self> {
        if given >= needed {
            return Ok(());
        }
        Err(Self::of(PFRONT_TOO_SMALL, what).numbers(needed, given))
    }

    /// An error in the pose that C calls `what`.
    pub(crate) fn pose(what: &'static CStr) -> impl Fn(PoseError) -> Self {
        move |error| match error {
            PoseError::NonFinite { row, column } => {
                Self::of(PFRONT_POSE_NOT_FINITE, what).at(4 * row + column)
            }
            PoseError::Range { row } => Self::of(PFRONT_POSE_RANGE, what).at(row),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

impl From<CapacityError> for Fault {
    fn from(CapacityError { buffer, needed, capacity }: CapacityError) -> Self {
        let what = match buffer {
            "nodes" | "front" => c"nodes",
            "fans" => c"fans",
            "memory" => c"past",
            _ => return Self::new(PFRONT_DAMAGED),
        };
        Self::of(PFRONT_TOO_SMALL, what).numbers(needed, capacity)
    }
}

impl From<MeshError> for Fault {
    fn from(error: MeshError) -> Self {
        match error {
            MeshError::NonFinite { vertex } => Self::of(PFRONT_NOT_FINITE, c"positions").at(vertex),
            MeshError::IndexOutOfRange { triangle, index, vertices } => {
                let fault = Self::of(PFRONT_NO_SUCH_VERTEX, c"triangles").at(triangle);
                fault.numbers(vertices, index as usize)
            }
            MeshError::TooManyTriangles { triangles } => {
                let fault = Self::of(PFRONT_TOO_MANY_TRIANGLES, c"triangles");
                fault.numbers(pfront_core::mesh::MAX_TRIANGLES, triangles)
            }
            MeshError::VertexCount { expected, found } => {
                Self::of(PFRONT_VERTEX_COUNT, c"positions").numbers(expected, found)
            }
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

impl From<BvhError> for Fault {
    fn from(error: BvhError) -> Self {
        let (order, node) =
            (Self::of(PFRONT_BVH_ORDER, c"order"), Self::of(PFRONT_BVH_NODE, c"nodes"));
        match error {
            BvhError::OrderLength { found, expected } => order.numbers(expected, found),
            BvhError::Order { entry } | BvhError::Uncovered { entry } => order.at(entry),
            BvhError::Child { node: at } | BvhError::Leaf { node: at } => node.at(at),
            BvhError::Depth { node: at } => node.at(at),
            BvhError::NodeCount { reached, found } => node.numbers(reached, found),
            BvhError::Box { node: at } => Self::of(PFRONT_BVH_BOX, c"nodes").at(at),
            _ => Self::new(PFRONT_DAMAGED),
        }
    }
}

/// What an error code means, in a sentence without numbers. Takes any number; the string lives for ever.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "C finds functions by name")]
pub extern "C" fn pfront_error_text(status: u32) -> *const c_char {
    const TEXTS: [&CStr; 19] = [
        c"done",
        c"a pointer is null",
        c"a pointer is not aligned",
        c"an array is longer than memory can be",
        c"an array overlaps another one that is written",
        c"a buffer is too small",
        c"a structure was not filled in by the function that makes it",
        c"an option, a count or an index is out of range",
        c"a coordinate is infinite or no number",
        c"a triangle names a vertex that does not exist",
        c"a mesh has too many triangles",
        c"a mesh has another number of vertices",
        c"an entry of a pose is infinite or no number",
        c"a pose takes a mesh too far from the origin",
        c"the order of a BVH does not name each triangle once",
        c"a node of a BVH has children or triangles that it cannot have",
        c"the box of a node of a BVH does not contain what lies below it: refit first",
        c"a cursor belongs to another query",
        c"the arrays of a BVH are damaged",
    ];
    TEXTS.get(status as usize).copied().unwrap_or(c"no error code of pfront").as_ptr()
}

/// The version of the library, as in "0.1.0". The string lives for ever.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "C finds functions by name")]
pub extern "C" fn pfront_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
