//! Error codes, and what is told besides.

mod fault;

use core::ffi::{CStr, c_char};
pub(crate) use fault::Fault;
use pfront_capi_entry::entry;

/// The result of a call. All but PFRONT_OK are errors: then no structure was made or changed, and what arrays hold that were
/// to be written is anyone's guess.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum pfront_status_t {
    /// Done.
    PFRONT_OK = 0,
    /// `what` is null and must not be.
    PFRONT_NULL = 1,
    /// `what` is not at a multiple of `needed` bytes.
    PFRONT_MISALIGNED = 2,
    /// `what` has more elements, `given`, than memory can hold; or more than `needed`, the most of a blob.
    PFRONT_TOO_LONG = 3,
    /// `what` overlaps something else that is to be written.
    PFRONT_OVERLAP = 4,
    /// `what` holds `given` elements, or bytes where it is scratch; `needed` are needed.
    PFRONT_TOO_SMALL = 5,
    /// `what` was not filled in by the function that makes it.
    PFRONT_NOT_MADE = 6,
    /// `what` is `given`, at `index` if it is an array, and must be below `needed`; or it is 1, which is no node.
    PFRONT_OUT_OF_RANGE = 7,
    /// Vertex `index` has a coordinate that is NaN or infinite.
    PFRONT_NOT_FINITE = 8,
    /// Triangle `index` names vertex `given`; there are `needed` vertices.
    PFRONT_NO_SUCH_VERTEX = 9,
    /// A mesh has `given` triangles, more than the `needed` that are supported.
    PFRONT_TOO_MANY_TRIANGLES = 10,
    /// `given` positions, for a mesh of `needed` vertices.
    PFRONT_VERTEX_COUNT = 11,
    /// Entry `index` (four to a row) of the pose `what` is NaN or infinite.
    PFRONT_POSE_NOT_FINITE = 12,
    /// Row `index` of the pose `what` takes the mesh too far from the origin, beyond 2^125.
    PFRONT_POSE_RANGE = 13,
    /// Entry `index` of an order names no triangle, one that was named before, or is in no leaf; or there are `given`
    /// entries for `needed` triangles.
    PFRONT_BVH_ORDER = 14,
    /// Node `index` names children or triangles that it cannot have, or lies too deep; or there are `given` nodes
    /// instead of `needed`.
    PFRONT_BVH_NODE = 15,
    /// The box of node `index` is not finite or does not contain what lies below.
    PFRONT_BVH_BOX = 16,
    /// The cursor was made for a query of BVHs of other sizes.
    PFRONT_FOREIGN_CURSOR = 17,
    /// The arrays of a BVH were damaged since it was built, or there is a fault in pfront. Standard error says more.
    PFRONT_DAMAGED = 18,
    /// The BVH borrows a blob, which stays as it is: a copy of its nodes and its order can be adopted and refitted.
    PFRONT_READ_ONLY = 19,
    /// The bytes do not begin as a blob does.
    PFRONT_BLOB_MAGIC = 20,
    /// Version `given` has written the blob; only `needed` is known.
    PFRONT_BLOB_VERSION = 21,
    /// The blob has `needed` bytes; there are `given`.
    PFRONT_BLOB_LENGTH = 22,
    /// Byte `index` of the blob is not what its counts and its version determine.
    PFRONT_BLOB_BYTE = 23,
    /// The checksum of the blob is `given` and must be `needed`: some byte has changed.
    PFRONT_BLOB_CHECKSUM = 24,
    /// Blobs are little-endian, and this machine is not: it can write them, but not borrow.
    PFRONT_BIG_ENDIAN = 25,
    /// The calling thread flushes subnormal numbers or does not round to nearest. On x86-64 and AArch64 each function
    /// sets what it needs and restores it on return, so this is for other processors only.
    PFRONT_FLOAT_ENVIRONMENT = 26,
    /// The pose `what` is flat or not finite, so that it has no inverse.
    PFRONT_NO_INVERSE = 27,
    /// The allocator `what` does not have `needed` bytes. Nothing has changed.
    PFRONT_OUT_OF_MEMORY = 28,
    /// Body `index` is not in the scene: it was removed, or never added.
    PFRONT_STALE_BODY = 29,
    /// Vertex `index` has a coordinate beyond 2^125, the limit in f64.
    PFRONT_POSITION_RANGE = 30,
    /// Positions or a blob are in f64 where f32 is taken, or in f32 where f64 is.
    PFRONT_OTHER_PRECISION = 31,
    /// The position in f32 of vertex `index` of a blob is not that in f64 minus the origin.
    PFRONT_SHADOW = 32,
    /// Another thread is inside a call with `what`, which is for one thread at a time, or is to be freed.
    PFRONT_BUSY = 33,
    /// `what` has threads, which a child of fork has not: this process did not make it.
    PFRONT_FORKED = 34,
    /// The quaternion `what` is no rotation: the square of its length is not within 1/1024 of 1, or is NaN.
    PFRONT_NOT_UNIT = 35,
    /// There is no GPU that can be used, or the library was built without.
    PFRONT_NO_DEVICE = 36,
    /// The GPU failed: it is lost or out of memory, has no room for a mesh, or does not compute with a coordinate as large as one of
    /// these. Another executor may answer.
    PFRONT_DEVICE = 37,
    /// The distance `what` is NaN, infinite or negative.
    PFRONT_DISTANCE = 38,
    /// The model `what` is no solid: edge `given` of triangle `index`, from that corner to the next, has an odd number of triangles.
    PFRONT_OPEN_EDGE = 39,
    /// Triangles `index` and `given` of the model `what` meet beyond the corners that they share.
    PFRONT_MEETS_ITSELF = 40,
    /// The model `what` is no solid: it has no volume.
    PFRONT_NO_VOLUME = 41,
    /// Triangle `index` of a model is not the same at the `end` of a motion as at its start; or `what` is a pose of one that deforms; or body `index` has
    /// two ends among `ends`.
    PFRONT_MOTION = 42,
}

