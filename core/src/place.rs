//! The two ways a walk places a mesh.

use crate::Pose;
use crate::aabb::Bounds;
use crate::lanes::{Boxes, Simd};
use glam::{DMat3, DVec3, Vec3A, Vec4};

/// How a walk sees a mesh: where its boxes and corners are in the frame of the query.
pub(crate) trait Placement {
    /// A box that contains the placed corners of everything in `bounds`.
    fn bounds(&self, bounds: &Bounds) -> Bounds;
    /// The same of four boxes.
    fn boxes(&self, boxes: &Boxes) -> Boxes;
    /// The placed corner.
    fn point(&self, p: Vec3A) -> Vec3A;
    /// Placed corners.
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3];
}

impl<P: Placement> Placement for &P {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        P::bounds(self, bounds)
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        P::boxes(self, boxes)
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        P::point(self, p)
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        P::points(self, p)
    }
}

/// The mesh is in the frame of the query as it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InPlace;

impl Placement for InPlace {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        *bounds
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        *boxes
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        p
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        p
    }
}

/// A pose by columns, with what box transformation needs beside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posed {
    columns: [Vec3A; 3],
    magnitudes: [Vec3A; 3],
    translation: Vec3A,
    /// Padding that the translation alone asks for.
    slack: Vec3A,
}

/// 16 · 2^-24: see [`Posed::bounds`].
const PADDING: f32 = 9.536_743_e-7;

/// 2^-147: four times the smallest subnormal number.
const SUBNORMAL_SLACK: f32 = f32::from_bits(4);

impl Posed {
    pub(crate) fn new(pose: &Pose) -> Self {
        let column = |k: usize| Vec3A::from_array([0, 1, 2].map(|i| pose.rows[i][k]));
        let columns = [column(0), column(1), column(2)];
        Self {
            columns,
            magnitudes: columns.map(Vec3A::abs),
            translation: column(3),
            slack: column(3).abs() * PADDING + Vec3A::splat(f32::MIN_POSITIVE),
        }
    }
}

impl Posed {
    /// How far from the origin posed points of some bounds get, about.
    fn reach(&self, bounds: &Bounds) -> DVec3 {
        let extent = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
        let [x, y, z] = self.magnitudes.map(|column| column.as_dvec3());
        x * extent.x + y * extent.y + z * extent.z + self.translation.abs().as_dvec3()
    }

    /// This pose as seen from a mesh in another one: what it takes boxes to overlaps each box of that
    /// mesh, as it stands in its own frame, with which it has posed points in common. `None` if the other
    /// pose is far from rigid, or the two far apart in scale.
    ///
    /// A point common to both as they are posed in f32 is A(x) + d = B(y) + e for points x and y of the
    /// boxes, with d and e at most 6u of what the poses reach. So x = A⁻¹(B(y)) + A⁻¹(e − d) without
    /// translation: a box of A⁻¹·B, padded by |A⁻¹| times 16u of both reaches, contains x. What is left
    /// of these 16u is far more than the f64 roundings of A⁻¹ and the products with it.
    pub(crate) fn seen_from(&self, own: &Bounds, from: &Self, of: &Bounds) -> Option<Self> {
        const RIGID: f64 = 2.0;
        const LIMIT: f64 = 1e30;
        let matrix = |p: &Self| {
            let [x, y, z] = p.columns.map(|column| column.as_dvec3());
            DMat3::from_cols(x, y, z)
        };
        let turn = matrix(from);
        let back = turn.inverse();
        let entries = |m: &DMat3, limit: f64| m.to_cols_array().iter().all(|x| x.abs() <= limit);
        if !entries(&turn, RIGID) || !entries(&back, RIGID) {
            return None;
        }
        let seen = back * matrix(self);
        let offset = back * (self.translation.as_dvec3() - from.translation.as_dvec3());
        let doubt = back.abs() * (self.reach(own) + from.reach(of)) * (f64::from(PADDING) * 1.001);
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
        let mut placed = p;
        for (i, placed) in placed.iter_mut().enumerate() {
            let [x, y, z, t] =
                [self.columns[0][i], self.columns[1][i], self.columns[2][i], self.translation[i]];
            *placed =
                ((p[0] * S::splat(x) + p[1] * S::splat(y)) + p[2] * S::splat(z)) + S::splat(t);
        }
        placed
    }
}

/// Either, for what is asked of single nodes; a walk asks once and keeps to the one or the other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    InPlace,
    Posed(Posed),
}

impl Place {
    pub(crate) fn new(pose: &Pose) -> Self {
        if *pose == Pose::IDENTITY { Self::InPlace } else { Self::Posed(Posed::new(pose)) }
    }
}

impl Placement for Place {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        match self {
            Self::InPlace => InPlace.bounds(bounds),
            Self::Posed(posed) => posed.bounds(bounds),
        }
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        match self {
            Self::InPlace => *boxes,
            Self::Posed(posed) => posed.boxes(boxes),
        }
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        match self {
            Self::InPlace => InPlace.point(p),
            Self::Posed(posed) => posed.point(p),
        }
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        match self {
            Self::InPlace => p,
            Self::Posed(posed) => posed.points(p),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, Task, widest};
    use crate::{Aabb, Node};

