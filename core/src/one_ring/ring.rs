//! The word that is kept of a one-ring.

use crate::bvh::MAX_LEAF_SIZE;
use bytemuck::{Pod, Zeroable};

/// The triangles around one vertex: how they are connected, and whether they are certified.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct OneRing(pub(super) u32);

/// The triangles around the vertex form a closed ring.
pub(super) const RING: u32 = 1 << 31;
/// They form a row that begins and ends at the boundary.
pub(super) const ROW: u32 = 1 << 30;
/// How many triangles there are, to a power of two; 0 if they are fewer than [`LARGE`].
pub(super) const SIZE: u32 = 0x1f << 25;
/// No two of the triangles intersect in more than what they share by index.
pub(super) const CERTIFIED: u32 = 1;

/// The fewest triangles of a large one-ring: eight full leaves, whose pairs are about as many as those of eight leaves of any
/// surface with their neighbours.
const LARGE: usize = 8 * MAX_LEAF_SIZE as usize;

impl OneRing {
    /// The bits of the size of a one-ring, which are there if it is large: to a power of two.
    pub(super) fn size(triangles: usize) -> u32 {
        if triangles < LARGE { 0 } else { triangles.ilog2() << SIZE.trailing_zeros() }
    }

    #[inline]
    pub(crate) fn is_certified(self) -> bool {
        self.0 & CERTIFIED != 0
    }

    /// Whether the triangles form one ring or one row.
    pub(super) fn is_connected(self) -> bool {
        self.0 & (RING | ROW) != 0
    }

    /// Forgets all but how the triangles are connected.
    pub(super) fn clear(&mut self) {
        self.0 &= RING | ROW | SIZE;
    }

    /// Whether there are so many triangles that [`Certified::with_fans`](super::Certified::with_fans) saves time.
    pub(super) fn is_large(self) -> bool {
        self.0 & SIZE != 0
    }
}
