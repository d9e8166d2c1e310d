//! The error of reading blobs.

use pfront_core::{BvhError, CapacityError, MeshError};

/// The fault of bytes that are not a blob of a BVH, or the reason why they cannot be read as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BlobError {
    /// The bytes do not begin with [`MAGIC`](super::MAGIC).
    #[error("this is not a baked mesh: `pfront bake` makes one")]
    Magic,
    /// The blob is of an unknown version.
    #[error("a baked mesh of version {found}, not {known}: bake it again")]
    Version {
        /// The version of the blob.
        found: u32,
        /// The version that is read.
        known: u32,
    },
    /// The blob is shorter or longer than the length in its header or the counts there say, or than a header.
    #[error("a baked mesh of {needed} bytes in {found}: copy exactly those")]
    Length {
        /// How many bytes it should have.
        needed: u64,
        /// How many there are.
        found: usize,
    },
    /// A byte of the header, or between sections, is not what the counts in the header and the version determine.
    #[error("byte {byte} has no meaning in this version: bake the mesh again")]
    Byte {
        /// The byte.
        byte: usize,
    },
    /// The bytes have changed since they were written.
    #[error(
        "the checksum is {computed:#010x}, not {stored:#010x}: a byte has changed; copy the baked \
         mesh again"
    )]
    Checksum {
        /// The checksum in the header.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// The address of the bytes is not aligned.
    #[error(
        "the bytes do not begin at a multiple of {needed}: keep them in an `Aligned`, or copy them \
         by `Blob::read_into`"
    )]
    Misaligned {
        /// The alignment needed.
        needed: usize,
    },
    /// A blob is little-endian and this machine is not, so it cannot be borrowed.
    #[error("a big-endian machine must copy a baked mesh by `Blob::read_into`")]
    BigEndian,
    /// The mesh is in f64, and this call reads only those in f32.
    #[error("a baked mesh in f64: read it by `Blob::read_into_f64`")]
    InF64,
    /// The checksum is right, but positions and triangles are not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The checksum is right, but nodes and order are not a BVH of the mesh.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// A buffer is too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}
