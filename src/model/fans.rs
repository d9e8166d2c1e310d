//! The fans of a model.

use super::moves::Moves;
use super::tree::Tree;
use pfront_core::build::{Moved, moved_bound};
use pfront_core::fans::{self, Fan};
use pfront_core::{CapacityError, Mesh};

#[derive(Clone, Debug)]
pub(super) struct Fans {
    fans: Vec<Fan>,
    scratch: Vec<Moved>,
    /// More has moved since they were up to date than since the tree fitted.
    behind: bool,
}

impl Fans {
    pub(super) fn new(mesh: Mesh<'_>) -> Self {
        let mut fans = vec![Fan::default(); mesh.positions().len()];
        let need = fans::link_scratch_bound(fans.len(), mesh.triangles().len());
        let linked = fans::link(mesh, &mut vec![0; need], &mut fans);
        check(linked);
        let mut fans = Self { fans, scratch: Vec::new(), behind: false };
        fans.certify(mesh);
        fans
    }

    /// Brings all up to date.
    pub(super) fn certify(&mut self, mesh: Mesh<'_>) {
        check(fans::certify(mesh, &mut self.fans));
        self.behind = false;
    }

    /// The same where it is enough to look at what has moved since a tree fitted that fits again.
    pub(super) fn certify_moved(&mut self, mesh: Mesh<'_>, tree: &Tree, moves: &Moves) {
        let (Some(moved), Some(table), false) = (moves.few(), tree.table(), self.behind) else {
            return self.certify(mesh);
        };
        self.scratch.resize(moved_bound(self.fans.len()), Moved::default());
        let (scratch, fans) = (&mut self.scratch, &mut self.fans);
        check(fans::certify_moved(&tree.bvh(mesh), table, moved, scratch, fans));
    }

    /// To be called when the tree fits and they do not, before anything moves.
    pub(super) fn fall_behind(&mut self) {
        self.behind = true;
    }

    pub(super) fn as_slice(&self) -> &[Fan] {
        &self.fans
    }

    pub(super) fn bytes(&self) -> usize {
        self.fans.capacity() * size_of::<Fan>() + self.scratch.capacity() * size_of::<Moved>()
    }
}

/// With buffers of the right size nothing fails; without a certificate a query would be slower.
fn check(made: Result<(), CapacityError>) {
    debug_assert_eq!(made, Ok(()));
}
