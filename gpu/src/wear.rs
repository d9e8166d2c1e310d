//! When a tree that is refitted is worth a new one.
//!
//! A refit keeps the tree, and boxes grow as the mesh leaves the shape that it was built for. How much a query suffers shows in
//! its box tests. The tests beyond the fewest since the tree was built are what a new tree may save, so that a rebuild is a ski
//! rental: it is due as soon as their sum reaches its cost, and all frames together take at most twice what they would at best.
//! More tests may have another reason, a pose or folds. A rebuild after which they are not halved was of no use, and the next
//! one waits for twice as much.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The box tests of queries about a tree.
#[derive(Debug, Default)]
pub(crate) struct Wear(Mutex<Tests>);

#[derive(Debug, Default)]
struct Tests {
    /// The fewest of a query since the tree was built.
    fewest: Option<u64>,
    /// The tests beyond these, of all queries since.
    excess: u64,
    last: u64,
    /// The tests of the last query before the last rebuild.
    before: Option<u64>,
    /// Rebuilds in turn that were of no use.
    useless: u32,
}

impl Wear {
    /// Takes note of a query.
    pub(crate) fn add(&self, tests: u64) {
        let mut own = self.lock();
        if let Some(before) = own.before.take() {
            own.useless = if tests <= before / 2 { 0 } else { own.useless.saturating_add(1) };
        }
        let fewest = own.fewest.map_or(tests, |fewest| fewest.min(tests));
        own.excess = own.excess.saturating_add(tests - fewest);
        (own.fewest, own.last) = (Some(fewest), tests);
    }

    /// Whether a rebuild is due that takes as long as so many tests.
    pub(crate) fn is_due(&self, price: u64) -> bool {
        let own = self.lock();
        own.excess > 0 && own.excess >= price.saturating_mul(1 << own.useless.min(32))
    }

    /// Takes note of a rebuild.
    pub(crate) fn rebuilt(&self) {
        let mut own = self.lock();
        let is_known = own.fewest.is_some();
        (own.before, own.fewest, own.excess) = (is_known.then_some(own.last), None, 0);
    }

    /// Nothing panics under this lock.
    fn lock(&self) -> MutexGuard<'_, Tests> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Takes note of a query about two trees or one.
pub(crate) fn add([a, b]: &[Arc<Wear>; 2], tests: u64) {
    a.add(tests);
    if !Arc::ptr_eq(a, b) {
        b.add(tests);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The frames before which a tree is built anew that costs so much. A query takes so many tests with the first tree in the
    /// first frame, so many with it in the others, and as few as in the first with any new one.
    fn rebuilds(price: u64, new: u64, worn: u64) -> Vec<usize> {
        let (wear, mut rebuilds) = (Wear::default(), Vec::new());
        for frame in 0..1_000 {
            if wear.is_due(price) {
                wear.rebuilt();
                rebuilds.push(frame);
            }
            let is_new = frame == 0 || !rebuilds.is_empty();
            wear.add(if is_new { new } else { worn });
        }
        rebuilds
    }

    #[test]
    fn a_tree_that_does_not_wear_is_never_rebuilt() {
        assert_eq!(rebuilds(1, 100, 100), []);
    }

    #[test]
    fn a_worn_tree_is_rebuilt_once_that_has_paid() {
        assert_eq!(rebuilds(900, 100, 600), [3]);
        assert_eq!(rebuilds(100, 100, 600), [2]);
        assert_eq!(rebuilds(100_000, 100, 101), []);
    }

    #[test]
    fn rebuilds_of_no_use_become_rare() {
        let wear = Wear::default();
        let mut rebuilt = 0;
        for frame in 0..10_000_u64 {
            if wear.is_due(500) {
                wear.rebuilt();
                rebuilt += 1;
            }
            // Tests that come and go with the pose, whatever the tree.
            wear.add(100 + 30 * (frame % 3));
        }
        assert!((1..=12).contains(&rebuilt), "{rebuilt}");
    }
}
