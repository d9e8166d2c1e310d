//! Reordering a run of items into two.

use super::bins::Grid;
use super::item::{LaneBox, SahItem, centre};
use crate::aabb::Bounds;
use crate::parallel::{GRAIN, Join, both, halves};
use crate::simd::{LANES, Simd, Task, widest};

/// A plane between two bins.
pub(super) struct Split {
    grid: Grid,
    /// Across the plane.
    axis: usize,
    /// The last bin on the left, plus [`Grid::TO_BITS`].
    last_left: f32,
}

/// How many items are on the left, and the boxes of the centres on both sides.
pub(super) struct Divided {
    pub(super) left: usize,
    pub(super) centres: [LaneBox; 2],
}

impl Split {
    pub(super) fn new(axis: usize, grid: Grid, bin: usize) -> Self {
        Self { grid, axis, last_left: bin as f32 - 1.0 + Grid::TO_BITS }
    }

    /// Moves the items left of the plane to the front.
    pub(super) fn divide(&self, items: &mut [SahItem], join: Option<&Join<'_>>) -> Divided {
        if items.len() <= GRAIN {
            return widest(Divide { split: self, items });
        }
        let (front, back) = items.split_at_mut(items.len() / 2);
        let (in_front, in_back) =
            both(join, || self.divide(front, join), || self.divide(back, join));
        // Items that are right of the plane in front change places with those left of it at the back.
        let right_in_front = &mut front[in_front.left..];
        let left_at_back = &mut back[..in_back.left];
        let misplaced = right_in_front.len().min(left_at_back.len());
        let kept = left_at_back.len() - misplaced;
        let (a, b) = (&mut right_in_front[..misplaced], &mut left_at_back[kept..]);
        halves(join, a, b, &|a, b| a.swap_with_slice(b), &|(), ()| ());
        Divided {
            left: in_front.left + in_back.left,
            centres: [0, 1].map(|side| in_front.centres[side].union(&in_back.centres[side])),
        }
    }
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
    fn run<S: Simd>(self) -> Divided {
        let Self { split, items } = self;
        let (last_left, none) = (S::splat(split.last_left), S::splat(f32::INFINITY));
        let (mut left, mut right) = (none, none);
        let mut middle = 0;
        for i in 0..items.len() {
            let item = items[i];
            let centre = centre(item.load::<S>());
            let mut bins = [0.0; LANES];
            split.grid.bins(centre).store(&mut bins, 0);
            let is_left = S::splat(bins[split.axis % LANES]).le(last_left);
            left = left.min(S::select(&is_left, centre, none));
            right = right.min(S::select(&is_left, none, centre));
            items[i] = items[middle];
            items[middle] = item;
            middle += (S::bits(is_left) & 1) as usize;
        }
        let mut centres = [LaneBox::EMPTY; 2];
        left.store(&mut centres[0].0, 0);
        right.store(&mut centres[1].0, 0);
        Divided { left: middle, centres }
    }
}

/// Divides the run in the middle by centre along the longest axis, or as it stands if the centres coincide.
pub(super) fn halve(items: &mut [SahItem], centres: &Bounds) -> Divided {
    let extent = centres.max - centres.min;
    let axis = extent.max_position();
    let left = items.len() / 2;
    if extent[axis] > 0.0 {
        items.select_nth_unstable_by(left, |a, b| a.centre(axis).total_cmp(&b.centre(axis)));
    }
    let (front, back) = items.split_at(left);
    Divided { left, centres: [front, back].map(|items| widest(Centres { items })) }
}

/// The box of the centres of some items.
pub(super) struct Centres<'c> {
    pub(super) items: &'c [SahItem],
}

impl Task for Centres<'_> {
    type Output = LaneBox;

    #[inline(always)]
    fn run<S: Simd>(self) -> LaneBox {
        let all = self
            .items
            .iter()
            .fold(S::splat(f32::INFINITY), |all, item| all.min(centre(item.load::<S>())));
        let mut centres = LaneBox::EMPTY;
        all.store(&mut centres.0, 0);
        centres
    }
}
