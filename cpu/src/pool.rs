//! Whose threads do the work.

use rayon::ThreadPool;

/// How many threads the rayon pool of whoever asks has.
#[must_use]
pub fn current_threads() -> usize {
    rayon::current_num_threads()
}

/// Runs in a pool, or where it is.
pub(crate) fn in_pool<R: Send>(pool: Option<&ThreadPool>, run: impl FnOnce() -> R + Send) -> R {
    match pool {
        Some(pool) => pool.install(run),
        None => run(),
    }
}
