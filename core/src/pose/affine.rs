//! Posed points and boxes, with a bound on how far rounding takes one from the other.

use super::{Pose, Pose64};
use crate::aabb::Bounds;
use crate::simd::{Box4, Simd};
use glam::{DMat3, DVec3, Vec3A};

/// A pose by columns, for the points and boxes inside some bounds.
///
/// # Rounding
/// Let u = 2^-24 and m = |R||v| + |t| for the farthest point v of the bounds. A posed vertex carries at most 6
/// roundings of u relative to m; the centre R·c + t and the half extent |R|·e of a posed box carry at most 9
/// together. So a box that is padded by 16u·m contains the true and the computed posed vertex. Underflow costs
/// the centre and the extent half a step of the subnormal range for each product, before R magnifies it, and the
/// posed vertex less than the smallest normal number after. [`Pose::check`] excludes overflow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Affine {
    columns: [Vec3A; 3],
    translation: Vec3A,
    /// The padding of a posed box on each axis.
    padding: Vec3A,
}

/// 16u, and the roundings of the padding itself.
const ROUNDING: f64 = Pose::ROUNDING as f64 * 1.001;

/// 2^-147, four times the smallest subnormal f32. It is an f64, since subnormal numbers are slow.
const UNDERFLOW: f64 = 5.605_193_857_299_268e-45;

/// 2^-49.
const TWO_NEG_49: f64 = 1.776_356_839_400_250_5e-15;

/// 2^-126.
const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;

impl Affine {
    /// The map of `pose` for what lies in `bounds`; `None` for [`Pose::IDENTITY`], which moves nothing.
    pub(crate) fn new(pose: &Pose, bounds: &Bounds) -> Option<Self> {
        let [x, y, z] = pose.rows;
        let column = |k: usize| Vec3A::new(x[k], y[k], z[k]);
        let columns = [column(0), column(1), column(2)];
        (*pose != Pose::IDENTITY)
            .then(|| Self::padded(columns, column(3), bounds, DVec3::splat(SMALLEST_NORMAL)))
    }

    /// The pose of the shadow of a mesh in f64, whose origin and bounds these are, in a frame that has its own origin at `zero`
    /// of where `pose` takes the mesh. It takes a point of the shadow, in f32 too, to within the padding of where `pose` takes
    /// the position, minus `zero`.
    ///
    /// # Rounding
    /// With h the farthest of the bounds and m = |R|h + |t| as above, t the translation from `zero`: the entries of R and t are
    /// off by u each, a shadow by u·h, and the posed point by 6u·m: below 9u·m, and together with centre and extent below 16u·m.
    /// In f64, with U = 2^-53, the position is posed with 5U of |R|(|origin| + h) + |t|, t computed with 7U and the shadow with
    /// 1U: below 2^-49 of |R|(|origin| + h) + |t| + |zero|. Where entries or shadows are subnormal in f32, they lose half of
    /// the smallest number instead.
    pub(crate) fn of_shadow(pose: &Pose64, origin: DVec3, bounds: &Bounds, zero: DVec3) -> Self {
        let [x, y, z] = pose.rows;
        let column = |k: usize| DVec3::new(x[k], y[k], z[k]);
        let columns = [column(0), column(1), column(2)];
        let translation = DVec3::from_array(pose.apply(origin.to_array())) - zero;
        let reach = DMat3::from_cols(columns[0], columns[1], columns[2]).abs()
            * (origin.abs() + farthest(bounds))
            + column(3).abs()
            + zero.abs();
        let rest = reach * TWO_NEG_49
            + DVec3::splat(SMALLEST_NORMAL + UNDERFLOW * farthest(bounds).element_sum());
        Self::padded(columns.map(DVec3::as_vec3a), translation.as_vec3a(), bounds, rest)
    }

    /// The pose it was made of.
    pub(crate) fn to_pose(self) -> Pose {
        let ([x, y, z], t) = (self.columns, self.translation);
        Pose::new([0, 1, 2].map(|k| [x[k], y[k], z[k], t[k]]))
    }

    /// How far what it takes a point to may be from what it stands for, on each axis.
    pub(crate) fn padding(&self) -> Vec3A {
        self.padding
    }

    /// The same with boxes that reach farther, by so much on each axis.
    pub(crate) fn grown(self, by: Vec3A) -> Self {
        let padding = (self.padding + by).to_array().map(f32::next_up);
        Self { padding: Vec3A::from_array(padding), ..self }
    }

    /// By how much a box in the frame that is posed has to grow on each axis, for its posed points to reach as far as a distance
    /// around: the lengths of the rows of the inverse, times the distance, rounded up by more than f64 takes. Infinite without
    /// an inverse.
    pub(crate) fn growth_in_own_frame(&self, distance: f32) -> Vec3A {
        let Some(back) = self.matrix().try_inverse() else { return Vec3A::INFINITY };
        let [x, y, z] = back.transpose().to_cols_array_2d().map(DVec3::from_array);
        let lengths = DVec3::new(x.length(), y.length(), z.length());
        (lengths * (f64::from(distance) * 1.000_001)).as_vec3a()
    }

    /// The pose that moves nothing, for what lies in `bounds`.
    pub(crate) fn identity(bounds: &Bounds) -> Self {
        Self::padded([Vec3A::X, Vec3A::Y, Vec3A::Z], Vec3A::ZERO, bounds, DVec3::ZERO)
    }

    /// Whether it takes every point to where it is.
    pub(crate) fn moves_nothing(&self) -> bool {
        self.columns == [Vec3A::X, Vec3A::Y, Vec3A::Z] && self.translation == Vec3A::ZERO
    }

