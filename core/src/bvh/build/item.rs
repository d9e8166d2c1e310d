//! What the SAH build sorts: triangles with their boxes, made for vector registers.

use super::parts::{PART, Parts};
use crate::aabb::Bounds;
use crate::simd::LANES;
use crate::{Aabb, Mesh};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3A, Vec4};

/// A box as eight floats: the smallest corner and the largest one negated, so that a union is one
/// minimum. The fourth and the eighth belong to whoever made it.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct Extent(pub(super) [f32; LANES]);

impl Extent {
    pub(super) const EMPTY: Self = Self([f32::INFINITY; LANES]);

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        let [[a, b], [c, d]]: [[Vec4; 2]; 2] = [self.0, other.0].map(bytemuck::must_cast);
        Self(bytemuck::must_cast([a.min(c), b.min(d)]))
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        let [min, max]: [Vec4; 2] = bytemuck::must_cast(self.0);
        Bounds { min: Vec3A::from_vec4(min), max: -Vec3A::from_vec4(max) }
    }
}

/// Scratch of [`sah()`](super::sah()): a triangle and its box.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SahItem(pub(super) Extent);

impl SahItem {
    /// The spare floats take part in all arithmetic, where an index would be a subnormal number and
    /// slow everything down tenfold. So each holds half of it, as the fraction of a number from 1 to 2.
    fn new(triangle: u32, aabb: &Aabb) -> Self {
        let half = |bits: u32| f32::from_bits(1_f32.to_bits() | bits & 0xffff);
        let ([a, b, c], [d, e, f]) = (aabb.min, aabb.max.map(|x| -x));
        Self(Extent([a, b, c, half(triangle), d, e, f, half(triangle >> 16)]))
    }

    pub(super) fn triangle(&self) -> u32 {
        let [low, high] = [3, 7].map(|lane| self.0.0[lane].to_bits() & 0xffff);
        high << 16 | low
    }

    /// Half the centre of the box, so that neither it nor the difference of two can overflow.
    pub(super) fn centre(&self) -> Vec3A {
        let Bounds { min, max } = self.0.bounds();
        min * 0.25 + max * 0.25
    }
}

/// What a build needs to know of a run of items.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub(super) count: usize,
    pub(super) bounds: Bounds,
    /// The box of the items' centres.
    pub(super) centres: Bounds,
}

impl Run {
    pub(super) fn of(items: &[SahItem]) -> Self {
        let (mut bounds, mut centres) = (Bounds::EMPTY, Bounds::EMPTY);
        for item in items {
            bounds = bounds.union(&item.0.bounds());
            centres = centres.with(item.centre());
        }
        Self { count: items.len(), bounds, centres }
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            bounds: self.bounds.union(&other.bounds),
            centres: self.centres.union(&other.centres),
        }
    }
}

/// Makes items of the triangles from `first` on.
pub(super) fn load(mesh: Mesh<'_>, first: usize, items: &mut [SahItem], parts: Parts<'_>) -> Run {
    let count = items.len();
    if count <= PART {
        for (triangle, item) in (first as u32..).zip(items.iter_mut()) {
            *item = SahItem::new(triangle, &Aabb::of(&mesh.triangle(triangle)));
        }
        return Run::of(items);
    }
    let (left, right) = items.split_at_mut(count / 2);
    let (left, right) = parts.both(
        count,
        || load(mesh, first, left, parts),
        || load(mesh, first + count / 2, right, parts),
    );
    left.and(&right)
}
