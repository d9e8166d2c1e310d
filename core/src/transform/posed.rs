//! Boxes and corners in a pose, and how far rounding may take one from the other.

use super::Placement;
use crate::Pose;
use crate::aabb::Bounds;
use crate::simd::{Boxes, Simd, VECTORS};
use glam::{DMat3, DVec3, Vec3A, Vec4};

/// A pose by columns, with what box transformation needs beside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posed {
    columns: [Vec3A; 3],
    magnitudes: [Vec3A; 3],
    translation: Vec3A,
    /// Padding that the translation alone asks for.
    slack: Vec3A,
}

/// See [`Posed::bounds`].
const PADDING: f32 = Pose::ROUNDING;

/// 2^-147: four times the smallest subnormal number.
const SUBNORMAL_SLACK: f32 = f32::from_bits(4);

impl Posed {
    pub(crate) fn new(pose: &Pose) -> Self {
        let [x, y, z] = pose.rows;
        let columns = [
            Vec3A::new(x[0], y[0], z[0]),
            Vec3A::new(x[1], y[1], z[1]),
            Vec3A::new(x[2], y[2], z[2]),
        ];
        let translation = Vec3A::new(x[3], y[3], z[3]);
        Self {
            columns,
            magnitudes: columns.map(Vec3A::abs),
            translation,
            slack: translation.abs() * PADDING + Vec3A::splat(f32::MIN_POSITIVE),
        }
    }
}

impl Posed {
    /// How far from the origin posed points of some bounds get, about.
    fn reach(&self, bounds: &Bounds) -> DVec3 {
        let extent = farthest(bounds);
        let [x, y, z] = self.magnitudes.map(|column| column.as_dvec3());
        x * extent.x + y * extent.y + z * extent.z + self.translation.abs().as_dvec3()
    }

    /// This pose as seen from a mesh in another one: what it takes boxes to overlaps each box of that
    /// mesh, as it stands in its own frame, with which it has posed points in common. `None` if the other
    /// pose is far from rigid, or this one enormous beside it.
    ///
    /// A point common to both as they are posed in f32 is A(x) + d = B(y) + e for points x and y of the
    /// boxes, with d and e at most 6u of what the poses reach. So x = A⁻¹(B(y)) + A⁻¹(e − d) without
    /// translation: a box of A⁻¹·B, padded by |A⁻¹| times 16u of both reaches, contains x. What is left
    /// of these 16u is far more than the f64 roundings of A⁻¹ and the products with it. Entries of A⁻¹·B
    /// that are subnormal in f32 lose half the smallest number each, and so less than that a coordinate.
    pub(crate) fn seen_from(&self, own: &Bounds, from: &Self, of: &Bounds) -> Option<Self> {
        const RIGID: f64 = 2.0;
        const LIMIT: f64 = 1e30;
        let matrix = |p: &Self| {
            let [x, y, z] = p.columns.map(|column| column.as_dvec3());
            DMat3::from_cols(x, y, z)
        };
        let turn = matrix(from);
        let back = turn.try_inverse()?;
        let entries = |m: &DMat3, limit: f64| m.to_cols_array().iter().all(|x| x.abs() <= limit);
        if !entries(&turn, RIGID) || !entries(&back, RIGID) {
            return None;
        }
        let seen = back * matrix(self);
        let offset = back * (self.translation.as_dvec3() - from.translation.as_dvec3());
        let doubt = back.abs() * (self.reach(own) + from.reach(of)) * (f64::from(PADDING) * 1.001)
            + DVec3::splat(f64::from(f32::from_bits(1)) * farthest(own).element_sum());
        if !entries(&seen, LIMIT) || offset.abs().max_element().max(doubt.max_element()) > LIMIT {
            return None;
        }
        let [x, y, z] = [seen.x_axis, seen.y_axis, seen.z_axis].map(DVec3::as_vec3a);
        let columns = [x, y, z];
        let translation = offset.as_vec3a();
        let tiny = Vec3A::splat(16.0 * f32::MIN_POSITIVE);
        let slack = translation.abs() * PADDING + doubt.as_vec3a() * 1.001 + tiny;
        Some(Self { columns, magnitudes: columns.map(Vec3A::abs), translation, slack })
    }
}

impl Placement for Posed {
    /// The box of centre R·c + t and half extent |R|·e, padded by 16u(|R|(|c| + e) + |t|), u = 2^-24.
    ///
    /// A posed vertex carries at most 6 roundings of u relative to |R||v| + |t|, and the centre
    /// and half extent computed here at most 9 together relative to the same sum, so that the true
    /// and the computed posed vertex both lie inside. Underflow costs centre and extent half a step of
    /// the subnormal range a product, before a stretching pose magnifies it, and the posed vertex less
    /// than the smallest normal number after; [`Pose::check`] rules out overflow.
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        let centre = bounds.min * 0.5 + bounds.max * 0.5;
        let extent = bounds.max * 0.5 - bounds.min * 0.5;
        let grown = extent + (centre.abs() + extent) * PADDING + Vec3A::splat(SUBNORMAL_SLACK);
        let [x, y, z] = self.columns;
        let middle = x * centre.x + y * centre.y + z * centre.z + self.translation;
        let [x, y, z] = self.magnitudes;
        let reach = x * grown.x + y * grown.y + z * grown.z + self.slack;
        Bounds { min: middle - reach, max: middle + reach }
    }

    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        if !VECTORS {
            return boxes.map(|bounds| self.bounds(bounds));
        }
        let (mut centre, mut grown) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        for k in 0..3 {
            let (min, max) = (boxes.min[k] * 0.5, boxes.max[k] * 0.5);
            let extent = max - min;
            centre[k] = min + max;
            grown[k] = extent + (centre[k].abs() + extent) * PADDING + Vec4::splat(SUBNORMAL_SLACK);
        }
        let (mut min, mut max) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        for i in 0..3 {
            let [x, y, z] = &self.columns;
            let middle =
                centre[0] * x[i] + centre[1] * y[i] + centre[2] * z[i] + self.translation[i];
            let [x, y, z] = &self.magnitudes;
            let reach = grown[0] * x[i] + grown[1] * y[i] + grown[2] * z[i] + self.slack[i];
            (min[i], max[i]) = (middle - reach, middle + reach);
        }
        Boxes { min, max }
    }

    /// The formula of [`Pose::apply`], three rows at once; glam fuses nothing in these operators.
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        let [x, y, z] = self.columns;
        ((x * p.x + y * p.y) + z * p.z) + self.translation
    }

    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        let [x, y, z] = &self.columns;
        let [x, y, z, t]: [&[f32; 3]; 4] =
            [x.as_ref(), y.as_ref(), z.as_ref(), self.translation.as_ref()];
        let mut placed = p;
        for i in 0..3 {
            placed[i] = ((p[0] * S::splat(x[i]) + p[1] * S::splat(y[i])) + p[2] * S::splat(z[i]))
                + S::splat(t[i]);
        }
        placed
    }
}

/// The largest coordinates in some bounds, without sign.
fn farthest(bounds: &Bounds) -> DVec3 {
    bounds.min.abs().max(bounds.max.abs()).as_dvec3()
}
