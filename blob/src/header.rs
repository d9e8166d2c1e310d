//! The header, the place of each section, and the checksum.

use super::BlobError;
use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use pfront_core::{Bvh, Node};

/// The first bytes of a blob. The first is not text, and a transfer that changes line ends changes the others.
pub const MAGIC: [u8; 8] = *b"\x89PFB\r\n\x1a\n";

/// The version that is written, and the only one that is read.
pub(super) const VERSION: u32 = 1;

/// A section begins at a multiple of so many bytes.
const SECTION_ALIGN: usize = 16;

const CHECKSUM: Range<usize> = 12..16;

/// The header, as the table of the module lists it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Header {
    magic: [u8; 8],
    version: [u8; 4],
    checksum: [u8; 4],
    length: [u8; 8],
    kinds: [[u8; 2]; 4],
    counts: [[u8; 4]; 3],
    zero: [u8; 20],
}

/// The kind of every section of a mesh in f32.
const ORDINARY: u16 = 1;

/// The kind of positions that are also those of a mesh in f64.
const WIDENED: u16 = 2;

/// The kind of positions that are the shadow of others in f64, in a section of their own.
const SHADOW: u16 = 3;

impl Header {
    /// The header of a blob, with a checksum of 0. A BVH has no more nodes and triangles than fit in 32 bits.
    pub(super) fn new(counts: Counts, is_f64: bool) -> Self {
        let positions = match (is_f64, counts.positions_f64) {
            (false, _) => ORDINARY,
            (true, 0) => WIDENED,
            (true, _) => SHADOW,
        };
        Self {
            magic: MAGIC,
            version: VERSION.to_le_bytes(),
            checksum: [0; 4],
            length: (counts.bytes() as u64).to_le_bytes(),
            kinds: [ORDINARY, positions, ORDINARY, ORDINARY].map(u16::to_le_bytes),
            counts: [counts.nodes, counts.vertices, counts.triangles]
                .map(|count| (count as u32).to_le_bytes()),
            zero: [0; 20],
        }
    }

    /// Reads the header; checks all of it but the checksum, and the length of `bytes`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, BlobError> {
        if !bytes.iter().zip(&MAGIC).all(|(found, expected)| found == expected) {
            return Err(BlobError::Magic);
        }
        let found = bytes.len();
        let Some(header) = bytes.first_chunk::<{ size_of::<Self>() }>() else {
            return Err(BlobError::Length { needed: size_of::<Self>() as u64, found });
        };
        let header: Self = bytemuck::must_cast(*header);
        let (version, needed) =
            (u32::from_le_bytes(header.version), u64::from_le_bytes(header.length));
        if version != VERSION {
            return Err(BlobError::Version { found: version, known: VERSION });
        }
        for needed in [needed, header.counts().bytes() as u64] {
            if needed != found as u64 {
                return Err(BlobError::Length { needed, found });
            }
        }
        // The counts and the kind of the positions determine all other bytes.
        let expected =
            Self { checksum: header.checksum, ..Self::new(header.counts(), header.is_f64()) };
        let mut bytes = bytemuck::bytes_of(&header).iter().zip(bytemuck::bytes_of(&expected));
        match bytes.position(|(found, expected)| found != expected) {
            Some(byte) => Err(BlobError::Byte { byte }),
            None => Ok(header),
        }
    }

    /// Writes the header before the sections of a blob, with the checksum of all.
    pub(super) fn write(mut self, out: &mut [u8]) {
        out[..size_of::<Self>()].copy_from_slice(bytemuck::bytes_of(&self));
        self.checksum = checksum(out).to_le_bytes();
        out[CHECKSUM].copy_from_slice(&self.checksum);
    }

    pub(super) fn counts(&self) -> Counts {
        let [nodes, vertices, triangles] = self.counts.map(|n| u32::from_le_bytes(n) as usize);
        let positions_f64 = if self.kind_of_positions() == SHADOW { vertices } else { 0 };
        Counts { nodes, vertices, triangles, positions_f64 }
    }

    pub(super) fn is_f64(&self) -> bool {
        matches!(self.kind_of_positions(), WIDENED | SHADOW)
    }

    fn kind_of_positions(&self) -> u16 {
        let [_, kind, ..] = self.kinds;
        u16::from_le_bytes(kind)
    }

    pub(super) fn checksum(&self) -> u32 {
        u32::from_le_bytes(self.checksum)
    }
}

/// How many nodes, vertices and triangles a blob holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Nodes in use, with the unused slot 1: at most [`node_bound`](pfront_core::bvh::node_bound).
    pub nodes: usize,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Positions in f64 beside: one for each vertex, or none if f32 holds them all.
    pub positions_f64: usize,
}

impl Counts {
    /// Counts a BVH and its mesh.
    #[must_use]
    pub fn of(bvh: &Bvh<'_>) -> Self {
        let mesh = bvh.mesh();
        Self {
            nodes: bvh.nodes().len(),
            vertices: mesh.vertex_count(),
            triangles: mesh.triangles().len(),
            positions_f64: mesh.positions_f64().map_or(0, <[_]>::len),
        }
    }

    /// The exact size of the blob in bytes; [`usize::MAX`] or close to it if that does not fit.
    ///
    /// # Examples
    /// ```
    /// use pfront_blob::Counts;
    /// use pfront_core::bvh::node_bound;
    /// let most = Counts { nodes: node_bound(1000), vertices: 500, triangles: 1000, positions_f64: 0 };
    /// assert_eq!(most.bytes(), 64 + 64_000 + 6_000 + 12_000 + 4_000);
    /// assert_eq!(Counts { positions_f64: 500, ..most }.bytes(), most.bytes() + 24 * 501);
    /// ```
    #[must_use]
    pub const fn bytes(self) -> usize {
        let [.., last] = self.sections();
        last.end
    }

    /// The bytes of the nodes, the positions, the triangles and the order, and of the origin and the positions in f64.
    pub(super) const fn sections(self) -> [Range<usize>; 5] {
        let nodes = section(size_of::<Header>(), self.nodes, size_of::<Node>());
        let positions = section(nodes.end, self.vertices, size_of::<[f32; 3]>());
        let triangles = section(positions.end, self.triangles, size_of::<[u32; 3]>());
        let order = section(triangles.end, self.triangles, size_of::<u32>());
        let in_f64 = match self.positions_f64 {
            0 => order.end..order.end,
            count => section(order.end, count.saturating_add(1), size_of::<[f64; 3]>()),
        };
        [nodes, positions, triangles, order, in_f64]
    }
}

/// The section of `count` elements behind the byte `end`. A false count gives it an end beyond every slice, whatever
/// the width of usize.
const fn section(end: usize, count: usize, size: usize) -> Range<usize> {
    let start = end.saturating_add(SECTION_ALIGN - 1) / SECTION_ALIGN * SECTION_ALIGN;
    start..start.saturating_add(count.saturating_mul(size))
}

/// The checksum of all bytes but its own four.
///
/// A table of 16 KiB is four times as fast as one of 1 KiB, and more than the flash of a small machine has to spare.
pub(super) fn checksum(bytes: &[u8]) -> u32 {
    #[cfg(target_pointer_width = "64")]
    type Table = crc::Table<16>;
    #[cfg(not(target_pointer_width = "64"))]
    type Table = crc::Table<1>;
    static CRC: crc::Crc<u32, Table> = crc::Crc::<u32, Table>::new(&crc::CRC_32_ISO_HDLC);

    let mut digest = CRC.digest();
    digest.update(&bytes[..CHECKSUM.start]);
    digest.update(&bytes[CHECKSUM.end..]);
    digest.finalize()
}
