//! Three numbers that identify the contents of a model.

use std::sync::atomic::{AtomicU64, Ordering};

/// Says what a [`Model`](crate::Model) holds: where stamps are equal, so are the mesh, the BVH and every
/// position, to the bit, whichever models they were taken of. Stamps that differ say nothing.
///
/// A stamp changes only with what borrows the model mutably: a clone has that of its original until
/// either is changed.
///
/// # Examples
/// ```
/// let mut model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
/// let (before, copy) = (model.stamp(), model.clone());
/// model.set_positions(&[[0.0_f32; 3]; 3])?;
/// assert_eq!(model.stamp(), before);
/// model.set_positions(&[[1.0_f32; 3]; 3])?;
/// assert_ne!(model.stamp(), before);
/// assert_eq!(model.stamp().tree(), before.tree());
/// assert_eq!(copy.stamp(), before);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stamp {
    mesh: u64,
    tree: u64,
    positions: u64,
}

impl Stamp {
    /// The stamp of a mesh that differs from all before.
    pub(super) fn new() -> Self {
        Self { mesh: next(), tree: next(), positions: next() }
    }

    /// Number of the triangles and of how many vertices there are.
    #[must_use]
    pub fn mesh(self) -> u64 {
        self.mesh
    }

    /// Number of the nodes and their order, but for their boxes: a build changes it, a refit does not.
    #[must_use]
    pub fn tree(self) -> u64 {
        self.tree
    }

    /// Number of the positions: a build does not change it.
    #[must_use]
    pub fn positions(self) -> u64 {
        self.positions
    }

    pub(super) fn moved(&mut self) {
        self.positions = next();
    }

    pub(super) fn rebuilt(&mut self) {
        self.tree = next();
    }
}

/// A number that this process has not used.
fn next() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}
