//! The passes over a whole model, on as many threads as one likes.

use pfront_core::bvh::{self, BuildOptions, BvhStorage, Join, SahItem};
use pfront_core::{Bvh, CapacityError, Mesh, Node};

pub(super) struct Passes {
    pub(super) sah: Sah,
    pub(super) refit: Refit,
    /// The quality figure of a tree that fits.
    pub(super) quality: Refit,
    /// What runs the parts of a certification, if it is not one thread.
    pub(super) join: Option<&'static Join<'static>>,
    /// Does two things, at once if it can.
    pub(super) both: Both,
}

type Sah = for<'a> fn(
    Mesh<'a>,
    &BuildOptions,
    BvhStorage<'a>,
    &mut [SahItem],
) -> Result<Bvh<'a>, CapacityError>;
type Both = fn(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send));
type Refit = fn(Mesh<'_>, &mut [Node], &[u32]) -> f32;

pub(super) const ONE_THREAD: Passes = Passes {
    sah: bvh::sah,
    refit: bvh::refit,
    quality: |mesh, nodes, order| bvh::quality(&Bvh::new_unchecked(mesh, nodes, order)),
    join: None,
    both: |one, other| {
        one();
        other();
    },
};

/// A refit changes no box that fits.
#[cfg(feature = "threads")]
pub(super) const THREADS: Passes = Passes {
    sah: crate::threads::sah,
    refit: crate::threads::refit,
    quality: crate::threads::refit,
    join: Some(&crate::threads::join),
    both: crate::threads::join,
};
