//! A mesh and its BVH as bytes: baked once, kept in flash or in a file, and borrowed from there.
//!
//! A blob is a header of 64 bytes and four sections, in this order. Everything is little-endian, and the same
//! on every machine; f32 is IEEE 754 binary32, bit by bit.
//!
//! | offset | type | meaning |
//! |---:|---|---|
//! | 0 | `[u8; 8]` | [`MAGIC`] |
//! | 8 | `u32` | [`VERSION`] |
//! | 12 | `u32` | checksum of every byte but these four: CRC-32/ISO-HDLC, the one of zlib |
//! | 16 | `u64` | bytes of the whole blob |
//! | 24 | `[u16; 4]` | kinds of the four sections; so far each is 1 |
//! | 32 | `u32` | n, the number of nodes |
//! | 36 | `u32` | v, the number of vertices |
//! | 40 | `u32` | t, the number of triangles |
//! | 44 | `[u8; 20]` | 0 |
//! | 64 | `[Node; n]` | nodes of kind 1: [`Node`], 32 bytes each |
//! | then | `[[f32; 3]; v]` | positions of kind 1 |
//! | then | `[[u32; 3]; t]` | triangles of kind 1 |
//! | then | `[u32; t]` | order of kind 1 |
//!
//! A section begins at the next multiple of 16 bytes; what lies between is 0. So there is one blob of a BVH:
//! who writes again what was read gets the same bytes.
//!
//! # What is trusted
//! Nothing. [`Blob::new`] refuses what another version wrote, what is cut short, and what was changed by
//! accident: the checksum finds every change of one or two bits and of any 32 bits in a row, and misses one in
//! 2³² of all others. It is no signature, so [`Blob::bvh`] checks what a right checksum says nothing of: every
//! coordinate, index, box and child, as [`Mesh::new`] and [`Bvh::new`] do. [`Blob::new_unchecked`] and
//! [`Blob::bvh_unchecked`] are for bytes that the caller vouches for, in firmware that is signed as a whole.
//!
//! # Alignment
//! To be borrowed, the bytes must begin at a multiple of 4; at one of 64 siblings share a cache line.
//! `include_bytes!` promises neither, [`Aligned`] both. [`Blob::read_into`] copies from anywhere.
//!
//! # Endianness
//! A big-endian machine writes and checks the same blobs, but cannot borrow them: [`Blob::bvh`] says so, and
//! [`Blob::read_into`] copies them into memory of the caller's.
//!
//! # Versions
//! [`VERSION`] changes when old readers would misread a blob. Other layouts of a section, narrower ones for
//! instance, are other kinds of it, which those who do not know them refuse. The first 12 bytes stay as they
//! are in every version.
//!
//! # Examples
//! ```
//! use pfront_core::blob::{self, Aligned, Counts};
//! use pfront_core::{Blob, Bvh, Mesh, Node, bvh::check_scratch_bound};
//! // On the machine that bakes:
//! let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
//! let nodes = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
//! let bvh = Bvh::new(mesh, &nodes, &[0], &mut [0])?;
//! const BYTES: usize = Counts { nodes: 1, vertices: 3, triangles: 1 }.bytes();
//! let mut baked = Aligned([0; BYTES]);
//! blob::write(&bvh, &mut baked.0)?;
//!
//! // On the one that borrows:
//! let blob = Blob::new(&baked.0)?;
//! # if cfg!(target_endian = "big") { return Ok(()) }
//! let borrowed = blob.bvh(&mut [0; check_scratch_bound(1)])?;
//! assert_eq!(borrowed.mesh().triangle(0), mesh.triangle(0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aligned;
mod bytes;
mod error;
mod header;
#[cfg(test)]
mod tests;

pub use aligned::Aligned;
pub use error::BlobError;
pub use header::{Counts, MAGIC, VERSION};

use crate::bvh::BvhError;
use crate::{Bvh, CapacityError, Mesh, Node};
use bytes::{borrow, copy_from, copy_to};
use header::{Header, Sections, checksum};

/// Bytes whose header says what they are. Copying is free.
#[derive(Clone, Copy, Debug)]
pub struct Blob<'a> {
    bytes: &'a [u8],
    counts: Counts,
}

/// Where [`Blob::read_into`] puts a mesh and its BVH: at least as much of each as [`Blob::counts`] says.
#[derive(Debug)]
pub struct BlobStorage<'s> {
    /// For the nodes.
    pub nodes: &'s mut [Node],
    /// For the positions of the vertices.
    pub positions: &'s mut [[f32; 3]],
    /// For the vertex indices of the triangles.
    pub triangles: &'s mut [[u32; 3]],
    /// For the order: one entry a triangle.
    pub order: &'s mut [u32],
}

impl<'a> Blob<'a> {
    /// Takes bytes for a blob if they are one from the first to the last and the checksum is right.
    ///
    /// # Errors
    /// [`BlobError`] says in what they are none, or of which version or kind.
    ///
    /// # Complexity
    /// O(bytes). Without the feature `std` the checksum goes by a table of 1 KiB, with it by one of 16 KiB.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Blob, BlobError};
    /// assert_eq!(Blob::new(b"solid teapot").err(), Some(BlobError::Magic));
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, BlobError> {
        let (header, blob) = Self::framed(bytes)?;
        let (stored, computed) = (header.checksum(), checksum(bytes));
        if stored != computed {
            return Err(BlobError::Checksum { stored, computed });
        }
        blob.sections().check_gaps(bytes)?;
        Ok(blob)
    }

