//! The error of reading and writing blobs.

use super::{Counts, VERSION};
use crate::bvh::BvhError;
use crate::{CapacityError, MeshError};
use core::fmt;

/// The fault of bytes that are not a blob of a BVH, or the reason why they cannot be read or written as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BlobError {
    /// The bytes do not begin with [`MAGIC`](super::MAGIC).
    Magic,
    /// The blob has another version than [`VERSION`].
    Version {
        /// The version of the blob.
        found: u32,
    },
    /// A section is laid out in an unknown way.
    Kind {
        /// The section.
        section: &'static str,
        /// Its kind.
        found: u16,
    },
    /// The blob is shorter or longer than its header says, or than a header.
    Length {
        /// How many bytes it should have.
        needed: u64,
        /// How many there are.
        found: usize,
    },
    /// The counts in the header take another number of bytes than there are.
    Counts {
        /// The counts in the header.
        counts: Counts,
        /// How many bytes there are.
        found: usize,
    },
    /// A byte that is always 0 is not.
    NotZero {
        /// The byte, or the first of a field.
        byte: usize,
    },
    /// The bytes have changed since they were written.
    Checksum {
        /// The checksum in the header.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// The address of the bytes is not aligned.
    Misaligned {
        /// The alignment needed.
        needed: usize,
    },
    /// A blob is little-endian and this machine is not, so it cannot be borrowed.
    BigEndian,
    /// The checksum is right, but positions and triangles are not a mesh.
    Mesh(MeshError),
    /// The checksum is right, but nodes and order are not a BVH of the mesh.
    Bvh(BvhError),
    /// A buffer is too small.
    Capacity(CapacityError),
    /// A count does not fit into 32 bits.
    TooMany {
        /// The things counted.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for BlobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Magic => write!(f, "this is not a baked mesh: `pfront bake` makes one"),
            Self::Version { found } => {
                write!(f, "a baked mesh of version {found}, not {VERSION}: bake it again")
            }
            Self::Kind { section, found } => {
                write!(f, "a baked mesh whose {section} are of unknown kind {found}: bake it again")
            }
            Self::Length { needed, found } => {
                write!(f, "a baked mesh of {needed} bytes in {found}: copy exactly those")
            }
            Self::Counts { counts: Counts { nodes, vertices, triangles }, found } => write!(
                f,
                "{nodes} nodes, {vertices} vertices and {triangles} triangles do not take {found} \
                 bytes: bake the mesh again"
            ),
            Self::NotZero { byte } => write!(f, "byte {byte} must be 0: bake the mesh again"),
            Self::Checksum { stored, computed } => write!(
                f,
                "the checksum is {computed:#010x}, not {stored:#010x}: a byte has changed; copy the baked mesh again"
            ),
            Self::Misaligned { needed } => write!(
                f,
                "the bytes do not begin at a multiple of {needed}: keep them in an `Aligned`, or \
                 copy them by `Blob::read_into`"
            ),
            Self::BigEndian => {
                write!(f, "a big-endian machine must copy a baked mesh by `Blob::read_into`")
            }
            Self::Mesh(error) => error.fmt(f),
            Self::Bvh(error) => error.fmt(f),
            Self::Capacity(error) => error.fmt(f),
            Self::TooMany { what, count } => {
                write!(f, "a baked mesh can have {} {what}, not {count}", u32::MAX)
            }
        }
    }
}

impl core::error::Error for BlobError {}

impl From<MeshError> for BlobError {
    fn from(error: MeshError) -> Self {
        Self::Mesh(error)
    }
}

impl From<BvhError> for BlobError {
    fn from(error: BvhError) -> Self {
        Self::Bvh(error)
    }
}

impl From<CapacityError> for BlobError {
    fn from(error: CapacityError) -> Self {
        Self::Capacity(error)
    }
}
