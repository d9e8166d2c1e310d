//! How large cases are.

/// How large cases may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Triangles of all bodies, more or less.
    pub triangles: usize,
    /// Bodies of a scene.
    pub bodies: usize,
    /// The time that all frames may take one thread, at a guess; one frame may take more. It bounds what frames
    /// take of memory, too: 2 seconds are some 200 MB.
    pub seconds: f64,
}

impl Scale {
    /// For the record: up to 3 million triangles and 10,000 bodies.
    pub const FULL: Self = Self { triangles: 3_000_000, bodies: 10_000, seconds: 2.0 };
    /// To see that it works.
    pub const QUICK: Self = Self { triangles: 10_000, bodies: 100, seconds: 0.01 };
}

/// From `least` to `most` as `share` goes from 0 to 1, by equal factors for equal steps.
pub(super) fn by_factors(least: usize, most: usize, share: f64) -> usize {
    let [low, high] = [least, most.max(least)].map(|n| (n as f64).ln());
    ((low + (high - low) * share).exp().round() as usize).clamp(least, most.max(least))
}
