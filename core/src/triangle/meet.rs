//! Where two triangles meet, without coordinates.
//!
//! A closed triangle has seven regions: three corners, three edges without their ends, and the rest, its face. Where both triangles meet is
//! convex, and each of its corners is the only point that some region of one has in common with some region of the other. So the pairs of
//! these regions tell all of it: the points by the features that define them, and whether they are a point, a segment or a polygon.
//! Signs of orientation determinants of input points decide, and nothing is rounded.

use super::coplanar::{extremes, flat, projection};
use super::one_sided;
use super::ratio::fraction;
use crate::Triangle;
use crate::exact::orientation::{orient2d, sides};
use crate::exact::{Exact, difference};
use crate::mesh::{MeshError, check_position};
use crate::scalar::Scalar;

/// A region of a closed triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Region {
    /// A corner: 0, 1 or 2.
    Corner(u8),
    /// The edge from this corner to the next, without its ends.
    Edge(u8),
    /// The triangle without its edges. Empty if it has no area.
    Face,
}

impl Region {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Corner(0),
        Self::Corner(1),
        Self::Corner(2),
        Self::Edge(0),
        Self::Edge(1),
        Self::Edge(2),
        Self::Face,
    ];

    /// The edges that hold it with their ends, a bit for each.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::triangle::Region;
    /// assert_eq!(Region::Corner(0).edges(), 0b101);
    /// assert_eq!(Region::Edge(2).edges(), 0b100);
    /// ```
    #[must_use]
    pub fn edges(self) -> u8 {
        match self {
            Self::Corner(k) => 1 << (k % 3) | 1 << ((k + 2) % 3),
            Self::Edge(k) => 1 << (k % 3),
            Self::Face => 0,
        }
    }
}

/// The number of the first edge among the regions, and that of the face.
const EDGE: usize = 3;
const FACE: usize = 6;

/// Where two closed triangles meet, by the corners of what they have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Meet {
    /// A bit for each two regions that have one point in common.
    corners: u64,
    dimension: u8,
    is_proper: bool,
    has_area: [bool; 2],
}

impl Meet {
    /// The corners of what both have in common: a region of the first and one of the second, which have this point in common and no
    /// other. A point, the ends of a segment, or the corners of a polygon of at most six, in no order. Where a triangle has no area,
    /// more than one region may hold a corner, which then stands here more than once, and so do its corners within its segment.
    pub fn corners(&self) -> impl Iterator<Item = [Region; 2]> + use<> {
        let corners = self.corners;
        let is_one = move |&bit: &usize| corners >> bit & 1 != 0;
        (0..49).filter(is_one).map(|bit| [Region::ALL[bit / 7], Region::ALL[bit % 7]])
    }

    /// The points of [`Meet::corners`], in the same order, for the corners of the triangles that meet so: on each axis an interval that holds
    /// the coordinate. Corners of a triangle are exact; others are within 2^-43 of the length of their edge and 2^-51 of the coordinate.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::triangle::meet_f64;
    /// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// let blade = [[1.0, 1.0, -1.0], [1.0, 2.0, -2.0], [1.0, 1.0, 1.0]];
    /// let found = meet_f64(&floor, &blade)?.expect("they meet");
    /// let [_, [low, high], _] = found.points(&floor, &blade).next().expect("they meet");
    /// assert!(low <= 4.0 / 3.0 && 4.0 / 3.0 <= high && high - low < 1e-12);
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn points<'t>(
        &self,
        a: &'t [[f64; 3]; 3],
        b: &'t [[f64; 3]; 3],
    ) -> impl Iterator<Item = [[f64; 2]; 3]> + use<'t> {
        self.corners().map(move |corner| point_of(corner, a, b))
    }

    /// 0 for a point, 1 for a segment, 2 for a polygon.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension.into()
    }

    /// Whether their faces cross: they meet in a segment that runs through both, and lie in different planes.
    #[must_use]
    pub fn is_proper(&self) -> bool {
        self.is_proper
    }

    /// Whether each triangle has an area. Its edges overlap if not.
    #[must_use]
    pub fn has_area(&self) -> [bool; 2] {
        self.has_area
    }

    /// The common part of two triangles that have areas, by its corners; `None` if there are none.
    fn new(CornerSet(corners): CornerSet, are_coplanar: bool) -> Option<Self> {
        let dimension = corners.count_ones().checked_sub(1)?.min(2) as u8;
        let mut found = Self { corners, dimension, is_proper: false, has_area: [true; 2] };
        // The edges on which all corners are.
        let edges = found.corners().fold([7; 2], |[a, b], [r, s]| [a & r.edges(), b & s.edges()]);
        found.is_proper = dimension == 1 && !are_coplanar && edges == [0; 2];
        Some(found)
    }
}

