//! The cheapest plane between bins of triangles, by the surface area heuristic.

use super::divide::Split;
use super::item::{LaneBox, SahItem, centre};
use crate::aabb::Bounds;
use crate::parallel::{GRAIN, Join, both};
use crate::simd::{LANES, Simd, Task, widest};

/// Bins per axis of a large run.
const MAX_BINS: usize = 16;

/// Maps centres to bins. Lanes are those of [`centre`]; beyond the third they mean nothing.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    origin: [f32; LANES],
    bins_per_unit: [f32; LANES],
}

impl Grid {
    /// Adding it moves the integer part of a small number to the lowest bits.
    pub(super) const TO_BITS: f32 = 8_388_608.0;

    fn new(centres: &Bounds, bins: usize) -> Self {
        let mut grid = Self { origin: [0.0; LANES], bins_per_unit: [0.0; LANES] };
        let extent = centres.max - centres.min;
        // No plane is sought across an axis less than half as long as the longest: it leaves most of the area to both
        // sides, and the axis comes second even when the longest has been halved.
        let shortest = 0.5 * extent.max_element();
        for (axis, extent) in extent.to_array().into_iter().enumerate() {
            grid.origin[axis] = centres.min[axis];
            // A hair below `bins`, so that the last centre is not rounded up into one bin more.
            let per_unit = bins as f32 * 0.9999 / extent;
            let is_usable = per_unit <= f32::MAX && extent >= shortest;
            grid.bins_per_unit[axis] = if is_usable { per_unit } else { 0.0 };
        }
        grid
    }

    /// Whether planes across an axis are sought.
    #[inline(always)]
    fn is_usable(&self, axis: usize) -> bool {
        self.bins_per_unit[axis] > 0.0
    }

    /// The bin of a centre on each axis, plus [`Grid::TO_BITS`].
    #[inline(always)]
    pub(super) fn bins<S: Simd>(&self, centre: S) -> S {
        let position = (centre - S::load(&self.origin, 0)) * S::load(&self.bins_per_unit, 0);
        (position - S::splat(0.5)).max(S::splat(0.0)) + S::splat(Self::TO_BITS)
    }
}

struct Plane {
    /// Area times triangles, summed over both sides.
    cost: f64,
    /// The bin right of the plane.
    bin: usize,
}

struct Bins {
    boxes: [[LaneBox; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

/// The cheapest plane with items on both sides, or `None` where the centres coincide or all areas are 0.
pub(super) fn best_split(
    items: &[SahItem],
    centres: &Bounds,
    join: Option<&Join<'_>>,
) -> Option<Split> {
    // Most runs are small, and sweeping all bins would cost them more than filling them.
    let count = (4 + items.len() / 16).min(MAX_BINS);
    let grid = Grid::new(centres, count);
    let mut bins = Bins::EMPTY;
    bins.fill(items, &grid, join);
    let usable = (0..3).filter(|&axis| grid.is_usable(axis));
    let planes = usable.map(|axis| (axis, bins.sweep(axis, count)));
    let (axis, plane) = planes.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
    (plane.cost > 0.0 && plane.cost < f64::INFINITY).then(|| Split::new(axis, grid, plane.bin))
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[LaneBox::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    fn fill(&mut self, items: &[SahItem], grid: &Grid, join: Option<&Join<'_>>) {
        if items.len() <= GRAIN {
            return widest(Fill { bins: self, items, grid });
        }
        let ((left, right), mut other) = (items.split_at(items.len() / 2), Self::EMPTY);
        both(join, || self.fill(left, grid, join), || other.fill(right, grid, join));
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(&other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// The cheapest plane of one axis with items on both sides.
    fn sweep(&self, axis: usize, bins: usize) -> Plane {
        let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
        let mut right_costs = [0.0; MAX_BINS];
        let (mut side, mut items) = (LaneBox::EMPTY, 0);
        for bin in (1..bins).rev() {
            side = side.union(&boxes[bin]);
            items += counts[bin];
            right_costs[bin] = side.bounds().half_area() * f64::from(items);
        }
        let all = items + counts[0];
        let mut best = Plane { cost: f64::INFINITY, bin: 0 };
        (side, items) = (LaneBox::EMPTY, 0);
        for bin in 1..bins {
            side = side.union(&boxes[bin - 1]);
            items += counts[bin - 1];
            let cost = side.bounds().half_area() * f64::from(items) + right_costs[bin];
            if cost < best.cost && items > 0 && items < all {
                best = Plane { cost, bin };
            }
        }
        best
    }
}

struct Fill<'f> {
    bins: &'f mut Bins,
    items: &'f [SahItem],
    grid: &'f Grid,
}

impl Task for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { bins, items, grid } = self;
        let usable = [0, 1, 2].map(|axis| grid.is_usable(axis));
        for item in items {
            let item = item.load::<S>();
            let mut at = [0.0; LANES];
            grid.bins(centre(item)).store(&mut at, 0);
            for axis in (0..3).filter(|&axis| usable[axis]) {
                let bin = at[axis].to_bits() as usize % MAX_BINS;
                let grown = &mut bins.boxes[axis][bin].0;
                S::load(grown, 0).min(item).store(grown, 0);
                bins.counts[axis][bin] += 1;
            }
        }
    }
}