    /// [`Blob::new`] of the bytes that a longer slice begins with, such as a region of flash; and the rest.
    ///
    /// # Errors
    /// As [`Blob::new`].
    pub fn prefix(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), BlobError> {
        let needed = Header::parse(bytes)?.length();
        let parted = usize::try_from(needed).ok().and_then(|needed| bytes.split_at_checked(needed));
        let (own, rest) = parted.ok_or(BlobError::Length { needed, found: bytes.len() })?;
        Ok((Self::new(own)?, rest))
    }

    /// [`Blob::new`] without computing the checksum: only the header is checked.
    ///
    /// # Wrong answers
    /// Where bytes have changed since they were written, [`Blob::bvh`] may accept a mesh other than was baked.
    ///
    /// # Errors
    /// As [`Blob::new`], but for the checksum.
    ///
    /// # Complexity
    /// O(1).
    pub fn new_unchecked(bytes: &'a [u8]) -> Result<Self, BlobError> {
        Self::framed(bytes).map(|(_, blob)| blob)
    }

    /// The header, if it says of what length the bytes are.
    fn framed(bytes: &'a [u8]) -> Result<(Header, Self), BlobError> {
        let header = Header::parse(bytes)?;
        let (needed, found) = (header.length(), bytes.len());
        if needed != found as u64 {
            return Err(BlobError::Length { needed, found });
        }
        let counts = header.counts();
        if counts.bytes() != found {
            return Err(BlobError::Counts { counts, found });
        }
        Ok((header, Self { bytes, counts }))
    }

    /// All bytes, from the header to the last of the order.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// How much of everything there is.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Borrows the mesh and the BVH, after checking all that a walk relies on.
    ///
    /// `scratch` is as for [`Bvh::new`]: [`check_scratch_bound`](crate::bvh::check_scratch_bound) words of it,
    /// or fewer and more time.
    ///
    /// # Errors
    /// [`BlobError::Mesh`] or [`BlobError::Bvh`] names what is at fault; [`BlobError::Misaligned`] and
    /// [`BlobError::BigEndian`] are about where the bytes lie, not what they are.
    ///
    /// # Complexity
    /// As [`Bvh::new`] and [`Mesh::new`]: O(vertices + triangles).
    pub fn bvh(&self, scratch: &mut [u32]) -> Result<Bvh<'a>, BlobError> {
        let bvh = self.bvh_unchecked()?;
        let mesh = Mesh::new(bvh.mesh().positions(), bvh.mesh().triangles())?;
        Ok(Bvh::new(mesh, bvh.nodes(), bvh.order(), scratch)?)
    }

    /// Borrows the mesh and the BVH without checking them.
    ///
    /// # Panics and wrong answers
    /// As [`Bvh::new_unchecked`], for bytes that [`write()`] has not written.
    ///
    /// # Errors
    /// [`BlobError::Misaligned`], [`BlobError::BigEndian`].
    ///
    /// # Complexity
    /// O(1).
    pub fn bvh_unchecked(&self) -> Result<Bvh<'a>, BlobError> {
        let Sections { nodes, positions, triangles, order } = self.sections();
        let nodes = borrow(nodes.of(self.bytes))?;
        let mesh = Mesh::new_unchecked(
            borrow(positions.of(self.bytes))?,
            borrow(triangles.of(self.bytes))?,
        );
        Ok(Bvh::new_unchecked(mesh, nodes, borrow(order.of(self.bytes))?))
    }

    /// Copies the mesh and the BVH, which works on every machine and wherever the bytes lie, and checks the
    /// copy as [`Blob::bvh`] does.
    ///
    /// # Errors
    /// [`BlobError::Capacity`] if `storage` is too small, [`BlobError::Mesh`] or [`BlobError::Bvh`].
    ///
    /// # Complexity
    /// As [`Blob::bvh`].
    pub fn read_into<'s>(
        &self,
        storage: BlobStorage<'s>,
        scratch: &mut [u32],
    ) -> Result<Bvh<'s>, BlobError> {
        let Sections { nodes, positions, triangles, order } = self.sections();
        let positions = copy_from(positions.of(self.bytes), "positions", storage.positions)?;
        let triangles = copy_from(triangles.of(self.bytes), "triangles", storage.triangles)?;
        let nodes = copy_from(nodes.of(self.bytes), "nodes", storage.nodes)?;
        let order = copy_from(order.of(self.bytes), "order", storage.order)?;
        Ok(Bvh::new(Mesh::new(positions, triangles)?, nodes, order, scratch)?)
    }

    fn sections(&self) -> Sections {
        self.counts.sections()
    }
}

/// Writes a mesh and its BVH as a blob of [`Counts::bytes`] at the beginning of `out`, and returns these.
///
/// # Errors
/// [`BlobError::Capacity`] if `out` is too small; [`BlobError::TooMany`] if a count needs more than 32 bits;
/// [`BlobError::Bvh`] if there is not one order entry a triangle.
///
/// # Complexity
/// O(bytes).
pub fn write<'o>(bvh: &Bvh<'_>, out: &'o mut [u8]) -> Result<&'o [u8], BlobError> {
    let (mesh, counts) = (bvh.mesh(), Counts::of(bvh));
    let (found, expected) = (bvh.order().len(), counts.triangles);
    if found != expected {
        return Err(BvhError::OrderLength { found, expected }.into());
    }
    let mut header = Header::new(counts)?;
    CapacityError::check("out", counts.bytes(), out.len())?;
    let out = out.get_mut(..counts.bytes()).unwrap_or_default();
    out.fill(0);
    let Sections { nodes, positions, triangles, order } = counts.sections();
    copy_to(bvh.nodes(), nodes.of_mut(out));
    copy_to(mesh.positions(), positions.of_mut(out));
    copy_to(mesh.triangles(), triangles.of_mut(out));
    copy_to(bvh.order(), order.of_mut(out));
    header.write(out);
    header.seal(checksum(out));
    header.write(out);
    Ok(out)
}
