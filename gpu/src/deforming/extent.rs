//! Extremes of positions, found while they are copied.

use pfront_core::Aabb;

/// Extremes of coordinates: four vertices at once, so that compilers use vectors.
pub(super) struct Extent {
    least: [f32; 12],
    most: [f32; 12],
    /// The sum of zero times each: NaN from the first on that is not finite.
    zeros: [f32; 12],
}

impl Default for Extent {
    fn default() -> Self {
        Self { least: [f32::INFINITY; 12], most: [f32::NEG_INFINITY; 12], zeros: [0.0; 12] }
    }
}

impl Extent {
    pub(super) fn add(&mut self, positions: &[[f32; 3]]) {
        let coordinates: &[f32] = bytemuck::cast_slice(positions);
        let (fours, rest) = coordinates.as_chunks::<12>();
        for four in fours {
            for (k, &x) in four.iter().enumerate() {
                self.add_coordinate(k, x);
            }
        }
        for (k, &x) in rest.iter().enumerate() {
            self.add_coordinate(k, x);
        }
    }

    #[inline]
    fn add_coordinate(&mut self, k: usize, x: f32) {
        self.least[k] = if x < self.least[k] { x } else { self.least[k] };
        self.most[k] = if x > self.most[k] { x } else { self.most[k] };
        self.zeros[k] += 0.0 * x;
    }

    pub(super) fn is_finite(&self) -> bool {
        self.zeros.iter().all(|&zero| zero == 0.0)
    }

    pub(super) fn aabb(&self) -> Aabb {
        let [mut min, mut max] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for k in 0..12 {
            min[k % 3] = min[k % 3].min(self.least[k]);
            max[k % 3] = max[k % 3].max(self.most[k]);
        }
        Aabb { min, max }
    }
}
