//! Four boxes side by side.

use glam::{Mat4, Vec4};

/// Four closed boxes by coordinates. A box with a NaN bound overlaps nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box4 {
    pub(crate) min: [Vec4; 3],
    pub(crate) max: [Vec4; 3],
}

impl Box4 {
    /// The boxes whose smallest and largest corners these are, each with a word of something else.
    #[inline(always)]
    pub(crate) fn transposed(boxes: [[Vec4; 2]; 4]) -> Self {
        let corner = |which: usize| {
            let [a, b, c, d] = boxes.map(|corners| corners[which]);
            let columns = Mat4::from_cols(a, b, c, d).transpose();
            [columns.x_axis, columns.y_axis, columns.z_axis]
        };
        Self { min: corner(0), max: corner(1) }
    }

    /// The box in `lane`, four times.
    #[inline(always)]
    pub(crate) fn splat(&self, lane: usize) -> Self {
        let one = |v: &Vec4| Vec4::splat(v.to_array()[lane % 4]);
        let all = |v: &[Vec4; 3]| [one(&v[0]), one(&v[1]), one(&v[2])];
        Self { min: all(&self.min), max: all(&self.max) }
    }

    /// Lanes in which the boxes overlap, as bits.
    #[inline(always)]
    pub(crate) fn overlapping(&self, other: &Self) -> u32 {
        let along = |k: usize| self.min[k].cmple(other.max[k]) & other.min[k].cmple(self.max[k]);
        (along(0) & along(1) & along(2)).bitmask()
    }

    /// The squares of the distances of the boxes; not a number, or 0, where bounds are not numbers.
    #[cfg(feature = "within")]
    #[inline(always)]
    pub(crate) fn squared_distances(&self, other: &Self) -> Vec4 {
        let along = |k: usize| {
            let gap = (self.min[k] - other.max[k]).max(other.min[k] - self.max[k]);
            let gap = gap.max(Vec4::ZERO);
            gap * gap
        };
        along(0) + along(1) + along(2)
    }
}
