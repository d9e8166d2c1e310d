//! The one-ring certificates of a model.

use super::passes::Parallel;
use crate::Error;
use crate::memory::{filled, reserve};
use pfront_core::Mesh;
use pfront_core::one_ring::{Certified, OneRings, history_bound, link_scratch_bound, links_bound};

/// The history of the one-rings of one mesh, whose triangles never change.
///
/// [`Renewed`](super::renewed::Renewed) holds it, and calls [`Certificates::renew`] after positions have changed
/// before anybody reads it.
/// The default has none, whatever moves.
#[derive(Clone, Debug, Default)]
pub(super) struct Certificates {
    history: Vec<u32>,
    /// See [`OneRings::with_links`]; empty until certification is divided.
    links: Vec<u32>,
    /// Whether there are vertices of many triangles.
    has_fans: bool,
}

impl Certificates {
    /// # Errors
    /// [`Error::Memory`].
    pub(super) fn new(mesh: Mesh<'_>) -> Result<Self, Error> {
        let mut new = Self::uncertified(mesh)?;
        new.renew(mesh, None);
        Ok(new)
    }

    /// Links the one-rings, of which none is certified yet.
    fn uncertified(mesh: Mesh<'_>) -> Result<Self, Error> {
        let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles());
        let mut history = filled(0, history_bound(vertices))?;
        let mut scratch = filled(0, link_scratch_bound(vertices, triangles.len()))?;
        let linked = OneRings::new(vertices, triangles, &mut history, &mut scratch);
        debug_assert!(linked.is_ok(), "the buffers have their sizes");
        let has_fans = linked.is_ok_and(|rings| rings.has_fans());
        Ok(Self { history, links: Vec::new(), has_fans })
    }

    /// Whether a mesh has vertices of many triangles. No, if there is no memory to find out: then a query takes longer.
    pub(super) fn are_for_fans(mesh: Mesh<'_>) -> bool {
        Self::uncertified(mesh).is_ok_and(|certificates| certificates.has_fans)
    }

    /// Certifies the one-rings for positions that have changed.
    pub(super) fn renew(&mut self, mesh: Mesh<'_>, parallel: Parallel) {
        let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles());
        let Self { history, links, .. } = self;
        if history.is_empty() {
            return;
        }
        let bound = links_bound(vertices, triangles.len());
        // Without memory for them, one thread certifies.
        if parallel.is_some() && links.is_empty() && reserve(links, bound).is_ok() {
            links.resize(bound, 0);
            let linked = OneRings::new(vertices, triangles, history, links);
            debug_assert!(linked.is_ok(), "the buffers have their sizes");
        }
        let rings = OneRings::new_unchecked(vertices, triangles, history);
        let linked = if links.is_empty() { Ok(rings) } else { rings.with_links(links) };
        debug_assert!(linked.is_ok(), "the links have their size");
        if let Ok(mut rings) = linked {
            rings.certify(mesh, parallel);
        }
    }

    /// The certificates, after [`Certificates::renew`] for the positions of `mesh`.
    pub(super) fn certified<'a>(&'a self, mesh: Mesh<'a>) -> Certified<'a> {
        Certified::new_unchecked(mesh, &self.history)
    }

    /// Whether the nodes around vertices of many triangles have to be marked.
    pub(super) fn has_fans(&self) -> bool {
        self.has_fans
    }

    pub(super) fn bytes(&self) -> usize {
        (self.history.capacity() + self.links.capacity()) * size_of::<u32>()
    }
}
