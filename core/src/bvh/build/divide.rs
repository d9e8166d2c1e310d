//! Reordering a run of items into two.

use super::bins::Split;
use super::item::bounds;
use crate::Node;
use crate::aabb::Bounds;
use crate::parallel::{GRAIN, Join, both, halves};

/// How many items are on the left, and the boxes of the centres on both sides.
pub(super) struct Divided {
    pub(super) left: usize,
    pub(super) centres: [Bounds; 2],
}

impl Split {
    /// Moves the items left of the plane to the front.
    pub(super) fn divide(&self, items: &mut [Node], join: Option<&Join<'_>>) -> Divided {
        if items.len() <= GRAIN {
            return self.sort(items);
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

    /// Every step swaps, whichever side the item is on: which one is a coin toss to a branch predictor.
    fn sort(&self, items: &mut [Node]) -> Divided {
        let mut centres = [Bounds::EMPTY; 2];
        let mut left = 0;
        for i in 0..items.len() {
            let item = items[i];
            let centre = bounds(&item).half_centre();
            let side = usize::from(self.is_right(centre));
            centres[side] = centres[side].union(&Bounds::of(centre));
            items[i] = items[left];
            items[left] = item;
            left += 1 - side;
        }
        Divided { left, centres }
    }
}

/// Divides the run in the middle by centre along the longest axis, or as it stands if the centres coincide.
pub(super) fn halve(items: &mut [Node], all: &Bounds) -> Divided {
    let extent = all.max - all.min;
    let axis = extent.max_position();
    let left = items.len() / 2;
    if extent[axis] > 0.0 {
        let centre = |item: &Node| bounds(item).half_centre()[axis];
        items.select_nth_unstable_by(left, |a, b| centre(a).total_cmp(&centre(b)));
    }
    let (front, back) = items.split_at(left);
    Divided { left, centres: [front, back].map(centres) }
}

/// The box of the centres of some items.
pub(super) fn centres(items: &[Node]) -> Bounds {
    let centres = items.iter().map(|item| Bounds::of(bounds(item).half_centre()));
    centres.fold(Bounds::EMPTY, |all, centre| all.union(&centre))
}
