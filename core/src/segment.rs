//! Segments, and the triangles that they meet.
//!
//! A triangle is met if it has a point in common with the segment, both closed: [`crate::triangle::intersects_f64`] of the
//! triangle without area that the segment is. The traversal takes nodes whose boxes the segment may reach, by the separating
//! axis test of a segment and a box (Gottschalk et al., *OBBTree*, 1996) in f64, with a margin for all of its roundings.
//!
//! # Which is first
//! The first point of a triangle along the segment is where that starts, where it passes the plane of the triangle or, in one plane with it, an
//! edge or a corner. Each has a parameter d / (d − e), for determinants d and e of input points with the ends of the segment.
//! Parameters are compared as they are rounded and, where these are close, as fractions of integers.

use crate::MeshError;
use crate::aabb::Bounds;
use crate::bvtt::PosedBvh;
use crate::exact::integer::{compare_orient3d_ratios, orient3d_ratio};
use crate::exact::orientation::{orient2d, sides};
use crate::mesh::check_position;
use crate::triangle::{flat, intersects_in_f64};
use core::cell::Cell;
use core::cmp::Ordering;
use core::ops::ControlFlow;
use glam::DVec3;

/// A closed segment, to ask which triangles it meets: exactly, touching counts. A segment from a point to itself is that point.
///
/// # Examples
/// ```
/// use pfront_core::bvtt::PosedBvh;
/// use pfront_core::segment::{Segment, SegmentHit};
/// use pfront_core::{Bvh, Mesh, Node, Pose};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2], [3, 4, 5]])?;
/// let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.5], count: 2 }];
/// let posed = PosedBvh::new(Bvh::new_unchecked(mesh, &root, &[0, 1]), &Pose::IDENTITY)?;
/// // Downwards.
/// let segment = Segment::new([0.25, 0.25, 2.0], [0.25, 0.25, 0.0])?;
/// assert_eq!(segment.first([posed]), Some((0, SegmentHit { triangle: 1, at: 0.75 })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    ends: [[f64; 3]; 2],
}

/// A triangle that a segment meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SegmentHit {
    /// The triangle.
    pub triangle: u32,
    /// The parameter of their first common point: 0 where the segment starts, 1 where it ends. Rounded, by less than 2^-46; which triangle is
    /// first is decided exactly.
    pub at: f64,
}

impl Segment {
    /// A segment between two points, in f32 or in f64.
    ///
    /// # Errors
    /// [`MeshError`] names an end, as vertex 0 or 1, that has a coordinate which is NaN or beyond ±2^125.
    pub fn new(from: [impl Into<f64>; 3], to: [impl Into<f64>; 3]) -> Result<Self, MeshError> {
        let ends = [from.map(Into::into), to.map(Into::into)];
        check_position(0, ends[0])?;
        check_position(1, ends[1])?;
        Ok(Self { ends })
    }

    /// Both ends.
    #[must_use]
    pub fn points(&self) -> [[f64; 3]; 2] {
        self.ends
    }

    /// Visits the triangles that it meets, as they are posed in f32 or in f64, in no order, until `visit` breaks.
    ///
    /// # Complexity
    /// O(nodes whose boxes it reaches), and some microseconds for each triangle that it meets; no allocation, bounded stack.
    pub fn visit(
        &self,
        posed: &PosedBvh<'_>,
        mut visit: impl FnMut(SegmentHit) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let span = Span::new(self.ends);
        posed.visit_reached(
            |bounds| span.overlaps(bounds),
            |triangle| match self.meet(&posed.corners(triangle)) {
                Some(first) => visit(SegmentHit { triangle, at: first.at }),
                None => ControlFlow::Continue(()),
            },
        )
    }

