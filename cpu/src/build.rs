//! The fork-join of rayon, for builds, refits and certification of `pfront-core`.

use pfront_core::environment::with_default;

/// Runs two tasks side by side in the rayon pool of the calling thread: a `pfront_core::bvh::Join`, for
/// `BuildOptions`, `Refit` and the like. Both run in the default floating-point environment, whatever that of their threads is.
///
/// # Examples
/// ```
/// let (mut a, mut b) = (1, 2);
/// pfront_cpu::join(&mut || a += 1, &mut || b += 1);
/// assert_eq!([a, b], [2, 3]);
/// ```
pub fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(|| with_default(a), || with_default(b));
}
