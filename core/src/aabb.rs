//! Axis-aligned bounding boxes.

use glam::Vec3A;

/// A closed axis-aligned box. `min > max` on every axis is the empty box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// Smallest corner.
    pub min: [f32; 3],
    /// Largest corner.
    pub max: [f32; 3],
}

impl Aabb {
    /// The box that contains nothing; its union with another box is the other.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Returns the tight box of some points. Minima are not rounded, so it needs no padding.
    #[inline]
    #[must_use]
    pub fn of(points: &[[f32; 3]]) -> Self {
        let point = |b: Self, p: &[f32; 3]| b.union(&Self { min: *p, max: *p });
        // Four points at a time compile to vector instructions.
        let (fours, rest) = points.as_chunks::<4>();
        let mut lanes = [Self::EMPTY; 4];
        for four in fours {
            lanes = core::array::from_fn(|lane| point(lanes[lane], &four[lane]));
        }
        let all = if fours.is_empty() {
            Self::EMPTY
        } else {
            lanes.iter().fold(Self::EMPTY, |b, lane| b.union(lane))
        };
        rest.iter().fold(all, point)
    }

    /// Returns the smallest box that contains both.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let mut out = *self;
        for k in 0..3 {
            out.min[k] = if other.min[k] < out.min[k] { other.min[k] } else { out.min[k] };
            out.max[k] = if other.max[k] > out.max[k] { other.max[k] } else { out.max[k] };
        }
        out
    }

    /// Whether two closed boxes share a point; touching counts.
    #[inline]
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }
}

/// An [`Aabb`] in vector registers, for the inner loops.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) min: Vec3A,
    pub(crate) max: Vec3A,
}

impl From<Bounds> for Aabb {
    fn from(bounds: Bounds) -> Self {
        Self { min: bounds.min.to_array(), max: bounds.max.to_array() }
    }
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline]
    pub(crate) fn new(aabb: &Aabb) -> Self {
        Self { min: Vec3A::from_array(aabb.min), max: Vec3A::from_array(aabb.max) }
    }

    #[inline]
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box of one point.
    #[inline]
    pub(crate) fn of(point: Vec3A) -> Self {
        Self { min: point, max: point }
    }

    /// Half the centre, so that neither it nor the difference of two can overflow.
    #[inline]
    pub(crate) fn half_centre(&self) -> Vec3A {
        self.min * 0.25 + self.max * 0.25
    }

    #[inline]
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (self.min.cmple(other.max) & other.min.cmple(self.max)).all()
    }

    /// Half the surface area, by which the surface area heuristic weighs a box; 0 for the empty box. The range of f64
    /// holds that of every finite box, but an edge longer than [`f32::MAX`] counts as that long.
    #[inline]
    pub(crate) fn half_area(&self) -> f64 {
        let edges = (self.max - self.min).max(Vec3A::ZERO).min(Vec3A::splat(f32::MAX));
        let [x, y, z] = edges.to_array().map(f64::from);
        x * (y + z) + y * z
    }
}