    /// Whether an axis is taken to a direction that is not along an axis, so that a posed box is larger.
    pub(crate) fn is_turned(&self) -> bool {
        self.columns.iter().any(|column| column.cmpeq(Vec3A::ZERO).bitmask().count_ones() < 2)
    }

    /// `rest` is what boxes have to be padded by besides rounding and the underflow of products.
    fn padded(columns: [Vec3A; 3], translation: Vec3A, bounds: &Bounds, rest: DVec3) -> Self {
        let mut affine = Self { columns, translation, padding: Vec3A::ZERO };
        let underflow = affine.matrix().abs() * DVec3::splat(UNDERFLOW) + rest;
        affine.padding = (affine.reach(bounds) * ROUNDING + underflow).as_vec3a();
        affine
    }

    /// This pose seen from the frame of a mesh that is itself in the pose `from`: the boxes it takes overlap those
    /// of that mesh, as they stand in its own frame, wherever both have posed points in common. `None` if `from` is
    /// far from rigid, or this pose enormous beside it.
    ///
    /// A point common to both as they are posed is A(x) + d = B(y) + e for points x and y of the boxes, with d and e within
    /// 9/16 of the paddings. So x = A⁻¹(B(y)) + A⁻¹(e − d) without translation: a box of A⁻¹·B, padded by |A⁻¹| times both
    /// paddings, contains x. The rest of them is far more than the f64 roundings of A⁻¹ and the products with it. Entries of A⁻¹·B
    /// that are subnormal in f32 lose half the smallest number each, and so less than that per coordinate.
    pub(crate) fn seen_from(&self, own: &Bounds, from: &Self) -> Option<Self> {
        // A policy: rotations have entries up to 1, and scales so far from it pad more than the view saves.
        const RIGID: f64 = 2.0;
        // Far from where boxes would overflow.
        const LIMIT: f64 = 1e30;
        let [turn, own_turn] = [from.matrix(), self.matrix()];
        let back = turn.try_inverse()?;
        let below = |m: &DMat3, limit: f64| m.to_cols_array().iter().all(|x| x.abs() <= limit);
        let seen = back * own_turn;
        let offset = back * (self.translation.as_dvec3() - from.translation.as_dvec3());
        let error = back.abs() * (self.padding + from.padding).as_dvec3()
            + DVec3::splat(UNDERFLOW * farthest(own).element_sum());
        let largest = offset.abs().max_element().max(error.max_element());
        if !(below(&turn, RIGID) && below(&back, RIGID) && below(&seen, LIMIT) && largest <= LIMIT)
        {
            return None;
        }
        let columns = [seen.x_axis, seen.y_axis, seen.z_axis].map(DVec3::as_vec3a);
        let rest = error + DVec3::splat(16.0 * SMALLEST_NORMAL);
        Some(Self::padded(columns, offset.as_vec3a(), own, rest))
    }

    fn matrix(&self) -> DMat3 {
        let [x, y, z] = self.columns.map(|column| column.as_dvec3());
        DMat3::from_cols(x, y, z)
    }

    /// The farthest that posed points of `bounds` get from the origin, roughly.
    fn reach(&self, bounds: &Bounds) -> DVec3 {
        self.matrix().abs() * farthest(bounds) + self.translation.abs().as_dvec3()
    }

    /// A box that contains the posed points of `bounds`.
    #[inline]
    pub(crate) fn bounds(&self, bounds: &Bounds) -> Bounds {
        let centre = bounds.min * 0.5 + bounds.max * 0.5;
        let extent = bounds.max * 0.5 - bounds.min * 0.5;
        let middle = self.point(centre);
        let [x, y, z] = self.columns.map(Vec3A::abs);
        let reach = x * extent.x + y * extent.y + z * extent.z + self.padding;
        Bounds { min: middle - reach, max: middle + reach }
    }

    /// [`Affine::bounds`] of four boxes.
    #[inline(always)]
    pub(crate) fn boxes(&self, boxes: &Box4) -> Box4 {
        let ([a, b, c], [d, e, f]) = (boxes.min.map(|v| v * 0.5), boxes.max.map(|v| v * 0.5));
        let (centre, extent) = ([a + d, b + e, c + f], [d - a, e - b, f - c]);
        let (mut min, mut max) = (boxes.min, boxes.max);
        for i in 0..3 {
            let [x, y, z] = self.columns.map(|column| column[i]);
            let middle = centre[0] * x + centre[1] * y + centre[2] * z + self.translation[i];
            let [x, y, z] = [x.abs(), y.abs(), z.abs()];
            let reach = extent[0] * x + extent[1] * y + extent[2] * z + self.padding[i];
            (min[i], max[i]) = (middle - reach, middle + reach);
        }
        Box4 { min, max }
    }

    /// The posed point, by the formula of [`Pose::apply`]; glam fuses nothing in these operators.
    #[inline]
    pub(crate) fn point(&self, p: Vec3A) -> Vec3A {
        let [x, y, z] = self.columns;
        ((x * p.x + y * p.y) + z * p.z) + self.translation
    }

    /// [`Affine::point`] in each lane.
    #[inline(always)]
    pub(crate) fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        let [x, y, z] = &self.columns;
        let mut posed = p;
        for i in 0..3 {
            let sum = (p[0] * S::splat(x[i]) + p[1] * S::splat(y[i])) + p[2] * S::splat(z[i]);
            posed[i] = sum + S::splat(self.translation[i]);
        }
        posed
    }
}

/// The largest absolute coordinates in some bounds.
fn farthest(bounds: &Bounds) -> DVec3 {
    bounds.min.abs().max(bounds.max.abs()).as_dvec3()
}
