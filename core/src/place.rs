//! The two ways a walk places a mesh.

use crate::Pose;
use crate::aabb::Bounds;
use crate::lanes::{Boxes, Simd};
use glam::{Vec3A, Vec4};

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
}
