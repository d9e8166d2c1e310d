//! Reordering a run of items into two.

use super::bins::{Grid, centre};
use super::item::{Extent, Run, SahItem};
use super::parts::{PART, Parts};
use crate::aabb::Bounds;
use crate::simd::{Eight, LANES, Task, widest};

/// A plane between two bins.
pub(super) struct Split {
    grid: Grid,
    /// Across the plane.
    pub(super) axis: usize,
    /// The first bin on the right, plus [`Grid::TO_BITS`].
    bin: f32,
    /// The boxes of both sides.
    bounds: [Bounds; 2],
}

/// How many items are on the left, and the centres on both sides.
struct Divided {
    left: usize,
    centres: [Extent; 2],
}

impl Split {
    pub(super) fn new(axis: usize, grid: Grid, bin: usize, bounds: [Bounds; 2]) -> Self {
        Self { grid, axis, bin: bin as f32 + Grid::TO_BITS, bounds }
    }

    /// Moves the items left of the plane to the front.
    pub(super) fn divide(&self, items: &mut [SahItem], parts: Parts<'_>) -> [Run; 2] {
        let Divided { left, centres } = self.divided(items, parts);
        let [left_centres, right_centres] = centres.map(|extent| extent.bounds());
        let [left_bounds, right_bounds] = self.bounds;
        [
            Run { count: left, bounds: left_bounds, centres: left_centres },
            Run { count: items.len() - left, bounds: right_bounds, centres: right_centres },
        ]
    }

    fn divided(&self, items: &mut [SahItem], parts: Parts<'_>) -> Divided {
        let count = items.len();
        if count <= PART {
            return widest(Divide { split: self, items });
        }
        let (front, back) = items.split_at_mut(count / 2);
        let (in_front, in_back) =
            parts.both(count, || self.divided(front, parts), || self.divided(back, parts));
        // Items that are right of the plane in front change places with those left of it at the back.
        let right_in_front = &mut front[in_front.left..];
        let left_at_back = &mut back[..in_back.left];
        let misplaced = right_in_front.len().min(left_at_back.len());
        let kept = left_at_back.len() - misplaced;
        exchange(&mut right_in_front[..misplaced], &mut left_at_back[kept..], parts);
        Divided {
            left: in_front.left + in_back.left,
            centres: [0, 1].map(|side| in_front.centres[side].union(&in_back.centres[side])),
        }
    }
}

fn exchange(a: &mut [SahItem], b: &mut [SahItem], parts: Parts<'_>) {
    let count = a.len();
    if count <= PART {
        return a.swap_with_slice(b);
    }
    let ((a, other_a), (b, other_b)) = (a.split_at_mut(count / 2), b.split_at_mut(count / 2));
    parts.both(count, || exchange(a, b, parts), || exchange(other_a, other_b, parts));
}

struct Divide<'d> {
    split: &'d Split,
    items: &'d mut [SahItem],
}

impl Task for Divide<'_> {
    type Output = Divided;

    /// Every step swaps and grows the centres of both sides, whichever side the item is on: which one
    /// is a coin toss to a branch predictor.
    #[inline(always)]
    fn run<S: Eight>(self) -> Divided {
        let Self { split, items } = self;
        let (bin, none) = (S::splat(split.bin), S::splat(f32::INFINITY));
        let (mut left, mut right) = (none, none);
        let mut middle = 0;
        for i in 0..items.len() {
            let item = items[i];
            let centre = centre(S::load(&item.0.0, 0));
            let mut bins = [0.0; LANES];
            split.grid.bins(centre).store(&mut bins, 0);
            let is_left = S::splat(bins[split.axis % LANES]).lt(bin);
            left = left.min(S::select(&is_left, centre, none));
            right = right.min(S::select(&is_left, none, centre));
            items[i] = items[middle];
            items[middle] = item;
            middle += (S::bits(is_left) & 1) as usize;
        }
        let mut centres = [Extent::EMPTY; 2];
        left.store(&mut centres[0].0, 0);
        right.store(&mut centres[1].0, 0);
        Divided { left: middle, centres }
    }
}

/// Divides the run at `middle` by centre along the longest axis, or as it stands if the centres coincide.
pub(super) fn split_at(run: &mut [SahItem], centres: &Bounds, middle: usize) -> [Run; 2] {
    let extent = (centres.max - centres.min).to_array();
    let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
    if extent[axis] > 0.0 { split_across(axis, run, middle) } else { cut(run, middle) }
}

/// Divides the run at `middle` by centre along an axis.
pub(super) fn split_across(axis: usize, run: &mut [SahItem], middle: usize) -> [Run; 2] {
    let centre = |item: &SahItem| item.centre().to_array()[axis];
    run.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
    cut(run, middle)
}

fn cut(run: &[SahItem], middle: usize) -> [Run; 2] {
    let (left, right) = run.split_at(middle);
    [Run::of(left), Run::of(right)]
}