    /// The first triangle along it of several meshes, and the number of its mesh: exactly, also where two are as close as can be; of equal
    /// ones that of the first mesh, and of its triangles the one with the lowest index.
    ///
    /// # Complexity
    /// As [`Segment::visit`], without nodes beyond the first triangle that has been found so far.
    pub fn first<'a>(
        &self,
        meshes: impl IntoIterator<Item = PosedBvh<'a>>,
    ) -> Option<(usize, SegmentHit)> {
        let span = Cell::new(Span::new(self.ends));
        let mut best: Option<(usize, u32, Parameter)> = None;
        for (number, posed) in meshes.into_iter().enumerate() {
            let _ = posed.visit_reached(
                |bounds| span.get().overlaps(bounds),
                |triangle| {
                    let Some(found) = self.meet(&posed.corners(triangle)) else {
                        return ControlFlow::Continue(());
                    };
                    let is_first = best.as_ref().is_none_or(|(mesh, other, parameter)| {
                        let order = found.compare(parameter);
                        order.then((number, triangle).cmp(&(*mesh, *other))).is_lt()
                    });
                    if is_first {
                        span.set(Span::up_to(self.ends, found.at));
                        best = Some((number, triangle, found));
                    }
                    ControlFlow::Continue(())
                },
            );
        }
        best.map(|(number, triangle, found)| (number, SegmentHit { triangle, at: found.at }))
    }

    /// Where it first meets a triangle, if it does.
    fn meet(&self, t: &[[f64; 3]; 3]) -> Option<Parameter> {
        let [p, q] = self.ends;
        if !meets_box(t, &p, &q) || !intersects_in_f64(t, &[p, q, q]) {
            return None;
        }
        let ([from, to], start) = (sides(t.each_ref(), [&p, &q]), Parameter::new([p; 5]));
        if from != to {
            return Some(Parameter::new([t[0], t[1], t[2], p, q]));
        }
        if p == q || intersects_in_f64(t, &[p; 3]) {
            return Some(start);
        }
        // In one plane with the triangle, or on one line, and not from a point of it.
        let mut first: Option<Parameter> = None;
        let mut add = |found: Parameter| {
            if first.as_ref().is_none_or(|first| found.compare(first).is_lt()) {
                first = Some(found);
            }
        };
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if intersects_in_f64(&[t[i]; 3], &[p, q, q]) {
                add(at_corner(&t[i], [&p, &q]));
            }
            if intersects_in_f64(&[t[i], t[j], t[j]], &[p, q, q]) {
                at_edge([&t[i], &t[j]], [&p, &q]).into_iter().for_each(&mut add);
            }
        }
        // One of its edges or corners is met. `start` is never taken: the triangle would be no hit.
        debug_assert!(first.is_some(), "a border is met");
        Some(first.unwrap_or(start))
    }
}

/// Where a segment passes a plane, in space, in a projection or along an axis: three points of the plane and the ends.
#[derive(Clone, Copy, Debug)]
struct Parameter {
    points: [[f64; 3]; 5],
    /// The parameter, rounded.
    at: f64,
}

/// Rounded parameters that differ by so much are different: 2^-46, of which each may be off by half.
const CLOSE: f64 = 64.0 * f64::EPSILON;

impl Parameter {
    /// Five times the same point is the start.
    fn new(points: [[f64; 3]; 5]) -> Self {
        let [a, b, c, p, q] = points.each_ref();
        let at = if p == q { 0.0 } else { orient3d_ratio([a, b, c], p, q).clamp(0.0, 1.0) };
        Self { points, at }
    }

    fn is_start(&self) -> bool {
        self.points[3] == self.points[4]
    }

    fn compare(&self, other: &Self) -> Ordering {
        if (self.at - other.at).abs() > CLOSE {
            return self.at.total_cmp(&other.at);
        }
        // A parameter is 0 only where the plane contains the start.
        let zero = |own: &Self| own.is_start() || own.on_start();
        match (zero(self), zero(other)) {
            (false, false) => {
                compare_orient3d_ratios(self.points.each_ref(), other.points.each_ref())
            }
            (own, other) => other.cmp(&own),
        }
    }

    fn on_start(&self) -> bool {
        let [a, b, c, p, _] = self.points.each_ref();
        sides([a, b, c], [p]) == [0]
    }
}

