//! The relation of two solids: apart, touching, crossing, one inside the other, or equal.
//!
//! A [`Solid`] is a closed mesh with what has to be known of it once: which triangles share each edge, which of them meet their own
//! mesh elsewhere, and on which side of each is the inside. The points of space are of four classes: in both solids, only in
//! the first, only in the second, in neither. The relation follows from which of the first three occur, which are the three bits of
//! [`Seen`]. They are collected from the triangle pairs that intersect, in any order and by any number of threads, by signs of
//! orientation determinants of input points alone; no point is constructed.
//!
//! # How the classes are found
//! 1. Where two triangles cross in their interiors, all four classes occur beside each other.
//! 2. Where an edge lies in the plane of a triangle of the other mesh and runs through it, or along an edge of it, the half-planes of
//!    the triangles around the line are sorted by angle. Walking round the line, the winding numbers of both meshes change at each;
//!    those of the start are known (`picture`).
//! 3. Isolated points in common decide nothing.
//! 4. A patch, triangles joined over edges, that meets the other mesh along no line is on one side of all of it but for isolated
//!    points: a ray from a point of it tells which (`ray`).
//!
//! An edge of more than two triangles needs no special care, nor do coplanar triangles: all of what they show is seen at the lines
//! around them. Triangles that meet their own mesh beyond the corners that they share are marked; what hangs on such a
//! triangle where it meets the other mesh is undetermined, unless the rest decides.
//!
//! The interior of a mesh is that of the points with a winding number other than 0, or, of a mesh whose triangles are not
//! oriented alike, with an odd one: see [`Rule`].
//!
//! A mesh may also be a surface, open or not, without an interior ([`Solid::surface`]). Then the points that are looked at are its own:
//! those inside the other solid count as in both, those outside as only in the first; and those on its boundary as neither. A surface
//! is apart from a solid, touches it, crosses it, or is inside. Nothing hangs on a surface that meets itself,
//! since nothing is asked of its sides. Two surfaces cross if two of their triangles do in their interiors; what they are where
//! they meet along edges alone is undetermined.

mod ball;
mod build;
mod cones;
mod fans;
mod inside;
mod picture;
mod query;
mod ray;
mod seen;
mod solid;
#[cfg(test)]
mod tests;
mod trees;
mod volume;

pub use inside::Location;
pub use query::RelationQuery;
pub use seen::{Seen, seen_bound};
pub use solid::{NotSolid, Rule, Solid, solid_bound, solid_scratch_bound};
pub use volume::Overlap;

use crate::bvtt::TrianglePair;
use core::fmt;

/// The relation of a solid A to a solid B, by their interiors and their surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Relation {
    /// No point in common.
    Apart,
    /// Apart, and at most the clearance away that was asked for.
    Near,
    /// The surfaces meet, the interiors do not.
    Touching,
    /// The interiors meet, and each solid is partly outside of the other.
    Crossing,
    /// A is inside B, and not all of B is in A. Their surfaces may meet.
    AInB,
    /// B is inside A, and not all of A is in B.
    BInA,
    /// The same solid, whatever its triangles.
    Equal,
}

impl Relation {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Apart,
        Self::Near,
        Self::Touching,
        Self::Crossing,
        Self::AInB,
        Self::BInA,
        Self::Equal,
    ];

    /// The relation of a word, that of [`Relation::as_str`].
    ///
    /// # Examples
    /// ```
    /// use pfront_core::relation::Relation;
    /// assert_eq!(Relation::from_word("a_in_b"), Some(Relation::AInB));
    /// assert_eq!(Relation::from_word("beside"), None);
    /// ```
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|relation| relation.as_str() == word)
    }

    /// The relation of B to A.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::relation::Relation;
    /// assert_eq!(Relation::AInB.swapped(), Relation::BInA);
    /// assert_eq!(Relation::Crossing.swapped(), Relation::Crossing);
    /// ```
    #[must_use]
    pub fn swapped(self) -> Self {
        match self {
            Self::AInB => Self::BInA,
            Self::BInA => Self::AInB,
            other => other,
        }
    }

    /// The word in files and in other languages: `apart`, `near`, `touching`, `crossing`, `a_in_b`, `b_in_a` or `equal`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Apart => "apart",
            Self::Near => "near",
            Self::Touching => "touching",
            Self::Crossing => "crossing",
            Self::AInB => "a_in_b",
            Self::BInA => "b_in_a",
            Self::Equal => "equal",
        }
    }
}

impl fmt::Display for Relation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The answer about two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Between {
    /// The relation; `None` if it is undetermined, since it hangs on triangles that meet their own mesh, on an edge along which more
    /// than 32 triangles of both meet, or on edges along which two surfaces meet.
    pub relation: Option<Relation>,
    /// Whether the surfaces meet, as those of nested solids may.
    pub meets: bool,
    /// A triangle pair that shows it: one that crosses, or touches; or the one on which what is undetermined hangs. It
    /// may differ between executors.
    pub pair: Option<TrianglePair>,
    /// Whether it is undetermined only since the pose has rounded positions of B: a [`Solid`] of the posed mesh has an answer.
    pub is_rounded: bool,
}