/// Where a call went wrong: see `pfront_status_t` for what the numbers mean. Functions that take a pointer to one
/// write it whatever becomes of the call; it may be null.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct pfront_error_t {
    /// The status that the function returned.
    pub status: pfront_status_t,
    /// The parameter or member at fault, by name; null where there is none. The string lives for ever.
    pub what: *const c_char,
    /// The vertex, triangle, node, entry or row at fault.
    pub index: usize,
    /// The number that is needed, or the limit.
    pub needed: usize,
    /// The number that was given.
    pub given: usize,
}

/// The meaning of an error code, in a sentence without numbers. Takes any number; the string lives for ever.
#[entry]
fn pfront_error_text(status: u32) -> *const c_char {
    const TEXTS: [&CStr; 43] = [
        c"done",
        c"a pointer is null",
        c"a pointer is not aligned",
        c"an array is longer than memory or a blob can be",
        c"an array or a structure overlaps another one that is written",
        c"a buffer is too small",
        c"a structure was not filled in by the function that makes it",
        c"an option, a count or an index is out of range",
        c"a coordinate is NaN or infinite",
        c"a triangle names a vertex that does not exist",
        c"a mesh has too many triangles",
        c"a mesh has another number of vertices",
        c"an entry of a pose is NaN or infinite",
        c"a pose takes a mesh too far from the origin",
        c"the order of a BVH does not name each triangle once",
        c"a node of a BVH has children or triangles that it cannot have",
        c"the box of a node of a BVH does not contain what lies below it: refit first",
        c"a cursor belongs to another query",
        c"the arrays of a BVH are damaged, or there is a fault in pfront",
        c"a BVH borrows a blob, which cannot be written",
        c"the bytes are no blob",
        c"a blob is of another version: write it again",
        c"a blob is cut short",
        c"a byte of a blob has no meaning: write it again",
        c"a byte of a blob has changed since it was written",
        c"a big-endian machine cannot borrow a blob",
        c"this thread flushes subnormal numbers or does not round to nearest",
        c"a pose is flat or not finite and has no inverse",
        c"an allocator is out of memory",
        c"a body is not in the scene",
        c"a coordinate in f64 is beyond 2^125",
        c"positions are in f64 and not in f32, or in f32 and not in f64",
        c"a position in f32 of a blob is not that in f64 minus the origin",
        c"another thread is inside a call with a structure that is for one at a time",
        c"a structure has threads of the process that this one was forked from",
        c"a quaternion is not of length 1",
        c"there is no GPU, or the library was built without",
        c"the GPU failed",
        c"a distance is NaN, infinite or negative",
        c"an edge is open: a mesh is no solid",
        c"triangles meet their own mesh",
        c"a mesh has no volume",
        c"a triangle is not the same at the end of a motion, or a model that deforms has a pose",
    ];
    TEXTS.get(status as usize).copied().unwrap_or(c"no error code of pfront").as_ptr()
}

/// The version of the library, as in "0.1.0". The string lives for ever.
#[entry]
fn pfront_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
