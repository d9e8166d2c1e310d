//! A closed mesh, with what has to be known of it once.

use super::cones::{self, Cones};
use crate::bvtt::TrianglePair;
use crate::{Bvh, CapacityError};

/// The rule for the interior of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rule {
    /// Points with a winding number other than 0: every edge is run along as often in the one direction as in the other, so that
    /// bodies of one mesh that overlap are united, and a mesh that is turned inside out is the same solid.
    NonZero,
    /// Points from which a ray leaves through an odd number of triangles: edges have an even number of triangles, not all
    /// oriented alike.
    Odd,
    /// No point is inside: the mesh is a surface, and may be open.
    Surface,
}

impl Rule {
    const ALL: [Self; 3] = [Self::NonZero, Self::Odd, Self::Surface];
}

/// Why a mesh is no solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotSolid {
    /// An edge has an odd number of triangles.
    #[error("edge {edge} of triangle {triangle} is open: an odd number of triangles have it")]
    OpenEdge {
        /// A triangle that has the edge.
        triangle: u32,
        /// The edge: from this corner to the next.
        edge: u32,
    },
    /// Triangles meet beyond the corners that they share: each that could bound an interior does, or a volume is asked for.
    #[error("triangles {} and {} meet beyond the corners that they share", pair.a, pair.b)]
    MeetsItself {
        /// The lowest pair; twice the same triangle if it is an edge that makes no sense without triangles of no area.
        pair: TrianglePair,
    },
    /// There is no interior: all triangles cancel each other, or there are none.
    #[error("the mesh has no volume")]
    NoVolume,
    /// There is no surface: no triangle has an area.
    #[error("no triangle of the mesh has an area")]
    NoArea,
    /// A buffer is too small.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}

/// The number of words that a [`Solid`] takes: 44 bytes a vertex and 36 a triangle.
#[must_use]
pub const fn solid_bound(vertices: usize, triangles: usize) -> usize {
    HEADER + 9 * triangles + cones::HEADER + cones::WORDS * vertices
}

/// The number of words of scratch memory that [`Solid::new`] takes.
#[must_use]
pub const fn solid_scratch_bound(vertices: usize, triangles: usize) -> usize {
    2 * vertices + 3 * triangles + triangles.div_ceil(32)
}

/// Words before the lists: how many patches there are, the rule, and the lowest pair that meets itself.
pub(super) const HEADER: usize = 4;

/// The patch of a degenerate triangle.
pub(super) const DEGENERATE: u32 = u32::MAX;

/// The bit of a patch of marked triangles.
pub(super) const MARKED: u32 = 1 << 31;

/// A closed mesh and its BVH, with the fans of its edges, its patches and their winding numbers. Copying is free.
///
/// Equal positions are one vertex, whatever their indices. Triangles of no area are passed over. Triangles that meet their own
/// mesh beyond the corners that they share are allowed; a relation that hangs on one of them is undetermined.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
/// use pfront_core::relation::{NotSolid, Solid, solid_bound, solid_scratch_bound};
/// use pfront_core::{Mesh, Node};
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let solid_of = |triangles: &[[u32; 3]]| {
///     let mesh = Mesh::new(&corners, triangles)?;
///     let (mut nodes, mut order) = ([Node::EMPTY; node_bound(4)], [0; 4]);
///     let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
///     let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 8])?;
///     let (mut words, mut scratch) = ([0; solid_bound(4, 4)], [0; solid_scratch_bound(4, 4)]);
///     Solid::new(bvh, &mut words, &mut scratch).map(|solid| solid.patches())?;
///     Ok::<_, Box<dyn std::error::Error>>(())
/// };
/// solid_of(&triangles)?;
/// let open = solid_of(&triangles[..3]).unwrap_err();
/// assert_eq!(open.downcast_ref(), Some(&NotSolid::OpenEdge { triangle: 0, edge: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Solid<'a> {
    bvh: Bvh<'a>,
    words: &'a [u32],
}

impl<'a> Solid<'a> {
    /// The solid of words that [`Solid::new`] has written about the same mesh, without checking them.
    ///
    /// # Panics and wrong answers
    /// With other words, queries may answer wrongly or panic.
    #[must_use]
    pub fn new_unchecked(bvh: Bvh<'a>, words: &'a [u32]) -> Self {
        Self { bvh, words }
    }

    /// Its BVH.
    #[must_use]
    pub fn bvh(&self) -> Bvh<'a> {
        self.bvh
    }

    /// The rule for its interior.
    #[must_use]
    pub fn rule(&self) -> Rule {
        Rule::ALL[self.words[1].min(2) as usize]
    }

    /// The number of patches.
    #[must_use]
    pub fn patches(&self) -> usize {
        self.words[0] as usize
    }

    /// The lowest pair of triangles that meet beyond the corners that they share, if there is one: on those a relation may be
    /// undetermined.
    #[must_use]
    pub fn marked_pair(&self) -> Option<TrianglePair> {
        let [a, b] = [self.words[2], self.words[3]];
        (a != u32::MAX).then_some(TrianglePair { a, b })
    }

    fn triangles(&self) -> usize {
        self.bvh.mesh().triangles().len()
    }

    /// The vertices of the triangles, those in one place once.
    pub(super) fn corners(&self) -> &'a [[u32; 3]] {
        self.words[HEADER..][..3 * self.triangles()].as_chunks().0
    }

    pub(super) fn next(&self) -> &'a [u32] {
        let n = self.triangles();
        &self.words[HEADER + 3 * n..][..3 * n]
    }

    pub(super) fn patch_of(&self, triangle: u32) -> u32 {
        self.words[HEADER + 6 * self.triangles() + triangle as usize]
    }

    /// Whether a triangle meets its own mesh beyond the corners that it shares.
    pub(super) fn is_marked(&self, triangle: u32) -> bool {
        let patch = self.patch_of(triangle);
        patch != DEGENERATE && patch & MARKED != 0
    }

    /// 1 for a triangle whose front is outside, −1 for one whose back is, and 0 for one that bounds nothing, or is marked.
    pub(super) fn facing(&self, triangle: u32) -> i32 {
        let patch = self.patch_of(triangle);
        if patch & MARKED != 0 {
            return 0;
        }
        let front = self.patch(patch).1;
        let [front, back] = [front, front + 1].map(|n| i32::from(self.rule().is_inside(n)));
        back - front
    }

    pub(super) fn cones(&self) -> Cones<'a> {
        Cones(&self.words[HEADER + 9 * self.triangles()..])
    }

    /// A triangle of a patch, and its winding number in front.
    pub(super) fn patch(&self, patch: u32) -> (u32, i32) {
        let at = HEADER + 7 * self.triangles() + 2 * patch as usize;
        (self.words[at], self.words[at + 1] as i32)
    }
}

impl Rule {
    /// Whether points with a winding number are inside.
    #[inline]
    pub(super) fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::Odd => winding & 1 != 0,
            Self::Surface => false,
        }
    }
}
