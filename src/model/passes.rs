//! On how many threads the passes over a whole model run.

use pfront_core::bvh::Join;

pub(super) type Parallel = Option<&'static Join<'static>>;

pub(super) const ONE_THREAD: Parallel = None;

#[cfg(feature = "threads")]
pub(super) const THREADS: Parallel = Some(&crate::threads::join);

/// Does two things, side by side if it can.
pub(super) fn both(
    parallel: Parallel,
    one: &mut (dyn FnMut() + Send),
    other: &mut (dyn FnMut() + Send),
) {
    if let Some(join) = parallel {
        return join(one, other);
    }
    one();
    other();
}
