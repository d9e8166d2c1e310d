#![no_std]
//! Blobs: a mesh and its BVH as bytes, written once, kept in flash or in a file, and borrowed from there.
//!
//! A blob is a header of 64 bytes and four or five sections, in this order. Everything is little-endian, and the same
//! on every machine; f32 is IEEE 754 binary32, and f64 binary64, bit by bit.
//!
//! | offset | type | meaning |
//! |---:|---|---|
//! | 0 | `[u8; 8]` | [`MAGIC`] |
//! | 8 | `u32` | version, 1 |
//! | 12 | `u32` | checksum of every byte but these four: CRC-32/ISO-HDLC, the one of zlib |
//! | 16 | `u64` | bytes of the whole blob |
//! | 24 | `[u16; 4]` | kinds of the next four sections: 1, but for positions of meshes in f64 |
//! | 32 | `u32` | n, the number of nodes |
//! | 36 | `u32` | v, the number of vertices |
//! | 40 | `u32` | t, the number of triangles |
//! | 44 | `[u8; 20]` | 0 |
//! | 64 | `[Node; n]` | nodes of kind 1: [`Node`], 32 bytes each |
//! | then | `[[f32; 3]; v]` | positions: of a mesh in f32 (kind 1), of one in f64 (2), the shadow of one in f64 (3) |
//! | then | `[[u32; 3]; t]` | triangles of kind 1 |
//! | then | `[u32; t]` | order of kind 1 |
//! | then | `[[f64; 3]; 1 + v]` | with positions of kind 3: the origin of the shadow, and the positions in f64 |
//!
//! A section begins at the next multiple of 16 bytes; what lies between is 0. So there is one blob of a BVH:
//! reading it and writing it again gives the same bytes.
//!
//! # Checks
//! [`Blob::new`] refuses blobs of other versions and of another length than their header says, [`Blob::bvh`] and
//! [`Blob::read_into`] those changed by accident: the checksum finds every change of one or two bits and of any 32 bits
//! in a row, and misses one in 2³² of all others. It is not a signature, so they check every coordinate, index, box and
//! child, as [`Mesh::new`] and [`Bvh::new`] do.
//!
//! # Alignment
//! To be borrowed, the bytes must begin at a multiple of 4; at one of 64 siblings share a cache line.
//! `include_bytes!` promises neither, [`Aligned`] both. [`Blob::read_into`] copies from anywhere, and so does
//! [`Blob::read_into_f64`] meshes in f64, which are not borrowed.
//!
//! # Endianness
//! A big-endian machine writes and checks the same blobs, but cannot borrow them: [`Blob::bvh`] says so, and
//! [`Blob::read_into`] copies.
//!
//! # Versions
//! The version changes when old readers would misread a blob; they refuse kinds that they do not know. The first 12 bytes stay as they are in every version.
//!
//! # Features
//! `f64`, on by default, as in `pfront-core`: without it a blob of a mesh in f64 is refused.
//!
//! # Examples
//! ```
//! use pfront_blob::{Aligned, Blob, Counts};
//! use pfront_core::{Bvh, Mesh, Node};
//! // On the machine that bakes:
//! let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
//! let nodes = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
//! let bvh = Bvh::new(mesh, &nodes, &[0], &mut [0])?;
//! const BYTES: usize = Counts { nodes: 1, vertices: 3, triangles: 1, positions_f64: 0 }.bytes();
//! let mut baked = Aligned([0; BYTES]);
//! pfront_blob::write(&bvh, &mut baked.0)?;
//!
//! // On the one that borrows:
//! let blob = Blob::new(&baked.0)?;
//! # if cfg!(target_endian = "big") { return Ok(()) }
//! let borrowed = blob.bvh(&mut [0; 1])?;
//! assert_eq!(borrowed.mesh().shadow_triangle(0), mesh.shadow_triangle(0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bytes;
mod error;
mod header;
#[cfg(test)]
mod tests;

pub use error::BlobError;
pub use header::{Counts, MAGIC};

use bytes::{borrow, copy_from, copy_to};
use header::{Header, checksum};
use pfront_core::{Bvh, BvhError, CapacityError, Mesh, Node};

/// A value that begins at a multiple of 64 bytes, for a [`Blob`] to be borrowed.
///
/// # Examples
/// ```
/// use pfront_blob::Aligned;
/// # macro_rules! include_bytes { ($file:literal) => { b"64 bytes and more" } }
/// static GEAR: &Aligned<[u8]> = &Aligned(*include_bytes!("gear.pfb"));
/// assert!(GEAR.0.as_ptr().addr().is_multiple_of(64));
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Aligned<T: ?Sized>(
    /// The value.
    pub T,
);

