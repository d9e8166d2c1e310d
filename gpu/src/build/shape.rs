//! The shape of a balanced tree.
//!
//! It follows from the number of triangles alone, so that the host knows it without asking the device:
//! how deep the tree is, where its seeds are, and in what order it is built and its boxes are fitted.

use crate::layout::Build;
use crate::model::MOST_SEEDS;
use bytemuck::Zeroable;
use pfront_core::bvh::BuildOptions;
use pfront_core::bvh::MAX_LEAF_SIZE;
use pfront_shaders::constants::{BLOCK, CUT_BITS, DIGITS, JOB};
use std::ops::Range;

/// The most levels that a sort divides nodes by, all across one axis. Fewer make better trees and more
/// sorts.
const ROUND_LEVELS: u32 = 3;

/// Levels that a stage fits: a job has at most [`JOB`] nodes of the lowest.
const STAGE_LEVELS: u32 = JOB.ilog2() + 1;

/// 2^depth leaves, which hold the same number of triangles or one more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Balanced {
    pub(crate) triangles: u32,
    pub(crate) depth: u32,
}

impl Balanced {
    /// The smallest tree whose leaves hold `options.leaf_size` triangles at most; 1 counts as 2, or there
    /// would be empty leaves. `None` if there are no triangles.
    pub(crate) fn new(triangles: u32, options: BuildOptions) -> Option<Self> {
        let most = options.leaf_size.clamp(2, MAX_LEAF_SIZE);
        let leaves = triangles.div_ceil(most).next_power_of_two();
        (triangles != 0).then_some(Self { triangles, depth: leaves.ilog2() })
    }

    /// The most triangles of a leaf.
    pub(crate) fn leaf_size(self) -> u32 {
        self.triangles.div_ceil(1 << self.depth)
    }

    /// How many nodes there are, with the unused one. A lone root has none beside it.
    pub(crate) fn nodes(self) -> u32 {
        if self.depth == 0 { 1 } else { 2 << self.depth }
    }

    /// The level of the seeds, and which nodes they are.
    pub(crate) fn seeds(self) -> (u32, Range<u32>) {
        let level = self.depth.min(MOST_SEEDS.ilog2());
        (level, if level == 0 { 0..1 } else { 1 << level..2 << level })
    }

    /// The levels that workgroups arrange, each job in [`BLOCK`] slots.
    pub(crate) fn blocks(self) -> Build {
        let levels = (BLOCK / self.leaf_size()).ilog2().min(self.depth);
        self.levels(self.depth - levels..self.depth + 1)
    }

    /// The levels above, whose triangles are sorted: some levels at a time, from the root down.
    pub(crate) fn rounds(self) -> Vec<Build> {
        let above = self.blocks().top;
        even(above, ROUND_LEVELS).map(|levels| self.levels(levels)).collect()
    }

    /// How boxes are fitted: some levels at a time, from the leaves up.
    pub(crate) fn stages(self) -> Vec<Build> {
        let stages = even(self.depth + 1, STAGE_LEVELS).map(|levels| self.levels(levels));
        stages.rev().collect()
    }

    /// Passes of a build: a round measures nodes and sorts by digits of 8 bits, three passes each.
    pub(crate) fn passes(self) -> u32 {
        let round = |round: Build| 1 + 3 * (CUT_BITS + round.top).div_ceil(DIGITS.ilog2());
        let rounds: u32 = self.rounds().into_iter().map(round).sum();
        rounds + 1 + self.stages().len() as u32
    }

    fn levels(self, levels: Range<u32>) -> Build {
        let Self { triangles, depth } = self;
        let (bottom, top) = (levels.end - 1, levels.start);
        Build { triangles, depth, bottom, top, ..Build::zeroed() }
    }
}

/// Divides so many levels evenly into as few ranges of at most so many as can be.
fn even(levels: u32, most: u32) -> impl DoubleEndedIterator<Item = Range<u32>> {
    let parts = levels.div_ceil(most);
    (0..parts).map(move |part| levels * part / parts..levels * (part + 1) / parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trees of all sizes.
    fn trees() -> impl Iterator<Item = (u32, Balanced)> {
        let triangles = (1..2000).chain([1 << 20, 3 << 22, (1 << 28) - 1]);
        let tree = |n, leaf_size| {
            Balanced::new(n, BuildOptions { leaf_size, ..BuildOptions::default() }).unwrap()
        };
        triangles.flat_map(move |n| (0..12).map(move |leaf_size| (leaf_size, tree(n, leaf_size))))
    }

    #[test]
    fn leaves_are_never_empty_nor_too_large() {
        for (leaf_size, tree) in trees() {
            let most = leaf_size.clamp(2, MAX_LEAF_SIZE);
            assert!(tree.triangles >> tree.depth >= 1 && tree.leaf_size() <= most);
            assert!(tree.depth == 0 || tree.triangles.div_ceil(1 << (tree.depth - 1)) > most);
        }
        assert_eq!(Balanced::new(0, BuildOptions::default()), None);
    }

    #[test]
    fn every_level_is_divided_once_from_the_root_down() {
        for (_, tree) in trees() {
            let mut next = 0;
            for round in tree.rounds() {
                assert!(round.top == next && round.bottom - round.top < ROUND_LEVELS);
                assert!(round.top + CUT_BITS <= u32::BITS, "a key holds the node");
                next = round.bottom + 1;
            }
            let blocks = tree.blocks();
            assert!(blocks.top == next && blocks.bottom == tree.depth);
            assert!(tree.leaf_size() <= BLOCK >> (blocks.bottom - blocks.top));
        }
    }

    #[test]
    fn every_level_is_fitted_once_from_the_leaves_up() {
        for (_, tree) in trees() {
            let stages = tree.stages();
            let mut left = tree.depth + 1;
            for stage in &stages {
                assert!(stage.bottom + 1 == left && left - stage.top <= STAGE_LEVELS);
                left = stage.top;
            }
            assert!(left == 0 && stages.len() <= 3);
        }
    }

    #[test]
    fn seeds_are_a_whole_level() {
        let tree = |depth: u32| Balanced { triangles: 4 << depth, depth };
        assert_eq!(tree(0).seeds(), (0, 0..1));
        assert_eq!(tree(1).seeds(), (1, 2..4));
        assert_eq!(tree(20).seeds(), (7, 128..256));
    }
}
