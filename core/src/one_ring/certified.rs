//! Certificates of one-rings, for the positions of a mesh.

use super::ring::OneRing;
use crate::Mesh;
use bytemuck::must_cast_slice;

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
    pub(super) mesh: Mesh<'a>,
    /// One for each vertex, or none at all.
    pub(super) rings: &'a [OneRing],
    pub(super) fans: Fans<'a>,
}

impl<'a> Certified<'a> {
    pub(super) fn new(mesh: Mesh<'a>, rings: &'a [OneRing]) -> Self {
        Self { mesh, rings, fans: Fans::NONE }
    }

    /// Borrows again the certificates in a history that [`OneRings::certify`](super::OneRings::certify) has brought up to date.
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

/// A bit for each node of a BVH: whether all triangles below have the same hub.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fans<'a> {
    /// Empty if no node is marked.
    pub(super) marks: &'a [u32],
    /// The BVH: where its nodes are, and its order.
    pub(super) nodes: usize,
    pub(super) order: &'a [u32],
}

impl Fans<'_> {
    const NONE: Self = Self { marks: &[], nodes: 0, order: &[] };
}