/// Bytes whose header has been checked.
#[derive(Clone, Copy, Debug)]
pub struct Blob<'a> {
    bytes: &'a [u8],
    header: Header,
}

/// Buffers for [`Blob::read_into`]: at least as many elements of each as [`Blob::counts`] says.
#[derive(Debug)]
pub struct BlobStorage<'s> {
    /// For the nodes.
    pub nodes: &'s mut [Node],
    /// For the positions of the vertices.
    pub positions: &'s mut [[f32; 3]],
    /// For the vertex indices of the triangles.
    pub triangles: &'s mut [[u32; 3]],
    /// For the order: one entry per triangle.
    pub order: &'s mut [u32],
}

impl<'a> Blob<'a> {
    /// Checks the header and the length of `bytes`, a whole blob.
    ///
    /// # Errors
    /// [`BlobError`] says what is at fault.
    ///
    /// # Complexity
    /// O(1).
    ///
    /// # Examples
    /// ```
    /// use pfront_blob::{Blob, BlobError};
    /// assert_eq!(Blob::new(b"solid teapot").err(), Some(BlobError::Magic));
    /// ```
    pub fn new(bytes: &'a [u8]) -> Result<Self, BlobError> {
        Ok(Self { bytes, header: Header::parse(bytes)? })
    }

    /// How many nodes, vertices and triangles there are.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.header.counts()
    }

    /// Whether the mesh is in f64: see [`Mesh::from_f64`].
    #[must_use]
    pub fn is_f64(&self) -> bool {
        self.header.is_f64()
    }

    /// Borrows the mesh and the BVH, after checking the checksum and all that queries rely on.
    ///
    /// `scratch` is as for [`Bvh::new`]: a bit for each triangle, or fewer and more time.
    ///
    /// # Errors
    /// [`BlobError`] says what is at fault; [`BlobError::Misaligned`] and [`BlobError::BigEndian`] are about where the
    /// bytes lie, not what they are. [`BlobError::InF64`] if the mesh is in f64, which
    /// [`Blob::read_into_f64`] copies.
    ///
    /// # Complexity
    /// O(bytes), beside what [`Bvh::new`] and [`Mesh::new`] take.
    pub fn bvh(&self, scratch: &mut [u32]) -> Result<Bvh<'a>, BlobError> {
        self.check_f32()?;
        let [nodes, positions, triangles, order, _] = self.sections()?;
        let mesh = Mesh::new(borrow(positions)?, borrow(triangles)?)?;
        Ok(Bvh::new(mesh, borrow(nodes)?, borrow(order)?, scratch)?)
    }

    /// Copies the mesh and the BVH, which works on every machine and wherever the bytes lie, and checks the
    /// copy as [`Blob::bvh`] does.
    ///
    /// # Errors
    /// [`BlobError::Capacity`] if `storage` is too small, or another [`BlobError`] that says what is at fault;
    /// [`BlobError::InF64`] if the mesh is in f64, which [`Blob::read_into_f64`] copies.
    ///
    /// # Complexity
    /// As [`Blob::bvh`].
    pub fn read_into<'s>(
        &self,
        storage: BlobStorage<'s>,
        scratch: &mut [u32],
    ) -> Result<Bvh<'s>, BlobError> {
        self.check_f32()?;
        let (mesh, nodes, order) = copy_into(storage, self.sections()?)?;
        Ok(Bvh::new(Mesh::new(mesh.shadow(), mesh.triangles())?, nodes, order, scratch)?)
    }

    /// [`Blob::read_into`] for meshes of either kind; `positions` must hold [`Counts::positions_f64`].
    ///
    /// # Errors
    /// As [`Blob::read_into`].
    ///
    /// # Complexity
    /// As [`Blob::bvh`].
    ///
    /// # Examples
    /// ```
    /// use pfront_blob::{Blob, BlobStorage};
    /// use pfront_core::{Bvh, Mesh, Node};
    /// let (points, mut shadow) = ([[0.1, 0.2, 0.3]; 3], [[0.0; 3]; 3]);
    /// let mesh = Mesh::from_f64(&points, &[[0, 1, 2]], &mut shadow)?;
    /// let nodes = [Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 1 }];
    /// let bvh = Bvh::new(mesh, &nodes, &[0], &mut [0])?;
    /// let mut baked = [0; 512];
    /// let blob = Blob::new(pfront_blob::write(&bvh, &mut baked)?)?;
    ///
    /// let mut positions_f64 = [[0.0; 3]; 3];
    /// let storage = BlobStorage {
    ///     nodes: &mut [Node::EMPTY; 1],
    ///     positions: &mut [[0.0; 3]; 3],
    ///     triangles: &mut [[0; 3]; 1],
    ///     order: &mut [0; 1],
    /// };
    /// let copied = blob.read_into_f64(storage, &mut positions_f64, &mut [0; 1])?;
    /// assert_eq!(copied.mesh().positions_f64(), Some(&points[..]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "f64")]
    pub fn read_into_f64<'s>(
        &self,
        storage: BlobStorage<'s>,
        positions: &'s mut [[f64; 3]],
        scratch: &mut [u32],
    ) -> Result<Bvh<'s>, BlobError> {
        if !self.is_f64() {
            return self.read_into(storage, scratch);
        }
        let sections = self.sections()?;
        let [.., in_f64] = sections;
        // Empty if the shadow has the positions.
        let (first, rest) = in_f64.split_at_checked(size_of::<[f64; 3]>()).unwrap_or_default();
        let mut origin = [[0.0; 3]];
        copy_from::<8, _>(first, "origin", &mut origin)?;
        let positions = copy_from::<8, _>(rest, "positions_f64", positions)?;
        let (mesh, nodes, order) = copy_into(storage, sections)?;
        let mesh = Mesh::from_f64_parts(positions, mesh.shadow(), origin[0], mesh.triangles())?;
        Ok(Bvh::new(mesh, nodes, order, scratch)?)
    }

    fn check_f32(&self) -> Result<(), BlobError> {
        if self.is_f64() { Err(BlobError::InF64) } else { Ok(()) }
    }

    /// The bytes of each section, after checking the checksum and what lies between.
    fn sections(&self) -> Result<[&'a [u8]; 5], BlobError> {
        let (stored, computed) = (self.header.checksum(), checksum(self.bytes));
        if stored != computed {
            return Err(BlobError::Checksum { stored, computed });
        }
        let mut end = size_of::<Header>();
        for section in self.counts().sections() {
            let mut between = self.bytes[end..section.start].iter();
            if let Some(index) = between.position(|&byte| byte != 0) {
                return Err(BlobError::Byte { byte: end + index });
            }
            end = section.end;
        }
        Ok(self.counts().sections().map(|section| &self.bytes[section]))
    }
}

