//! Why bytes are no blob, or a blob no BVH.

use super::{Counts, VERSION};
use crate::bvh::BvhError;
use crate::{CapacityError, MeshError};
use core::fmt;

/// Why bytes are no blob of a BVH, or cannot be read or written as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BlobError {
    /// The bytes begin with something else than [`MAGIC`](super::MAGIC).
    Magic,
    /// Another version has written it.
    Version {
        /// Which one.
        found: u32,
    },
    /// A section is laid out in a way that is not known here.
    Kind {
        /// Which section.
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
    /// So much takes another number of bytes than there are.
    Counts {
        /// What the header says there is.
        counts: Counts,
        /// How many bytes there are.
        found: usize,
    },
    /// A byte is not 0 that always is.
    NotZero {
        /// The byte, or the first of a field.
        byte: usize,
    },
    /// Some byte is not what was written.
    Checksum {
        /// The checksum in the header.
        stored: u32,
        /// That of the bytes.
        computed: u32,
    },
    /// The bytes do not begin at a multiple of so many bytes.
    Misaligned {
        /// How many.
        needed: usize,
    },
    /// A blob is little-endian and this machine is not, so it cannot be borrowed.
    BigEndian,
    /// The checksum is right, but positions and triangles are no mesh.
    Mesh(MeshError),
    /// The checksum is right, but nodes and order are no BVH of the mesh.
    Bvh(BvhError),
    /// A buffer of the caller's is too small.
    Capacity(CapacityError),
    /// A count does not fit into 32 bits.
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for BlobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Magic => write!(f, "this is no baked mesh: `pfront bake` makes one"),
            Self::Version { found } => write!(
                f,
                "a baked mesh of version {found}, but only {VERSION} is known: bake it again"
            ),
            Self::Kind { section, found } => write!(
                f,
                "a baked mesh whose {section} are of kind {found}, which is not known: bake it again"
            ),
            Self::Length { needed, found } => write!(
                f,
                "a baked mesh of {needed} bytes in {found}: copy it whole, and nothing behind it"
            ),
            Self::Counts { counts, found } => {
                let Counts { nodes, vertices, triangles } = counts;
                write!(
                    f,
                    "{nodes} nodes, {vertices} vertices and {triangles} triangles do not make a \
                     baked mesh of {found} bytes: bake it again"
                )
            }
            Self::NotZero { byte } => write!(f, "byte {byte} must be 0: bake the mesh again"),
            Self::Checksum { stored, computed } => write!(
                f,
                "the checksum is {computed:#010x} and should be {stored:#010x}: a byte has changed \
                 since the mesh was baked; copy it again"
            ),
            Self::Misaligned { needed } => write!(
                f,
                "the bytes do not begin at a multiple of {needed}: keep them in an `Aligned`, or \
                 copy them by `Blob::read_into`"
            ),
            Self::BigEndian => write!(
                f,
                "a big-endian machine cannot borrow a baked mesh: copy it by `Blob::read_into`"
            ),
            Self::Mesh(error) => error.fmt(f),
            Self::Bvh(error) => error.fmt(f),
            Self::Capacity(error) => error.fmt(f),
            Self::TooMany { what, count } => {
                write!(f, "{count} {what} are more than a baked mesh can have, {}", u32::MAX)
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
