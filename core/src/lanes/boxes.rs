//! Four boxes.

use crate::Node;
use glam::Vec4;

/// Four closed boxes. One with a bound that is no number overlaps nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boxes {
    pub(crate) min: [Vec4; 3],
    pub(crate) max: [Vec4; 3],
}

impl Boxes {
    #[inline(always)]
    pub(crate) fn of_nodes(n: [&Node; 4]) -> Self {
        let low = |k: usize| Vec4::new(n[0].min[k], n[1].min[k], n[2].min[k], n[3].min[k]);
        let high = |k: usize| Vec4::new(n[0].max[k], n[1].max[k], n[2].max[k], n[3].max[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// One of them, four times.
    #[inline(always)]
    pub(crate) fn splat(&self, lane: usize) -> Self {
        let one = |v: &Vec4| Vec4::splat(v.to_array()[lane]);
        let all = |v: &[Vec4; 3]| [one(&v[0]), one(&v[1]), one(&v[2])];
        Self { min: all(&self.min), max: all(&self.max) }
    }

    /// A bit for each box that overlaps the other in its lane.
    #[inline(always)]
    pub(crate) fn overlapping(&self, other: &Self) -> u32 {
        let along = |k: usize| self.min[k].cmple(other.max[k]) & other.min[k].cmple(self.max[k]);
        (along(0) & along(1) & along(2)).bitmask()
    }
}