    /// Places a point in all lanes but the first and returns the last.
    struct Lanes {
        place: Posed,
        point: [f32; 3],
    }

    impl Task for Lanes {
        type Output = [f32; 3];

        #[inline(always)]
        fn run<S: Simd>(self) -> [f32; 3] {
            let placed = self.place.points(self.point.map(|x| {
                let mut lanes = [x; LANES];
                lanes[0] = -x;
                S::load(&lanes)
            }));
            placed.map(|x| {
                let mut lanes = [0.0; LANES];
                x.store(&mut lanes);
                lanes[LANES - 1]
            })
        }
    }

    fn course() -> impl Iterator<Item = (Pose, [[f32; 3]; 2])> {
        let mut state = 7_u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let scale = [1e-6, 1.0, 3.0, 1e4][(state >> 4) as usize % 4];
            ((state >> 9) as f32 / 4_194_304.0 - 1.0) * scale
        };
        (0..if cfg!(miri) { 20 } else { 50_000 }).map(move |_| {
            let rows = core::array::from_fn(|_| core::array::from_fn(|_| next()));
            (Pose::new(rows), core::array::from_fn(|_| core::array::from_fn(|_| next())))
        })
    }

    #[test]
    fn corners_are_posed_by_the_formula_of_the_contract_to_the_bit() {
        for (pose, points) in course() {
            for p in points {
                let (place, truth) = (Posed::new(&pose), pose.apply(p).map(f32::to_bits));
                assert_eq!(place.point(Vec3A::from_array(p)).to_array().map(f32::to_bits), truth);
                let lanes = Lanes { place, point: p };
                assert_eq!(widest(lanes).map(f32::to_bits), truth);
            }
        }
    }

    #[test]
    fn posed_boxes_contain_posed_corners() {
        for (pose, points) in course() {
            let aabb = Aabb::of(&points);
            let placed = Posed::new(&pose).bounds(&Bounds::new(&aabb));
            let one = Node { min: aabb.min, max: aabb.max, ..Node::EMPTY };
            let four = Boxes::of_nodes([&one, &Node::EMPTY, &one, &one]);
            let four = Posed::new(&pose).boxes(&four);
            for corner in 0..8 {
                let p = [0, 1, 2].map(|k| [aabb.min, aabb.max][corner >> k & 1][k]);
                let p = Vec3A::from_array(pose.apply(p));
                assert!(placed.min.cmple(p).all() && p.cmple(placed.max).all());
                let p = p.to_array().map(Vec4::splat);
                assert_eq!(four.overlapping(&Boxes { min: p, max: p }), 0b1101);
            }
        }
    }

    /// A rotation and a translation of the order of `far`.
    fn rigid(points: &[[f32; 3]; 2], far: f32) -> Pose {
        let [axis, offset] = points.map(glam::Vec3::from_array);
        let turn = glam::Quat::from_scaled_axis(axis.normalize_or_zero() * axis.length().min(3.0));
        glam::Affine3A::from_rotation_translation(turn, offset.normalize_or_zero() * far).into()
    }

    #[test]
    fn boxes_seen_from_another_pose_contain_what_both_pose_alike() {
        let mut course = course();
        while let (Some((_, p)), Some((_, q)), Some((_, r))) =
            (course.next(), course.next(), course.next())
        {
            for far in [0.0, 1.0, 1e5] {
                let (a, b) = (rigid(&p, far), rigid(&q, far));
                let y = r[0];
                let back = glam::DAffine3::from_mat3_translation(
                    DMat3::from_cols_array_2d(&core::array::from_fn(|k| {
                        core::array::from_fn(|i| f64::from(a.rows[i][k]))
                    })),
                    DVec3::from_array(core::array::from_fn(|i| f64::from(a.rows[i][3]))),
                )
                .inverse();
                let world = glam::Vec3::from_array(b.apply(y)).as_dvec3();
                let x = back.transform_point3(world).as_vec3a();
                let of = |p: [f32; 3]| Bounds::new(&Aabb { min: p, max: p });
                let (a, b) = (Posed::new(&a), Posed::new(&b));
                let seen = b.seen_from(&of(y), &a, &of(x.to_array())).unwrap().bounds(&of(y));
                assert!(seen.min.cmple(x).all() && x.cmple(seen.max).all(), "{seen:?} {x}");
            }
        }
    }

    #[test]
    fn no_view_from_a_pose_that_flattens_or_stretches() {
        let unit = Bounds::new(&Aabb { min: [0.0; 3], max: [1.0; 3] });
        let mut flat = Pose::IDENTITY;
        flat.rows[2] = [0.0; 4];
        let mut stretched = Pose::IDENTITY;
        stretched.rows[1][1] = 3.0;
        let still = Posed::new(&Pose::IDENTITY);
        for pose in [flat, stretched] {
            assert!(still.seen_from(&unit, &Posed::new(&pose), &unit).is_none());
            assert!(Posed::new(&pose).seen_from(&unit, &still, &unit).is_some());
        }
    }
}
