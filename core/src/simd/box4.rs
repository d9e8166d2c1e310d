//! Four boxes.

use crate::Node;
use crate::aabb::Bounds;
use glam::{Vec3A, Vec4};

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

    /// Each of them after the other.
    #[inline]
    pub(crate) fn map(&self, change: impl Fn(&Bounds) -> Bounds) -> Self {
        let [mut min, mut max] = [self.min, self.max].map(|v| v.map(|v| v.to_array()));
        for lane in 0..4 {
            let corner = |of: &[[f32; 4]; 3]| Vec3A::new(of[0][lane], of[1][lane], of[2][lane]);
            let changed = change(&Bounds { min: corner(&min), max: corner(&max) });
            let (low, high) = (changed.min.to_array(), changed.max.to_array());
            for k in 0..3 {
                (min[k][lane], max[k][lane]) = (low[k], high[k]);
            }
        }
        Self { min: min.map(Vec4::from_array), max: max.map(Vec4::from_array) }
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
