//! Fronts that go to and fro while nothing moves: noticed, and brought to rest.
//!
//! What a node costs depends a little on whether it is split, so that the next front may undo what the last one
//! did, for ever (the "oscillation" of the paper's section 2.3). It shows as a size that comes back after some
//! frames but not after one; periods of 2, 3 and 6 were seen. Each time it does, fronts get more inertia, up to
//! where hardly any scene swings; in motion, where sizes seldom come back, they lose it again, as it leaves
//! them with more nodes than they need.

use pfront_core::front::HOLD;

/// How much more a front holds on at each level.
const STEP: f32 = 0.8;
/// The last level: 0.37.
const MOST: u32 = 4;
/// The longest period that is noticed.
const PERIOD: usize = 6;
/// After so many new sizes in a row a scene is in motion.
const MOVING: u32 = 8;

/// The sizes of the last fronts, and what is made of them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Damping {
    /// The last one first.
    sizes: [usize; PERIOD],
    level: u32,
    /// New sizes in a row.
    new: u32,
}

impl Damping {
    /// For [`pfront_core::front::Past::with_hold`].
    pub(crate) fn hold(self) -> f32 {
        HOLD * STEP.powi(self.level as i32)
    }

    /// Takes note of a front of so many nodes; `coherent` if it was derived from the last one.
    pub(crate) fn note(&mut self, size: usize, coherent: bool) {
        let (last, is_known) = (self.sizes[0], self.sizes.contains(&size));
        self.sizes.rotate_right(1);
        self.sizes[0] = size;
        self.new = if is_known { 0 } else { (self.new + 1).min(MOVING) };
        if !coherent || self.new >= MOVING {
            self.level = 0;
        } else if is_known && size != last {
            self.level = (self.level + 1).min(MOST);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(sizes: impl IntoIterator<Item = usize>) -> Damping {
        let mut damping = Damping::default();
        sizes.into_iter().for_each(|size| damping.note(size, true));
        damping
    }

    #[test]
    fn a_swing_is_damped_and_motion_forgets_it() {
        assert_eq!(after([9; 20]).level, 0);
        assert_eq!(after(0..20).level, 0);
        assert_eq!(after([7, 9, 7]).level, 1);
        assert_eq!(after([7, 9].repeat(20)).level, MOST);
        assert_eq!(after([7, 9, 4, 8, 5, 6].repeat(20)).level, MOST);
        // At rest it stays as it is.
        assert_eq!(after([7, 9, 7, 9].into_iter().chain([8; 50])).level, 2);
        assert_eq!(after([7, 9, 7, 9].into_iter().chain(20..40)).level, 0);
        let mut jumped = after([7, 9, 7]);
        jumped.note(9, false);
        assert_eq!(jumped.hold(), HOLD);
    }
}