/// The parameter of a point of a segment.
fn at_corner(corner: &[f64; 3], [p, q]: [&[f64; 3]; 2]) -> Parameter {
    let axis = (0..3).find(|&k| p[k] != q[k]).unwrap_or(0);
    let [w, p, q] = [corner, p, q].map(|point| point[axis]);
    Parameter::new([[w, 0.0, 0.0], [w, 1.0, 0.0], [w, 0.0, 1.0], [p, 0.0, 0.0], [q, 0.0, 0.0]])
}

/// The parameter at which a segment passes an edge in one plane with it, which it meets; none on one line, where it meets a corner.
fn at_edge([u, v]: [&[f64; 3]; 2], [p, q]: [&[f64; 3]; 2]) -> Option<Parameter> {
    (0..3).find_map(|axis| {
        let [u, v, p, q] = flat(&[*u, *v, *p, *q], axis);
        if [orient2d(&u, &v, &p), orient2d(&u, &v, &q)] == [0; 2] {
            return None;
        }
        let lift = |[x, y]: [f64; 2], z: f64| [x, y, z];
        Some(Parameter::new([lift(u, 0.0), lift(v, 0.0), lift(u, 1.0), lift(p, 0.0), lift(q, 0.0)]))
    })
}

/// Whether the box of a triangle overlaps that of a segment.
#[inline]
fn meets_box(t: &[[f64; 3]; 3], p: &[f64; 3], q: &[f64; 3]) -> bool {
    let [a, b, c] = t.map(DVec3::from_array);
    let [p, q] = [*p, *q].map(DVec3::from_array);
    (a.min(b).min(c).cmple(p.max(q)) & p.min(q).cmple(a.max(b).max(c))).all()
}

/// The part of a segment that boxes are compared with.
#[derive(Clone, Copy)]
struct Span {
    /// The middle, and half of what leads from the start to the end.
    middle: DVec3,
    half: DVec3,
    /// The largest coordinates of the whole segment, of which roundings are a part.
    most: DVec3,
}

impl Span {
    fn new([p, q]: [[f64; 3]; 2]) -> Self {
        let [p, q] = [p, q].map(DVec3::from_array);
        Self { middle: p * 0.5 + q * 0.5, half: q * 0.5 - p * 0.5, most: p.abs().max(q.abs()) }
    }

    /// Up to a parameter that is rounded, and a little farther.
    fn up_to([p, q]: [[f64; 3]; 2], at: f64) -> Self {
        let whole = Self::new([p, q]);
        let part = (at + CLOSE).min(1.0);
        Self { middle: DVec3::from_array(p) + whole.half * part, half: whole.half * part, ..whole }
    }

    /// Whether a box may contain a point of it: not if an axis of the box, or one at right angles to it and to the segment, separates
    /// them.
    ///
    /// With u = 2^-53 and s the largest coordinate of both on an axis, all that is computed along it is at most 2s and off by at most
    /// 8us, `up_to` included; so a product of two is off by less than 40u · s · s', and all four by less than 2^-44 · s · s'.
    #[inline]
    fn overlaps(&self, bounds: &Bounds) -> bool {
        const MARGIN: f64 = 512.0 * (f64::EPSILON * 0.5);
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let s = self.most.max(min.abs().max(max.abs()));
        let (centre, box_half) = (min * 0.5 + max * 0.5, max * 0.5 - min * 0.5);
        let (between, half) = (self.middle - centre, self.half.abs());
        if between.abs().cmpgt(box_half + half + s * MARGIN).any() {
            return false;
        }
        let turned = between.cross(self.half).abs();
        let right = |v: DVec3| DVec3::new(v.y, v.z, v.x);
        let left = |v: DVec3| DVec3::new(v.z, v.x, v.y);
        let reach = right(box_half) * left(half) + left(box_half) * right(half);
        let error = right(s) * left(s) * MARGIN + DVec3::splat(f64::MIN_POSITIVE);
        turned.cmple(reach + error).all()
    }
}

#[cfg(test)]
mod tests;