/// How two closed triangles meet, exactly, or `None` if they do not: `Some` exactly when [`intersects`](super::intersects) says so.
///
/// Coordinates must be finite.
///
/// # Complexity
/// O(1), no allocation.
///
/// # Examples
/// ```
/// use pfront_core::triangle::{Region, meet};
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let blade = [[1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0]];
/// let found = meet(&floor, &blade).expect("they meet");
/// assert!(found.dimension() == 1 && found.is_proper());
/// // Two edges of the blade go through the floor.
/// let corners: Vec<_> = found.corners().collect();
/// assert_eq!(corners, [[Region::Face, Region::Edge(1)], [Region::Face, Region::Edge(2)]]);
/// ```
#[must_use]
pub fn meet(a: &Triangle, b: &Triangle) -> Option<Meet> {
    meet_of(a, b)
}

/// [`meet`] of triangles in f64.
///
/// # Errors
/// [`MeshError`] names the first of the six corners that has a coordinate which is NaN or beyond ±2^125.
///
/// # Complexity
/// O(1), no allocation.
///
/// # Examples
/// ```
/// use pfront_core::triangle::meet_f64;
/// let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// assert_eq!(meet_f64(&floor, &floor)?.map(|found| found.dimension()), Some(2));
/// # Ok::<(), pfront_core::MeshError>(())
/// ```
pub fn meet_f64(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> Result<Option<Meet>, MeshError> {
    for (corner, p) in a.iter().chain(b).enumerate() {
        check_position(corner, *p)?;
    }
    Ok(meet_of(a, b))
}

/// [`meet`] of triangles with coordinates of either kind, which are in range.
pub(crate) fn meet_of<C: Scalar>(a: &[[C; 3]; 3], b: &[[C; 3]; 3]) -> Option<Meet> {
    let a_sides = sides(b.each_ref(), a.each_ref());
    if one_sided(&a_sides) {
        return None;
    }
    let b_sides = sides(a.each_ref(), b.each_ref());
    if one_sided(&b_sides) {
        return None;
    }
    let mut found = CornerSet(0);
    // A side other than 0 is one of a plane, so that the triangle has an area.
    let are_crossed = a_sides != [0; 3] && b_sides != [0; 3];
    let has_area = if are_crossed { [true; 2] } else { [a, b].map(|t| has_area(t)) };
    if has_area != [true; 2] {
        found.add_of_segments(a, &a_sides, b, &b_sides);
        let [own, other] = [a, b].map(distinct_regions);
        let is_distinct = |bit: &usize| own >> (bit / 7) & other >> (bit % 7) & 1 != 0;
        let distinct = (0..49).filter(|bit| found.0 >> bit & 1 != 0).filter(is_distinct).count();
        let dimension = distinct.checked_sub(1)? as u8;
        return Some(Meet { corners: found.0, dimension, is_proper: false, has_area });
    }
    found.add_cuts(a, &a_sides, b, |own, other| (own, other));
    found.add_cuts(b, &b_sides, a, |own, other| (other, own));
    if !are_crossed {
        found.add_crossing_edges(a, b, &[projection::<Exact<C>>(a)??.axis]);
    }
    Meet::new(found, !are_crossed)
}

fn has_area<C: Scalar>(t: &[[C; 3]; 3]) -> bool {
    projection::<Exact<C>>(t).flatten().is_some()
}

/// A bit for each region of a triangle without area that counts where points are counted: the ends of its segment, and the edge
/// between them. All of one with an area.
fn distinct_regions<C: Scalar>(t: &[[C; 3]; 3]) -> usize {
    if has_area(t) {
        return 0b111_1111;
    }
    let ends = extremes(t).map(|end| t.iter().position(|p| *p == end).unwrap_or(0));
    // The edge opposite to a corner is that from the next one.
    let edge = if ends[0] == ends[1] { 0 } else { 1 << (EDGE + (4 - ends[0] - ends[1]) % 3) };
    1 << ends[0] | 1 << ends[1] | edge
}

/// The corners found, as in [`Meet`].
#[derive(Clone, Copy)]
struct CornerSet(u64);

impl CornerSet {
    fn add(&mut self, (of_a, of_b): (usize, usize)) {
        self.0 |= 1 << (7 * of_a + of_b);
    }

    /// Adds the corners of a triangle that lie in another, which has an area, and the points in which its edges cut the other.
    fn add_cuts<C: Scalar>(
        &mut self,
        own: &[[C; 3]; 3],
        own_sides: &[i32; 3],
        other: &[[C; 3]; 3],
        order: impl Fn(usize, usize) -> (usize, usize),
    ) {
        for k in 0..3 {
            let next = (k + 1) % 3;
            if own_sides[k] == 0
                && let Some(region) = region_of_point(&own[k], other)
            {
                self.add(order(k, region));
            }
            if own_sides[k] * own_sides[next] < 0 {
                let (p, q) = if own_sides[k] < 0 { (k, next) } else { (next, k) };
                let turn = |from: usize| {
                    let [side] = sides([&own[p], &own[q], &other[from]], [&other[(from + 1) % 3]]);
                    side
                };
                if let Some(region) = region_of_turns(turn) {
                    self.add(order(EDGE + k, region));
                }
            }
        }
    }

    /// Adds the points in which edges cross within a plane, in projections of which one shows them as they are.
    fn add_crossing_edges<C: Scalar>(&mut self, a: &[[C; 3]; 3], b: &[[C; 3]; 3], axes: &[usize]) {
        for (k, l) in (0..9).map(|pair| (pair / 3, pair % 3)) {
            let (e, f) = ([a[k], a[(k + 1) % 3]], [b[l], b[(l + 1) % 3]]);
            let crosses = |&axis: &usize| {
                let (e, f) = (flat(&e, axis), flat(&f, axis));
                let parts = |[p, q]: &[[C; 2]; 2], [r, s]: &[[C; 2]; 2]| {
                    orient2d(p, q, r) * orient2d(p, q, s) < 0
                };
                parts(&e, &f) && parts(&f, &e)
            };
            let are_coplanar = || sides([&e[0], &e[1], &f[0]], [&f[1]]) == [0];
            if axes.iter().any(crosses) && (axes.len() == 1 || are_coplanar()) {
                self.add((EDGE + k, EDGE + l));
            }
        }
    }

    /// Adds all corners of triangles of which at least one has no area.
    #[cold]
    fn add_of_segments<C: Scalar>(
        &mut self,
        a: &[[C; 3]; 3],
        a_sides: &[i32; 3],
        b: &[[C; 3]; 3],
        b_sides: &[i32; 3],
    ) {
        if has_area(b) {
            self.add_cuts(a, a_sides, b, |own, other| (own, other));
        }
        if has_area(a) {
            self.add_cuts(b, b_sides, a, |own, other| (other, own));
        }
        self.add_crossing_edges(a, b, &[0, 1, 2]);
        for (i, j) in (0..9).map(|pair| (pair / 3, pair % 3)) {
            if a[i] == b[j] {
                self.add((i, j));
            }
            if is_between(&a[i], &b[j], &b[(j + 1) % 3]) {
                self.add((i, EDGE + j));
            }
            if is_between(&b[j], &a[i], &a[(i + 1) % 3]) {
                self.add((EDGE + i, j));
            }
        }
    }
}

/// The point that two regions have in common, on each axis an interval that holds the coordinate.
fn point_of([r, s]: [Region; 2], a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 2]; 3] {
    let edge = |t: &[[f64; 3]; 3], k: u8| [t[k as usize % 3], t[(k as usize + 1) % 3]];
    let ([p, q], plane) = match (r, s) {
        (Region::Corner(k), _) => return a[k as usize % 3].map(|x| [x; 2]),
        (_, Region::Corner(k)) => return b[k as usize % 3].map(|x| [x; 2]),
        (Region::Edge(k), Region::Edge(l)) => {
            let (e, f) = (edge(a, k), edge(b, l));
            (e, plane_across(&e, &f))
        }
        (Region::Edge(k), Region::Face) => (edge(a, k), *b),
        (Region::Face, Region::Edge(k)) => (edge(b, k), *a),
        (Region::Face, Region::Face) => return [0, 1, 2].map(|axis| [a[0][axis]; 2]),
    };
    let [part, error] = fraction(&plane, &p, &q);
    [0, 1, 2].map(|axis| {
        let whole = q[axis] - p[axis];
        let x = p[axis] + part * whole;
        // Its terms are rounded by 2^-53 each.
        let radius = whole.abs() * (error + 2.0 * f64::EPSILON) + x.abs() * f64::EPSILON;
        [x - radius - f64::MIN_POSITIVE, x + radius + f64::MIN_POSITIVE]
    })
}

