//! One-ring certificates: vertices whose incident triangles provably do not intersect each other.
//!
//! The one-ring of a vertex is the set of triangles around it. Nearly all triangle pairs of a deforming mesh whose
//! boxes overlap share a vertex, and nearly all of these touch only where they are joined. One certificate per
//! vertex decides all pairs of the triangles around it.
//!
//! Volino and Magnenat-Thalmann (Efficient Self-Collision Detection on Smoothly Discretized Surface Animations using
//! Geometrical Shape Regularity, Computer Graphics Forum 13(3), 1994) proved that a patch of a surface does not
//! intersect itself if some direction makes an acute angle with all its normals, and the projection of its boundary
//! along that direction does not intersect itself. For a one-ring this reads:
//!
//! **Theorem.** Let the triangles around a vertex follow each other from shared edge to shared edge, in a closed ring
//! or in a row. If the normals of all of them have the same sign along one coordinate axis, and the projection along
//! that axis goes round the vertex once (a ring) or less than once (a row), then two of them have no point in common
//! but the vertex, or the edge, that they share by index.
//!
//! **Proof.** A normal of that sign means that the projection keeps the triangle's orientation, so each triangle
//! projects to a triangle in a sector of less than half a turn about the vertex, and each sector begins where the one
//! before ends. In all they turn by no more than a full turn, so the sectors lie side by side: two of them share a ray
//! if their triangles share an edge, and otherwise only the vertex. Points in common in space have projections in
//! common.
//!
//! Neighbours around a certified vertex are therefore no hits under any rule of
//! [`Adjacency`](crate::triangle::Adjacency). Other vertices (sharp folds, several rings) are
//! not certified, and their pairs are tested as all others are. Both conditions are decided exactly, by certified signs and
//! by comparisons.

mod certified;
mod certify;
mod fan;
mod link;
mod ring;
#[cfg(test)]
mod tests;

pub use certified::Certified;
pub use fan::fan_bound;
pub use link::{link_scratch_bound, links_bound};

pub(crate) use fan::{hub_of, is_marked};
pub(crate) use ring::OneRing;

use crate::CapacityError;
use crate::parallel::split;
use bytemuck::must_cast_slice_mut;

/// The one-rings of a mesh: how the triangles around each vertex are connected, which its positions do not change.
///
/// It borrows the triangles and a `history` of the caller's, and lasts from frame to frame; the positions may change
/// meanwhile, and [`OneRings::certify`] says what holds for the present ones.
///
/// # Examples
/// ```
/// use pfront_core::Mesh;
/// use pfront_core::one_ring::{OneRings, history_bound, link_scratch_bound};
/// let (mut positions, triangles) = ([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
/// let (mut history, mut scratch) = ([0; history_bound(3)], [0; link_scratch_bound(3, 1)]);
/// let mut rings = OneRings::new(3, &triangles, &mut history, &mut scratch)?;
/// for height in [1.0, 0.0] {
///     positions[2][1] = height;
///     let mesh = Mesh::new(&positions, &triangles)?;
///     let certified = rings.certify(mesh, None);
///     assert_eq!(certified.is_certified(0), height > 0.0, "a triangle without area proves nothing");
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OneRings<'a> {
    triangles: &'a [[u32; 3]],
    rings: &'a mut [OneRing],
    /// See [`OneRings::with_links`]; empty without.
    links: &'a mut [u32],
}

/// Returns the number of words in the history of the one-rings of a mesh: one a vertex.
#[must_use]
pub const fn history_bound(vertices: usize) -> usize {
    vertices
}

impl<'a> OneRings<'a> {
    /// Finds the vertices whose triangles form one ring or one row. None of them is certified yet, and none ever is
    /// in a mesh of more than 2^32 / 3 triangles.
    ///
    /// `triangles` are those of a [`Mesh`](crate::Mesh) of so many vertices; `scratch` is not used afterwards, but for
    /// [`OneRings::with_links`].
    ///
    /// # Errors
    /// [`CapacityError`] if `history` has fewer words than [`history_bound`], or `scratch` fewer than
    /// [`link_scratch_bound`].
    ///
    /// # Complexity
    /// O(vertices + triangles).
    pub fn new(
        vertices: usize,
        triangles: &'a [[u32; 3]],
        history: &'a mut [u32],
        scratch: &mut [u32],
    ) -> Result<Self, CapacityError> {
        let needed = history_bound(vertices);
        CapacityError::check("history", needed, history.len())?;
        let needed = link_scratch_bound(vertices, triangles.len());
        CapacityError::check("scratch", needed, scratch.len())?;
        let mut new = Self::new_unchecked(vertices, triangles, history);
        new.link(scratch);
        Ok(new)
    }

    /// Borrows again the history that [`OneRings::new`] filled for the same vertices and triangles.
    ///
    /// Nothing is checked: with any other history a query may miss pairs.
    #[must_use]
    pub fn new_unchecked(
        vertices: usize,
        triangles: &'a [[u32; 3]],
        history: &'a mut [u32],
    ) -> Self {
        let (rings, _) = split(history, vertices);
        Self { triangles, rings: must_cast_slice_mut(rings), links: &mut [] }
    }

    /// Takes memory with which all one-rings can be certified on several threads.
    ///
    /// `links` begin with the scratch of [`OneRings::new`] as that has left it, and have a word more for each triangle.
    /// They are not checked: with any others a query may miss pairs.
    ///
    /// # Errors
    /// [`CapacityError`] if `links` are fewer words than [`links_bound`].
    ///
    /// # Examples
    /// ```
    /// use pfront_core::Mesh;
    /// use pfront_core::one_ring::{OneRings, history_bound, links_bound};
    /// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
    /// let (mut history, mut links) = ([0; history_bound(3)], [0; links_bound(3, 1)]);
    /// OneRings::new(3, mesh.triangles(), &mut history, &mut links)?;
    /// let rings = OneRings::new_unchecked(3, mesh.triangles(), &mut history);
    /// let mut rings = rings.with_links(&mut links)?;
    /// let in_turn = |a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)| (a(), b()).0;
    /// assert!(rings.certify(mesh, Some(&in_turn)).is_certified(0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_links(self, links: &'a mut [u32]) -> Result<Self, CapacityError> {
        let needed = links_bound(self.rings.len(), self.triangles.len());
        CapacityError::check("links", needed, links.len())?;
        Ok(Self { links: &mut links[..needed], ..self })
    }
}
