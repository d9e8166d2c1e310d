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

mod certify;
mod fan;
mod link;
#[cfg(test)]
mod tests;

use crate::index::split;
use crate::{CapacityError, Mesh};
use bytemuck::{Pod, Zeroable, must_cast_slice, must_cast_slice_mut};
pub(crate) use certify::turns_in_f64;
pub use fan::fan_bound;
use fan::{Fans, LARGE};
pub(crate) use fan::{hub_of, is_marked};
pub use link::{link_scratch_bound, links_bound};

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
    /// `triangles` are those of a [`Mesh`] of so many vertices; `scratch` is not used afterwards, but for
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
        Ok(Self { links: split(links, needed).0, ..self })
    }
}

/// Certificates of the one-rings of a mesh, for its positions.
///
/// It borrows the positions that it holds for, so that they cannot change while it is used:
/// ```compile_fail,E0506
/// # use pfront_core::{Mesh, one_ring::OneRings};
/// # let (mut positions, triangles) = ([[0.0; 3]; 3], [[0, 1, 2]]);
/// # let (mut history, mut scratch) = ([0; 9], [0; 9]);
/// # let mut rings = OneRings::new(3, &triangles, &mut history, &mut scratch)?;
/// let mesh = Mesh::new(&positions, &triangles)?;
/// let certified = rings.certify(mesh, None);
/// positions[0] = [1.0; 3];
/// certified.is_certified(0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Certified<'a> {
    mesh: Mesh<'a>,
    /// One for each vertex, or none at all.
    rings: &'a [OneRing],
    fans: Fans<'a>,
}

impl<'a> Certified<'a> {
    fn new(mesh: Mesh<'a>, rings: &'a [OneRing]) -> Self {
        Self { mesh, rings, fans: Fans::NONE }
    }

    /// Borrows again the certificates in a history that [`OneRings::certify`] has brought up to date.
    ///
    /// Nothing is checked: if the mesh has other triangles, or any other position, a query may miss pairs.
    #[must_use]
    pub fn new_unchecked(mesh: Mesh<'a>, history: &'a [u32]) -> Self {
        let (rings, _) = history.split_at(mesh.vertex_count().min(history.len()));
        Self::new(mesh, must_cast_slice(rings))
    }

    /// Whether no two triangles around the vertex intersect in more than what they share by index.
    #[must_use]
    pub fn is_certified(self, vertex: u32) -> bool {
        self.rings.get(vertex as usize).is_some_and(|ring| ring.is_certified())
    }

    /// The certificate of each vertex if `mesh` is the very one that they were made for, else none.
    ///
    /// Both borrow their slices, so slices in the same place hold the same.
    pub(crate) fn of_mesh(self, mesh: Mesh<'_>) -> &'a [OneRing] {
        let in_f64 = |mesh: Mesh<'_>| mesh.positions_f64().map(<[_]>::as_ptr);
        let same = core::ptr::eq(self.mesh.shadow(), mesh.shadow())
            && in_f64(self.mesh) == in_f64(mesh)
            && core::ptr::eq(self.mesh.triangles(), mesh.triangles());
        if same { self.rings } else { &[] }
    }
}

/// The triangles around one vertex: how they are connected, and whether they are certified.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct OneRing(u32);

/// The triangles around the vertex form a closed ring.
const RING: u32 = 1 << 31;
/// They form a row that begins and ends at the boundary.
const ROW: u32 = 1 << 30;
/// How many triangles there are, to a power of two; 0 if they are fewer than [`LARGE`].
const SIZE: u32 = 0x1f << 25;
/// No two of the triangles intersect in more than what they share by index.
const CERTIFIED: u32 = 1;

impl OneRing {
    /// The bits of the size of a one-ring, which are there if it is large: to a power of two.
    fn size(triangles: usize) -> u32 {
        if triangles < LARGE { 0 } else { triangles.ilog2() << SIZE.trailing_zeros() }
    }

    #[inline]
    pub(crate) fn is_certified(self) -> bool {
        self.0 & CERTIFIED != 0
    }

    /// Whether the triangles form one ring or one row.
    fn is_connected(self) -> bool {
        self.0 & (RING | ROW) != 0
    }

    /// Forgets all but how the triangles are connected.
    fn clear(&mut self) {
        self.0 &= RING | ROW | SIZE;
    }
}