/// Copies all but positions in f64; nothing in it has been checked.
fn copy_into<'s>(
    storage: BlobStorage<'s>,
    [nodes, positions, triangles, order, _]: [&[u8]; 5],
) -> Result<(Mesh<'s>, &'s [Node], &'s [u32]), CapacityError> {
    let positions = copy_from::<4, _>(positions, "positions", storage.positions)?;
    let triangles = copy_from::<4, _>(triangles, "triangles", storage.triangles)?;
    let nodes = copy_from::<4, _>(nodes, "nodes", storage.nodes)?;
    let order = copy_from::<4, _>(order, "order", storage.order)?;
    Ok((Mesh::new_unchecked(positions, triangles), nodes, order))
}

/// Writes a mesh and its BVH as a blob of [`Counts::bytes`] at the beginning of `out`, and returns these bytes.
///
/// # Errors
/// [`BvhError::Capacity`] if `out` is too small, [`BvhError::TooMany`] if there are 2³² vertices or more,
/// [`BvhError::Length`] if the order does not have one entry per triangle.
///
/// # Complexity
/// O(bytes).
pub fn write<'o>(bvh: &Bvh<'_>, out: &'o mut [u8]) -> Result<&'o [u8], BvhError> {
    let (mesh, counts) = (bvh.mesh(), Counts::of(bvh));
    let (found, expected) = (bvh.order().len(), counts.triangles);
    if found != expected {
        return Err(BvhError::Length { array: "order", expected, found });
    }
    let (found, most) = (counts.vertices, u32::MAX as usize);
    if found > most {
        return Err(BvhError::TooMany { array: "positions", most, found });
    }
    CapacityError::check("out", counts.bytes(), out.len())?;
    let out = &mut out[..counts.bytes()];
    out.fill(0);
    let [nodes, positions, triangles, order, in_f64] = counts.sections();
    if let Some(points) = mesh.positions_f64() {
        let (origin, rest) = out[in_f64].split_at_mut(size_of::<[f64; 3]>());
        copy_to::<8, _>(&[mesh.origin()], origin);
        copy_to::<8, _>(points, rest);
    }
    copy_to::<4, _>(bvh.nodes(), &mut out[nodes]);
    copy_to::<4, _>(mesh.shadow(), &mut out[positions]);
    copy_to::<4, _>(mesh.triangles(), &mut out[triangles]);
    copy_to::<4, _>(bvh.order(), &mut out[order]);
    Header::new(counts, mesh.is_f64()).write(out);
    Ok(out)
}
