//! Where to split a run of items: bins along each axis, and the cheapest plane between two bins.

use super::divide::Split;
use super::item::{Extent, SahItem};
use super::parts::{PART, Parts};
use crate::aabb::Bounds;
use crate::simd::{Eight, LANES, Task, widest};
use glam::Vec3A;

/// Bins per axis of a large run.
///
/// On the dragon (871,414 triangles) 8, 12, 16 and 32 bins give a quality of 17.94, 17.75, 17.65 and
/// 17.56, and 8, 16 and 32 take the same time.
const MAX_BINS: usize = 16;

/// No plane is sought across the shortest axis if the centres extend along it less than this times what
/// they do along the longest.
///
/// Builds take 4 % (dragon) and 6 % (torus) less time, and quality is 0.03 % and 0.07 % worse.
const THIN: f32 = 0.4;

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
    pub(super) fn bins<S: Eight>(&self, centre: S) -> S {
        let position = (centre - S::load(&self.origin, 0)) * S::load(&self.bins_per_unit, 0);
        (position - S::splat(0.5)).max(S::splat(0.0)) + S::splat(Self::TO_BITS)
    }
}

/// [`SahItem::centre`] of an item in lanes, and its negation in the upper half.
#[inline(always)]
pub(super) fn centre<S: Eight>(item: S) -> S {
    let quarter = item * S::splat(0.25);
    quarter - quarter.swap_halves()
}

struct Plane {
    /// Area times triangles, summed over both sides.
    cost: f32,
    /// The bin right of the plane.
    bin: usize,
}

/// The bins along so many axes.
struct Bins<const AXES: usize> {
    extents: [[Extent; MAX_BINS]; AXES],
    counts: [[u32; MAX_BINS]; AXES],
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
    let extent = (centres.max - centres.min).to_array();
    let shorter = |a, b| if extent[b] < extent[a] { b } else { a };
    let shortest = shorter(shorter(0, 1), 2);
    if extent[shortest] < THIN * extent.into_iter().fold(0.0, f32::max) {
        best_across([(shortest + 1) % 3, (shortest + 2) % 3], items, count, grid, scale, parts)
    } else {
        best_across([0, 1, 2], items, count, grid, scale, parts)
    }
}

/// The cheapest plane across some axes.
fn best_across<const AXES: usize>(
    axes: [usize; AXES],
    items: &[SahItem],
    count: usize,
    grid: Grid,
    scale: AreaScale,
    parts: Parts<'_>,
) -> Option<Split> {
    let mut bins = Bins::<AXES>::EMPTY;
    bins.fill(items, &grid, axes, parts);
    let usable = (0..AXES).filter(|&row| grid.bins_per_unit[axes[row]] > 0.0);
    let planes = usable.map(|row| (row, bins.sweep(row, count, scale)));
    let (row, plane) = planes.min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
    if !(plane.cost > 0.0 && plane.cost < f32::INFINITY) {
        return None;
    }
    let union = |bins: &[Extent]| bins.iter().fold(Extent::EMPTY, |a, b| a.union(b)).bounds();
    let (left, right) = bins.extents[row][..count].split_at(plane.bin);
    Some(Split::new(axes[row], grid, plane.bin, [union(left), union(right)]))
}

impl<const AXES: usize> Bins<AXES> {
    const EMPTY: Self =
        Self { extents: [[Extent::EMPTY; MAX_BINS]; AXES], counts: [[0; MAX_BINS]; AXES] };

    fn fill(&mut self, items: &[SahItem], grid: &Grid, axes: [usize; AXES], parts: Parts<'_>) {
        if items.len() <= PART {
            return widest(Fill { bins: self, items, grid, axes });
        }
        let (left, right) = items.split_at(items.len() / 2);
        let mut other = Self::EMPTY;
        parts.both(
            items.len(),
            || self.fill(left, grid, axes, parts),
            || other.fill(right, grid, axes, parts),
        );
        for row in 0..AXES {
            for bin in 0..MAX_BINS {
                self.extents[row][bin] = self.extents[row][bin].union(&other.extents[row][bin]);
                self.counts[row][bin] += other.counts[row][bin];
            }
        }
    }

    /// The cheapest plane of one axis with items on both sides.
    fn sweep(&self, row: usize, bins: usize, scale: AreaScale) -> Plane {
        let (extents, counts) = (&self.extents[row], &self.counts[row]);
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

struct Fill<'f, const AXES: usize> {
    bins: &'f mut Bins<AXES>,
    items: &'f [SahItem],
    grid: &'f Grid,
    axes: [usize; AXES],
}

impl<const AXES: usize> Task for Fill<'_, AXES> {
    type Output = ();

    #[inline(always)]
    fn run<S: Eight>(self) {
        let Self { bins, items, grid, axes } = self;
        for item in items {
            let extent = S::load(&item.0.0, 0);
            let mut at = [0.0; LANES];
            grid.bins(centre(extent)).store(&mut at, 0);
            for (row, axis) in axes.into_iter().enumerate() {
                // All three are in order: lanes known when compiling need not go through memory.
                let axis = if AXES == 3 { row } else { axis };
                let bin = at[axis % LANES].to_bits() as usize % MAX_BINS;
                let grown = &mut bins.extents[row][bin].0;
                S::load(grown, 0).min(extent).store(grown, 0);
                bins.counts[row][bin] += 1;
            }
        }
    }
}
