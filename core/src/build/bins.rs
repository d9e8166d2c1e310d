//! Where to split a run of items: bins along each axis, and the cheapest plane between two bins.

use super::sah::SahItem;
use crate::aabb::Bounds;
use glam::Vec3A;

/// Bins per axis of a large run. Measured on a scan of 871,414 triangles; see [`Bins::count`].
const MAX_BINS: usize = 16;

impl Bounds {
    pub(super) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub(super) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub(super) fn with(&self, point: Vec3A) -> Self {
        self.union(&Self { min: point, max: point })
    }
}

/// A power of two that brings the root box to a size whose areas neither overflow nor vanish.
#[derive(Clone, Copy)]
pub(super) struct AreaScale(f32);

impl AreaScale {
    pub(super) fn new(root: &Bounds) -> Self {
        let half_edge = (root.max * 0.5 - root.min * 0.5).max_element();
        // Half the longest edge becomes 2^28 or a little more. The biased exponents of a number and
        // of its reciprocal power of two add up to 254.
        let exponent = (254 + 28 - (half_edge.to_bits() >> 23)).clamp(1, 254);
        Self(f32::from_bits(exponent << 23))
    }

    /// Half the surface area of a box in the scaled unit. Scaling first cannot overflow where
    /// there is an extent to measure; where there is none, inf − inf counts as 0.
    fn half_area(self, bounds: &Bounds) -> f32 {
        let edges = (bounds.max * self.0 - bounds.min * self.0).max(Vec3A::ZERO);
        let [x, y, z] = edges.to_array();
        x * y + y * z + z * x
    }
}

/// A plane between two bins.
pub(super) struct Split {
    axis: usize,
    grid: Grid,
    /// The first bin on the right.
    bin: u32,
    pub(super) left: Bounds,
    pub(super) right: Bounds,
}

impl Split {
    pub(super) fn is_left(&self, item: &SahItem) -> bool {
        self.grid.bins(item)[self.axis] < self.bin
    }
}

/// Maps centres to bins.
#[derive(Clone, Copy)]
struct Grid {
    origin: Vec3A,
    bins_per_unit: Vec3A,
}

impl Grid {
    /// Adding it moves the integer part of a small number to the lowest bits.
    const TO_BITS: f32 = 8_388_608.0;

    fn new(centres: &Bounds, bins: usize) -> Self {
        let extent = centres.max - centres.min;
        // A hair below `bins`, so that the last centre is not rounded up into one bin more.
        let per_unit = Vec3A::splat(bins as f32 * 0.9999) / extent;
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX));
        Self { origin: centres.min, bins_per_unit: Vec3A::select(usable, per_unit, Vec3A::ZERO) }
    }

    #[inline]
    fn bins(&self, item: &SahItem) -> [u32; 3] {
        let position = (item.centre() - self.origin) * self.bins_per_unit;
        let rounded = (position - 0.5).max(Vec3A::ZERO) + Self::TO_BITS;
        rounded.to_array().map(|x| x.to_bits() % MAX_BINS as u32)
    }
}

/// The bins of the three axes.
pub(super) struct Bins {
    bounds: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    pub(super) fn new() -> Self {
        Self { bounds: [[Bounds::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] }
    }

    /// How many bins a run deserves: most nodes are small, and sweeping bins would cost them more
    /// than filling them (after Wald 2007; Embree does the same).
    fn count(items: usize) -> usize {
        (4 + items / 16).min(MAX_BINS)
    }

    /// The cheapest plane, or `None` where no plane has items and a finite cost on both sides, or
    /// the areas are 0 and tell nothing.
    pub(super) fn best_split(
        &mut self,
        items: &[SahItem],
        centres: &Bounds,
        scale: AreaScale,
    ) -> Option<Split> {
        let bins = Self::count(items.len());
        let grid = Grid::new(centres, bins);
        self.fill(items, &grid, bins);
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        for axis in 0..3 {
            if grid.bins_per_unit.to_array()[axis] > 0.0
                && let Some((cost, bin)) = self.sweep(axis, bins, scale)
                && cost < best_cost
            {
                best_cost = cost;
                best = Some((axis, bin));
            }
        }
        let (axis, bin) = best?;
        let union = |bins: &[Bounds]| bins.iter().fold(Bounds::EMPTY, |a, b| a.union(b));
        let (left, right) = self.bounds[axis][..bins].split_at(bin);
        let (left, right) = (union(left), union(right));
        Some(Split { axis, grid, bin: bin as u32, left, right })
    }

    fn fill(&mut self, items: &[SahItem], grid: &Grid, bins: usize) {
        for axis in 0..3 {
            self.bounds[axis][..bins].fill(Bounds::EMPTY);
            self.counts[axis][..bins].fill(0);
        }
        for item in items {
            let bounds = item.bounds();
            for (axis, bin) in grid.bins(item).map(|bin| bin as usize).into_iter().enumerate() {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(&bounds);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// The least area times triangles over the planes of one axis, and the bin right of the plane.
    fn sweep(&self, axis: usize, bins: usize, scale: AreaScale) -> Option<(f32, usize)> {
        let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
        let mut right_costs = [0.0; MAX_BINS];
        let (mut side, mut items) = (Bounds::EMPTY, 0);
        for bin in (1..bins).rev() {
            side = side.union(&bounds[bin]);
            items += counts[bin];
            right_costs[bin] = scale.half_area(&side) * items as f32;
        }
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        let all = items + counts[0];
        (side, items) = (Bounds::EMPTY, 0);
        for bin in 1..bins {
            side = side.union(&bounds[bin - 1]);
            items += counts[bin - 1];
            let cost = scale.half_area(&side) * items as f32 + right_costs[bin];
            if cost < best_cost && items > 0 && items < all {
                best_cost = cost;
                best = Some((cost, bin));
            }
        }
        best
    }
}