/// A plane through the second of two edges that cross, on whose different sides the ends of the first are.
fn plane_across([p, q]: &[[f64; 3]; 2], [r, s]: &[[f64; 3]; 2]) -> [[f64; 3]; 3] {
    let across = difference(q, p).cross(difference(s, r));
    let largest = across.abs().max_position();
    let is_seen = |&axis: &usize| {
        let [p, q, r, s] = flat(&[*p, *q, *r, *s], axis);
        orient2d(&r, &s, &p) * orient2d(&r, &s, &q) < 0
    };
    let axis = [largest, (largest + 1) % 3, (largest + 2) % 3].into_iter().find(is_seen);
    let axis = axis.unwrap_or(largest);
    let mut up = *r;
    up[axis] = if up[axis] == 0.0 { 1.0 } else { 0.0 };
    [*r, *s, up]
}

/// Whether a point lies on the segment from p to q, and is none of its ends.
fn is_between<C: Scalar>(point: &[C; 3], p: &[C; 3], q: &[C; 3]) -> bool {
    // Lexicographic order is monotone along a line.
    let is_in_order = (p < point && point < q) || (q < point && point < p);
    let is_on_line = |axis: usize| {
        let [p, q, point] = flat(&[*p, *q, *point], axis);
        orient2d(&p, &q, &point) == 0
    };
    is_in_order && (0..3).all(is_on_line)
}

/// The region of a triangle with an area that holds a point of its plane.
fn region_of_point<C: Scalar>(point: &[C; 3], t: &[[C; 3]; 3]) -> Option<usize> {
    let seen = projection::<Exact<C>>(t)??;
    let (corners, [point]) = (flat(t, seen.axis), flat(&[*point], seen.axis));
    let turn = |from: usize| orient2d(&corners[from], &corners[(from + 1) % 3], &point) * seen.turn;
    region_of_turns(turn)
}

/// The region of a point by the sides of the three edges on which it is, 1 being the inner one; `None` if it is outside.
fn region_of_turns(turn: impl Fn(usize) -> i32) -> Option<usize> {
    let mut on_edges = 0_u8;
    for edge in 0..3 {
        match turn(edge) {
            0 => on_edges |= 1 << edge,
            inner if inner < 0 => return None,
            _ => {}
        }
    }
    match on_edges {
        0 => Some(FACE),
        edges => Region::ALL.iter().position(|region| region.edges() == edges),
    }
}

#[cfg(test)]
mod tests;
