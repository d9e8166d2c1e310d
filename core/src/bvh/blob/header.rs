//! The header, where sections lie, and the checksum.

use super::BlobError;
use crate::{Bvh, Node};
use bytemuck::{Pod, Zeroable};

/// What a blob begins with. The first byte is no text, and line ends that a transfer has changed show.
pub const MAGIC: [u8; 8] = *b"\x89PFB\r\n\x1a\n";

/// The version that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// The sections by name, and the kind of each.
const KINDS: [(&str, u16); 4] = [("nodes", 1), ("positions", 1), ("triangles", 1), ("order", 1)];

/// A section begins at a multiple of so many bytes.
const SECTION_ALIGN: usize = 16;

const CHECKSUM: core::ops::Range<usize> = 12..16;

/// As the table of the module has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Header {
    magic: [u8; 8],
    version: [u8; 4],
    checksum: [u8; 4],
    length: [u8; 8],
    kinds: [[u8; 2]; 4],
    nodes: [u8; 4],
    vertices: [u8; 4],
    triangles: [u8; 4],
    zero: [u8; 20],
}

/// How much of everything a blob holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Nodes in use, with the unused slot 1: at most [`node_bound`](crate::bvh::node_bound).
    pub nodes: usize,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
}

/// Where each section lies.
pub(super) struct Sections {
    pub(super) nodes: Section,
    pub(super) positions: Section,
    pub(super) triangles: Section,
    pub(super) order: Section,
}

#[derive(Clone, Copy)]
pub(super) struct Section {
    start: usize,
    end: usize,
}

impl Header {
    pub(super) fn new(counts: Counts) -> Result<Self, BlobError> {
        let word = |what, count| match u32::try_from(count) {
            Ok(word) => Ok(word.to_le_bytes()),
            Err(_) => Err(BlobError::TooMany { what, count }),
        };
        Ok(Self {
            magic: MAGIC,
            version: VERSION.to_le_bytes(),
            checksum: [0; 4],
            length: (counts.bytes() as u64).to_le_bytes(),
            kinds: KINDS.map(|(_, kind)| kind.to_le_bytes()),
            nodes: word("nodes", counts.nodes)?,
            vertices: word("vertices", counts.vertices)?,
            triangles: word("triangles", counts.triangles)?,
            zero: [0; 20],
        })
    }

    /// The header of bytes of a version and of kinds that are known.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, BlobError> {
        if !bytes.iter().zip(&MAGIC).all(|(found, expected)| found == expected) {
            return Err(BlobError::Magic);
        }
        let found = bytes.len();
        let short = BlobError::Length { needed: size_of::<Self>() as u64, found };
        let header: Self = bytemuck::must_cast(*bytes.first_chunk::<64>().ok_or(short)?);
        let found = u32::from_le_bytes(header.version);
        if found != VERSION {
            return Err(BlobError::Version { found });
        }
        for ((section, kind), found) in KINDS.into_iter().zip(header.kinds) {
            let found = u16::from_le_bytes(found);
            if found != kind {
                return Err(BlobError::Kind { section, found });
            }
        }
        if header.zero != [0; 20] {
            return Err(BlobError::NotZero { byte: size_of::<Self>() - header.zero.len() });
        }
        Ok(header)
    }

    pub(super) fn length(&self) -> u64 {
        u64::from_le_bytes(self.length)
    }

    pub(super) fn counts(&self) -> Counts {
        let [nodes, vertices, triangles] =
            [self.nodes, self.vertices, self.triangles].map(|n| u32::from_le_bytes(n) as usize);
        Counts { nodes, vertices, triangles }
    }

    pub(super) fn checksum(&self) -> u32 {
        u32::from_le_bytes(self.checksum)
    }

    pub(super) fn seal(&mut self, checksum: u32) {
        self.checksum = checksum.to_le_bytes();
    }

    pub(super) fn write(&self, out: &mut [u8]) {
        if let Some(start) = out.first_chunk_mut::<64>() {
            *start = bytemuck::must_cast(*self);
        }
    }
}

impl Counts {
    /// Of a BVH and its mesh.
    #[must_use]
    pub fn of(bvh: &Bvh<'_>) -> Self {
        let mesh = bvh.mesh();
        Self {
            nodes: bvh.nodes().len(),
            vertices: mesh.positions().len(),
            triangles: mesh.triangles().len(),
        }
    }

    /// How many bytes a blob of these takes, exactly; [`usize::MAX`] or close to it if there is no such number.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{blob::Counts, bvh::node_bound};
    /// let most = Counts { nodes: node_bound(1000), vertices: 500, triangles: 1000 };
    /// assert_eq!(most.bytes(), 64 + 64_000 + 6_000 + 12_000 + 4_000);
    /// ```
    #[must_use]
    pub const fn bytes(self) -> usize {
        self.sections().order.end
    }

    pub(super) const fn sections(self) -> Sections {
        let header = Section { start: 0, end: size_of::<Header>() };
        let nodes = header.then(self.nodes, size_of::<Node>());
        let positions = nodes.then(self.vertices, size_of::<[f32; 3]>());
        let triangles = positions.then(self.triangles, size_of::<[u32; 3]>());
        let order = triangles.then(self.triangles, size_of::<u32>());
        Sections { nodes, positions, triangles, order }
    }
}

impl Section {
    /// The section behind. Where a count is a lie, its end is beyond every slice, whatever the width of usize.
    const fn then(self, count: usize, size: usize) -> Self {
        let start = self.end.saturating_add(SECTION_ALIGN - 1) / SECTION_ALIGN * SECTION_ALIGN;
        Self { start, end: start.saturating_add(count.saturating_mul(size)) }
    }

    pub(super) fn of(self, bytes: &[u8]) -> &[u8] {
        bytes.get(self.start..self.end).unwrap_or_default()
    }

    pub(super) fn of_mut(self, bytes: &mut [u8]) -> &mut [u8] {
        bytes.get_mut(self.start..self.end).unwrap_or_default()
    }
}

impl Sections {
    /// Whether what lies between sections is 0.
    pub(super) fn check_gaps(&self, bytes: &[u8]) -> Result<(), BlobError> {
        let Self { nodes, positions, triangles, order } = *self;
        for (before, after) in [(nodes, positions), (positions, triangles), (triangles, order)] {
            let gap = Section { start: before.end, end: after.start };
            if let Some(at) = gap.of(bytes).iter().position(|&byte| byte != 0) {
                return Err(BlobError::NotZero { byte: gap.start + at });
            }
        }
        Ok(())
    }
}

/// Of everything but the checksum. A table of 16 KiB is four times as fast as one of 1 KiB, which is what
/// firmware gets.
pub(super) fn checksum(bytes: &[u8]) -> u32 {
    #[cfg(feature = "std")]
    type Table = crc::Table<16>;
    #[cfg(not(feature = "std"))]
    type Table = crc::Table<1>;
    static CRC: crc::Crc<u32, Table> = crc::Crc::<u32, Table>::new(&crc::CRC_32_ISO_HDLC);

    let mut digest = CRC.digest();
    digest.update(bytes.get(..CHECKSUM.start).unwrap_or_default());
    digest.update(bytes.get(CHECKSUM.end..).unwrap_or_default());
    digest.finalize()
}
