//! Where to split a run of items: bins along each axis, and the cheapest plane between two bins.

use super::divide::Split;
use super::item::{Extent, SahItem};
use super::parts::{PART, Parts};
use crate::aabb::Bounds;
use crate::lanes::{LANES, Simd, Task, widest};
use glam::Vec3A;

/// Bins per axis of a large run.
///
/// On the dragon (871,414 triangles) 8, 12, 16 and 32 bins give a quality of 17.94, 17.75, 17.65 and
/// 17.56, and 8, 16 and 32 take the same time.
const MAX_BINS: usize = 16;

/// A power of two that brings the root box to a size whose areas neither overflow nor vanish.
#[derive(Clone, Copy)]
pub(super) struct AreaScale(f32);

impl AreaScale {
    pub(super) fn new(root: &Bounds) -> Self {
        let exponent = |x: f32| x.to_bits() >> 23;
        let half_edge = (root.max * 0.5 - root.min * 0.5).max_element();
        let farthest = root.max.abs().max(root.min.abs()).max_element();
        // Biased exponents, so those of a power of two and its reciprocal add up to 254: half the
        // longest edge becomes about 2^28, unless that takes the farthest corner beyond 2^126.
        let scale = (254 + 28 - exponent(half_edge)).min(254 + 125 - exponent(farthest));
        Self(f32::from_bits(scale.clamp(1, 254) << 23))
    }

    /// Half the surface area of a box in the scaled unit, 0 if it is empty. Corners are scaled
    /// first: their difference may overflow before.
    fn half_area(self, bounds: &Bounds) -> f32 {
        let edges = (bounds.max * self.0 - bounds.min * self.0).max(Vec3A::ZERO);
        let [x, y, z] = edges.to_array();
        x * y + y * z + z * x
    }
}

/// Maps centres to bins. Lanes are those of [`centre`]; beyond the third they tell nothing.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    origin: [f32; LANES],
    bins_per_unit: [f32; LANES],
}

impl Grid {
    /// Adding it moves the integer part of a small number to the lowest bits.
    pub(super) const TO_BITS: f32 = 8_388_608.0;

    fn new(centres: &Bounds, bins: usize) -> Self {
        let extent = centres.max - centres.min;
        // A hair below `bins`, so that the last centre is not rounded up into one bin more.
        let per_unit = Vec3A::splat(bins as f32 * 0.9999) / extent;
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX));
        let per_unit = Vec3A::select(usable, per_unit, Vec3A::ZERO);
        let lanes = |[x, y, z]: [f32; 3]| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0];
        Self { origin: lanes(centres.min.to_array()), bins_per_unit: lanes(per_unit.to_array()) }
    }

    /// The bin of a centre on each axis, plus [`Grid::TO_BITS`].
    #[inline(always)]
    pub(super) fn bins<S: Simd>(&self, centre: S) -> S {
        let position = (centre - S::load(&self.origin)) * S::load(&self.bins_per_unit);
        (position - S::splat(0.5)).max(S::splat(0.0)) + S::splat(Self::TO_BITS)
    }
}

/// [`SahItem::centre`] of an item in lanes, and its negation in the upper half.
#[inline(always)]
pub(super) fn centre<S: Simd>(item: S) -> S {
    let quarter = item * S::splat(0.25);
    quarter - quarter.swap_halves()
}

struct Plane {
    /// Area times triangles, summed over both sides.
    cost: f32,
    /// The bin right of the plane.
    bin: usize,
}

/// The bins of the three axes.
struct Bins {
    extents: [[Extent; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

/// The cheapest plane with items on both sides, or `None` where the centres coincide or all areas are
/// 0 and tell nothing.
pub(super) fn best_split(
    items: &[SahItem],
    centres: &Bounds,
    scale: AreaScale,
    parts: Parts<'_>,
) -> Option<Split> {
    // Most runs are small, and sweeping all bins would cost them more than filling them. (With all 16
    // for every run: 25 % slower, quality 0.3 % better.)
    let count = (4 + items.len() / 16).min(MAX_BINS);
    let grid = Grid::new(centres, count);
    let mut bins = Bins::EMPTY;
    bins.fill(items, &grid, parts);
    let usable = (0..3).filter(|&axis| grid.bins_per_unit[axis] > 0.0);
    let planes = usable.map(|axis| (axis, bins.sweep(axis, count, scale)));
    let (axis, plane) = planes.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
    if !(plane.cost > 0.0 && plane.cost < f32::INFINITY) {
        return None;
    }
    let union = |bins: &[Extent]| bins.iter().fold(Extent::EMPTY, |a, b| a.union(b)).bounds();
    let (left, right) = bins.extents[axis][..count].split_at(plane.bin);
    Some(Split::new(axis, grid, plane.bin, [union(left), union(right)]))
}

impl Bins {
    const EMPTY: Self =
        Self { extents: [[Extent::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    fn fill(&mut self, items: &[SahItem], grid: &Grid, parts: Parts<'_>) {
        if items.len() <= PART {
            return widest(Fill { bins: self, items, grid });
        }
        let (left, right) = items.split_at(items.len() / 2);
        let mut other = Self::EMPTY;
        parts.both(items.len(), || self.fill(left, grid, parts), || other.fill(right, grid, parts));
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                self.extents[axis][bin] = self.extents[axis][bin].union(&other.extents[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// The cheapest plane of one axis with items on both sides.
    fn sweep(&self, axis: usize, bins: usize, scale: AreaScale) -> Plane {
        let (extents, counts) = (&self.extents[axis], &self.counts[axis]);
        let mut right_costs = [0.0; MAX_BINS];
        let (mut side, mut items) = (Extent::EMPTY, 0);
        for bin in (1..bins).rev() {
            side = side.union(&extents[bin]);
            items += counts[bin];
            right_costs[bin] = scale.half_area(&side.bounds()) * items as f32;
        }
        let all = items + counts[0];
        let mut best = Plane { cost: f32::INFINITY, bin: 0 };
        (side, items) = (Extent::EMPTY, 0);
        for bin in 1..bins {
            side = side.union(&extents[bin - 1]);
            items += counts[bin - 1];
            let cost = scale.half_area(&side.bounds()) * items as f32 + right_costs[bin];
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
        for item in items {
            let extent = S::load(&item.0.0);
            let mut at = [0.0; LANES];
            grid.bins(centre(extent)).store(&mut at);
            for (axis, at) in at[..3].iter().enumerate() {
                let bin = at.to_bits() as usize % MAX_BINS;
                let grown = &mut bins.extents[axis][bin].0;
                S::load(grown).min(extent).store(grown);
                bins.counts[axis][bin] += 1;
            }
        }
    }
}
