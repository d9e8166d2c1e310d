//! The cheapest plane between bins of triangles, by the surface area heuristic.

use super::item::bounds;
use crate::Node;
use crate::aabb::Bounds;
use crate::bvh::TO_BITS;
use crate::parallel::{GRAIN, Join, both};
use glam::Vec3A;

/// Bins per axis of a large run, as in Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies* (2007).
const MAX_BINS: usize = 16;

/// Maps centres to bins.
#[derive(Clone, Copy, Debug)]
struct Binning {
    origin: Vec3A,
    /// 0 on axes across which no plane is sought.
    bins_per_unit: Vec3A,
}

impl Binning {
    fn new(centres: &Bounds, bins: usize) -> Self {
        let extent = centres.max - centres.min;
        // A hair below `bins`, so that the last centre is not rounded up into one bin more.
        let per_unit = Vec3A::splat(bins as f32 * 0.9999) / extent;
        // No plane is sought across an axis less than half as long as the longest: it leaves most of the area to both
        // sides, and the axis comes second even when the longest has been halved.
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX))
            & extent.cmpge(Vec3A::splat(0.5 * extent.max_element()));
        let bins_per_unit = Vec3A::select(usable, per_unit, Vec3A::ZERO);
        Self { origin: centres.min, bins_per_unit }
    }

    /// The bin of a centre on each axis, plus [`TO_BITS`].
    #[inline(always)]
    fn bins(&self, centre: Vec3A) -> Vec3A {
        let position = (centre - self.origin) * self.bins_per_unit;
        (position - 0.5).max(Vec3A::ZERO) + TO_BITS
    }
}

/// A plane between two bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    binning: Binning,
    /// Across the plane.
    axis: usize,
    /// The first bin on the right, plus [`TO_BITS`].
    bin: f32,
}

impl Split {
    fn new(axis: usize, binning: Binning, bin: usize) -> Self {
        Self { binning, axis, bin: bin as f32 + TO_BITS }
    }

    /// Whether a centre lies on the right of the plane.
    #[inline(always)]
    pub(super) fn is_right(&self, centre: Vec3A) -> bool {
        self.binning.bins(centre)[self.axis] >= self.bin
    }
}

struct Plane {
    /// Area times triangles, summed over both sides.
    cost: f64,
    /// The bin right of the plane.
    bin: usize,
}

struct Bins {
    boxes: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

/// The cheapest plane with items on both sides, or `None` where the centres coincide or all areas are 0.
pub(super) fn best_split(
    items: &[Node],
    centres: &Bounds,
    join: Option<&Join<'_>>,
) -> Option<Split> {
    // Most runs are small, and sweeping all bins would cost them more than filling them.
    let count = (4 + items.len() / 16).min(MAX_BINS);
    let binning = Binning::new(centres, count);
    let mut bins = Bins::EMPTY;
    bins.fill(items, &binning, join);
    let usable = (0..3).filter(|&axis| binning.bins_per_unit[axis] > 0.0);
    let planes = usable.map(|axis| (axis, bins.sweep(axis, count)));
    let (axis, plane) = planes.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
    (plane.cost > 0.0 && plane.cost < f64::INFINITY).then(|| Split::new(axis, binning, plane.bin))
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[Bounds::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    fn fill(&mut self, items: &[Node], binning: &Binning, join: Option<&Join<'_>>) {
        if items.len() <= GRAIN {
            return self.add(items, binning);
        }
        let ((left, right), mut other) = (items.split_at(items.len() / 2), Self::EMPTY);
        both(join, || self.fill(left, binning, join), || other.fill(right, binning, join));
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(&other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    fn add(&mut self, items: &[Node], binning: &Binning) {
        let usable = [0, 1, 2].map(|axis| binning.bins_per_unit[axis] > 0.0);
        for item in items {
            let bounds = bounds(item);
            let at = binning.bins(bounds.half_centre()).to_array();
            for axis in (0..3).filter(|&axis| usable[axis]) {
                let bin = at[axis].to_bits() as usize % MAX_BINS;
                self.boxes[axis][bin] = self.boxes[axis][bin].union(&bounds);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// The cheapest plane of one axis with items on both sides.
    fn sweep(&self, axis: usize, bins: usize) -> Plane {
        let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
        let mut right_costs = [0.0; MAX_BINS];
        let (mut side, mut items) = (Bounds::EMPTY, 0);
        for bin in (1..bins).rev() {
            side = side.union(&boxes[bin]);
            items += counts[bin];
            right_costs[bin] = side.half_area() * f64::from(items);
        }
        let all = items + counts[0];
        let mut best = Plane { cost: f64::INFINITY, bin: 0 };
        (side, items) = (Bounds::EMPTY, 0);
        for bin in 1..bins {
            side = side.union(&boxes[bin - 1]);
            items += counts[bin - 1];
            let cost = side.half_area() * f64::from(items) + right_costs[bin];
            if cost < best.cost && items > 0 && items < all {
                best = Plane { cost, bin };
            }
        }
        best
    }
}
