//! On how many threads the passes over a whole model run.

use pfront_core::bvh::Join;

type Positions = [[f32; 3]];

pub(crate) type Parallel = Option<&'static Join<'static>>;

pub(crate) const ONE_THREAD: Parallel = None;

#[cfg(feature = "threads")]
pub(crate) const THREADS: Parallel = Some(&crate::threads::join);
#[cfg(not(feature = "threads"))]
pub(crate) const THREADS: Parallel = ONE_THREAD;

#[cfg(feature = "threads")]
use crate::threads::rayon::current_num_threads;
#[cfg(not(feature = "threads"))]
fn current_num_threads() -> usize {
    1
}

/// `parallel` if the pool has at least four threads: the divided pass does half as much work again.
pub(super) fn if_four_threads(parallel: Parallel) -> Parallel {
    parallel.filter(|_| current_num_threads() >= 4)
}

/// The number of threads that passes run on.
pub(super) fn threads(parallel: Parallel) -> usize {
    parallel.map_or(1, |_| current_num_threads())
}

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

/// Positions that one task takes: some ten microseconds.
const PART: usize = 1 << 14;

/// Whether `check` holds for all parts of a list, side by side if it can.
pub(super) fn all_parts(
    parallel: Parallel,
    list: &Positions,
    check: &(dyn Fn(&Positions) -> bool + Sync),
) -> bool {
    let Some(join) = parallel.filter(|_| list.len() > PART) else { return check(list) };
    let (list, rest) = list.split_at(list.len() / 2);
    let (mut left, mut right) = (true, true);
    join(&mut || left = all_parts(parallel, list, check), &mut || {
        right = all_parts(parallel, rest, check);
    });
    left && right
}

/// Copies a list over another one of that length, parts side by side if it can.
pub(super) fn copy_parts(parallel: Parallel, from: &Positions, to: &mut Positions) {
    let Some(join) = parallel.filter(|_| from.len() > PART) else {
        return to.copy_from_slice(from);
    };
    let (from, right_from) = from.split_at(from.len() / 2);
    let (to, right_to) = to.split_at_mut(from.len());
    join(&mut || copy_parts(parallel, from, to), &mut || {
        copy_parts(parallel, right_from, right_to);
    });
}
