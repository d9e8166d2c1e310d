//! The fans of a model.

use super::moves::Moves;
use super::passes::Passes;
use pfront_core::bvh::{Moved, moved_bound};
use pfront_core::one_ring::{self, Fan, Span};
use pfront_core::{CapacityError, Mesh};

#[derive(Clone, Debug)]
pub(super) struct Fans {
    fans: Vec<Fan>,
    spans: Vec<Span>,
    scratch: Vec<Moved>,
    /// More has moved since they were up to date than since the tree fitted.
    behind: bool,
}

impl Fans {
    pub(super) fn new(mesh: Mesh<'_>) -> Self {
        let (vertices, triangles) = (mesh.positions().len(), mesh.triangles().len());
        let mut fans = vec![Fan::default(); vertices];
        let mut spans = vec![Span::default(); one_ring::span_bound(triangles)];
        check(one_ring::link(
            mesh,
            &mut vec![0; one_ring::link_scratch_bound(vertices, triangles)],
            &mut fans,
        ));
        check(one_ring::certify(mesh, &mut fans));
        check(one_ring::find_spans(mesh, &mut spans));
        Self { fans, spans, scratch: vec![Moved::default(); moved_bound(vertices)], behind: false }
    }

    /// Brings the fans up to date with positions that have moved since they were.
    pub(super) fn renew(&mut self, mesh: Mesh<'_>, moves: &Moves, passes: &Passes) {
        let (fans, scratch) = (&mut self.fans, &mut self.scratch);
        check(match moves.few().filter(|_| !self.behind) {
            Some(moved) => one_ring::certify_moved(mesh, &self.spans, moved, scratch, fans),
            None => (passes.certify)(mesh, &self.spans, fans),
        });
        self.behind = false;
    }

    /// To be called when the tree fits and they are not up to date, before anything moves.
    pub(super) fn fall_behind(&mut self) {
        self.behind = true;
    }

    pub(super) fn as_slice(&self) -> &[Fan] {
        &self.fans
    }

    pub(super) fn bytes(&self) -> usize {
        self.fans.capacity() * size_of::<Fan>()
            + self.spans.capacity() * size_of::<Span>()
            + self.scratch.capacity() * size_of::<Moved>()
    }
}

/// With buffers of the right size nothing fails; without a certificate a query would be slower.
fn check(made: Result<(), CapacityError>) {
    debug_assert_eq!(made, Ok(()));
}
