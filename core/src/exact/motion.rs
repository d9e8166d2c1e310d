//! Whether two moving triangles meet, interval of time by interval, in integers: exact for any coordinates that fit.
//!
//! Time is cut into intervals whose ends are multiples of a power of two. Multiplied by it, the corners at both ends of one are integers. In one
//! interval triangles are certainly
//!
//! - apart if a direction separates them at both ends: the heights of one above the other are linear in time. Directions are differences
//!   of two corners, or of a corner and its foot on an edge, in the middle of the interval;
//! - apart if the normal of a face or of two edges, which moves with these, separates them: heights are cubics of time, positive where their
//!   Bernstein coefficients are not negative and those at the ends positive;
//! - meeting if such a cubic has no strict sign at both ends, and the corner is in the face, or both edges cross, all through the interval, seen
//!   along an axis along which the face, or the plane of both edges, is never seen edge-on: turns are quadratics of time.
//!
//! Triangles that are apart have a shortest connection at each time, between two of these features, and its direction separates them with room
//! to spare; so for short enough intervals one of the first two holds, since both depend continuously on the interval. Open is
//! left only whether triangles meet that touch and do not pass, or that move in one plane for ever; and of those that pass each other at a gap far
//! below rounding errors of f64, any for which the shortest intervals are too long: 2^-96 for coordinates of up to 284 bits. None is known.
//!
//! Scaling an axis changes neither, hence each axis has a unit of its own.

use super::integer::Axis;
use super::wide::Wide;
use crate::triangle::{Feature, features};

/// Limbs for coordinates of up to 68 bits: those of most meshes are shorter.
const LIMBS: usize = 8;

/// Limbs for coordinates of up to 116 bits.
const MORE_LIMBS: usize = 11;

/// Limbs for any f32, whose coordinates have up to 278 bits. Triangles in f64 with more than 356 bits are not decided.
const MOST_LIMBS: usize = 24;

/// Times are counted in units of 2^-96, the length of the shortest intervals. Two of 77,000 grazing pairs needed shorter ones than 2^-60.
const DEEPEST: u32 = 96;

/// The end of the motion.
const END: u128 = 1 << DEEPEST;

/// Few limbs are tried if they suffice for intervals as short as 2^-56; what these leave open is asked of most, unless the
/// triangles meet at the end.
const DEEP: u32 = 56;

/// The first interval is 2^-24 long.
const FIRST: u32 = 24;

/// Triangles are said to meet in an interval no longer than 2^-20.
const SHORT: u32 = 20;

/// Intervals after which a pair is left open.
const INTERVALS: usize = 512;

/// The answer about two moving triangles that are apart until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// They do not meet.
    Apart,
    /// They do not meet before `from`, and certainly meet before `to`; if it is infinite, that is open.
    Near { from: f64, to: f64 },
}

type Vector<const L: usize> = [Wide<L>; 3];

/// The corners of both triangles: 0 to 2 are those of the first, 3 to 5 those of the second.
type Corners<const L: usize> = [Vector<L>; 6];

/// A search that has not ended: the triangles are apart until a time, and nothing is proven in the interval from there on.
struct Open {
    time: u128,
    /// The level of the interval, where shorter ones may go on; none if as many intervals were tried as may be.
    level: Option<u32>,
}

/// Two moving triangles of which integers decide.
pub(crate) struct Question<'q> {
    /// The corners of the first triangle at the start and at the end, then those of the second.
    pub(crate) corners: [&'q [[f64; 3]; 3]; 4],
    /// How many corners differ: a segment is given by its second corner twice, a point by thrice the same.
    pub(crate) count: [usize; 2],
    /// A time until which they are apart.
    pub(crate) from: f64,
    /// Until when they are certainly apart, by other means, if they are so until a time.
    pub(crate) resume: &'q dyn Fn(f64) -> f64,
    /// Whether they meet at the end.
    pub(crate) meet_at_end: &'q dyn Fn() -> bool,
}

impl Question<'_> {
    /// Goes through intervals of time from `from` on, shorter ones where nothing is proven.
    #[cold]
    #[inline(never)]
    pub(crate) fn answer(&self) -> Verdict {
        // Both triangles at the start, then at the end.
        let axes = [0, 1, 2].map(|axis| {
            let corner = |k: usize| self.corners[k / 6 + k % 6 / 3 * 2][k % 3][axis];
            Axis::new(core::array::from_fn(corner))
        });
        let bits = axes.iter().map(Axis::bits).max().unwrap_or(0);
        let levels = |limbs| deepest(limbs, bits);
        let start = (self.from * END as f64) as u128;
        let few = match (levels(LIMBS), levels(MORE_LIMBS)) {
            (DEEP.., _) => Some(self.search::<LIMBS>(&axes, start, FIRST, DEEP)),
            (_, DEEP..) => Some(self.search::<MORE_LIMBS>(&axes, start, FIRST, DEEP)),
            _ => None,
        };
        let deepest = levels(MOST_LIMBS);
        let most = |time, level| self.search::<MOST_LIMBS>(&axes, time, level, deepest);
        let answer = match few {
            None if deepest < FIRST => Err(Open { time: start, level: None }),
            None => most(start, FIRST),
            // Many that are open so deep meet no sooner than at the end, which is quickly told.
            Some(Err(Open { time, level: Some(level) }))
                if level < deepest && !(self.meet_at_end)() =>
            {
                most(time, level)
            }
            Some(answer) => answer,
        };
        answer.unwrap_or_else(|open| Verdict::Near {
            from: rounded_down(open.time).max(self.from),
            to: f64::INFINITY,
        })
    }

    /// Goes through intervals from a time on, the first of a level, as deep as another.
    #[inline(never)]
    fn search<const L: usize>(
        &self,
        axes: &[Axis<12>; 3],
        mut time: u128,
        mut level: u32,
        deepest: u32,
    ) -> Result<Verdict, Open> {
        let mut ends: [Corners<L>; 2] = [[[Wide::new(0, 0); 3]; 6]; 2];
        fill(&mut ends, axes);
        let mut interval = Interval { ends, count: self.count };
        let mut growth = 1;
        let mut last = Direction::Normal(Feature::Face { of: 0, corner: 0 });
        for _ in 0..INTERVALS {
            interval.cut(&ends, time, level);
            let until = ((time >> (DEEPEST - level)) + 1) << (DEEPEST - level);
            let mut directions = core::iter::once(last).chain(interval.directions());
            if let Some(direction) = directions.find(|&d| interval.is_separated(d)) {
                last = direction;
                let resumed = (self.resume)(rounded_down(until));
                if until == END || resumed >= 1.0 {
                    return Ok(Verdict::Apart);
                }
                time = until.max((resumed * END as f64) as u128);
                (level, growth) = (level.saturating_sub(growth), 2 * growth);
            } else if level >= SHORT && interval.certainly_meet() {
                let to = rounded_up(until);
                return Ok(Verdict::Near { from: rounded_down(time).max(self.from), to });
            } else if level == deepest {
                return Err(Open { time, level: Some(level) });
            } else {
                (level, growth) = ((level + 4).min(deepest), 1);
            }
        }
        // Deeper ones would not be fewer.
        Err(Open { time, level: None })
    }
}

/// The corners at both ends of the motion, from the first of each on.
#[inline(never)]
fn fill<const L: usize>(ends: &mut [Corners<L>; 2], axes: &[Axis<12>; 3]) {
    for (end, corners) in ends.iter_mut().enumerate() {
        for (k, corner) in corners.iter_mut().enumerate() {
            for (x, axis) in corner.iter_mut().zip(axes) {
                *x = axis.difference(6 * end, 6 * end + k);
            }
        }
    }
}

/// The level of the shortest intervals for which so many limbs suffice, with coordinates of so many bits.
///
/// At level l, corners are below 2^e, e = bits + 1 + l, relative to the first one, and so are their differences. Along a direction that stands
/// still, (g·g) w − (g·w) g with vectors below 2^(e + 1), heights are below 18 · 2^(4e + 3), and their differences below 2^(4e + 9).
/// Coefficients of cubics are below 2^(3e + 6).
fn deepest(limbs: usize, bits: u32) -> u32 {
    let room = (limbs as u32 * u64::BITS - 9) / 4;
    room.saturating_sub(bits + 1).min(DEEPEST)
}

/// Parts of a time, of which each has so many values, fit an i64.
const HALF: u128 = 1 << (DEEPEST / 2);

/// A time as f64, at most so late.
fn rounded_down(time: u128) -> f64 {
    let cut = (u128::BITS - time.leading_zeros()).saturating_sub(f64::MANTISSA_DIGITS);
    (time >> cut << cut) as f64 / END as f64
}

/// A time as f64, at least so late.
fn rounded_up(time: u128) -> f64 {
    let down = rounded_down(time);
    if (down * END as f64) as u128 == time { down } else { down.next_up() }
}

/// A direction along which heights are compared.
#[derive(Clone, Copy, Debug)]
enum Direction {
    /// The normal of a face or of two edges, which moves with these.
    Normal(Feature),
    /// From the foot of a corner on an edge of the other triangle, by its first corner.
    Foot { corner: usize, edge: usize },
    /// From a corner of the first triangle to one of the second.
    Corners([usize; 2]),
}

/// Two moving triangles in an interval of time.
struct Interval<const L: usize> {
    /// The corners at both ends, times a power of two.
    ends: [Corners<L>; 2],
    count: [usize; 2],
}

/// The next corner of a triangle.
fn next(corner: usize) -> usize {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

impl<const L: usize> Interval<L> {
    /// Becomes the interval at a level that contains `time`, if that is not its end, with the corners at the start and at the end of the motion.
    #[inline(never)]
    fn cut(&mut self, [start, end]: &[Corners<L>; 2], time: u128, level: u32) {
        let (whole, passed) = (Wide::new(1, level), time >> (DEEPEST - level));
        let [low, high] = [passed % HALF, passed / HALF].map(|part| part as i64);
        let passed = Wide::new(high, HALF.ilog2()) + Wide::new(low, 0);
        for k in self.corners(0).chain(self.corners(1)).skip(1) {
            for axis in 0..3 {
                let step = end[k][axis] - start[k][axis];
                let before = start[k][axis] * whole + step * passed;
                self.ends[0][k][axis] = before;
                self.ends[1][k][axis] = before + step;
            }
        }
    }

    /// The corners of a triangle.
    fn corners(&self, of: usize) -> core::ops::Range<usize> {
        3 * of..3 * of + self.count[of]
    }

    /// The first corners of the edges of a triangle.
    fn edges(&self, of: usize) -> core::ops::Range<usize> {
        let edges = if self.count[of] == 3 { 3 } else { self.count[of] - 1 };
        3 * of..3 * of + edges
    }

    fn directions(&self) -> impl Iterator<Item = Direction> {
        let (corners, edges) = ([self.corners(0), self.corners(1)], [self.edges(0), self.edges(1)]);
        let pairs = corners[0].clone().flat_map({
            let others = corners[1].clone();
            move |i| others.clone().map(move |j| Direction::Corners([i, j]))
        });
        let feet = (0..2).flat_map(move |of: usize| {
            let edges = edges[1 - of].clone();
            corners[of].clone().flat_map(move |corner| {
                edges.clone().map(move |edge| Direction::Foot { corner, edge })
            })
        });
        // A face has one normal.
        let normals =
            features(self.count).filter(|f| !matches!(f, Feature::Face { corner: 1.., .. }));
        normals.map(Direction::Normal).chain(feet).chain(pairs)
    }

    /// A vector from a corner to another, at both ends.
    #[inline(never)]
    fn between(&self, from: usize, to: usize) -> [Vector<L>; 2] {
        let [start, end] = &self.ends;
        [minus(&start[to], &start[from]), minus(&end[to], &end[from])]
    }

    /// Whether all of the second triangle is strictly on one side of the first along a direction, all through the interval.
    #[inline(never)]
    fn is_separated(&self, direction: Direction) -> bool {
        match direction {
            Direction::Normal(Feature::Face { of, .. }) => {
                let (o, others) = (3 * of, self.corners(1 - of));
                let (u, v) = (self.between(o, o + 1), self.between(o, o + 2));
                one_sided(&u, &v, others.map(|corner| self.between(o, corner)))
            }
            Direction::Normal(Feature::Edges([k, l])) => {
                let l = l + 3;
                let (u, v) = (self.between(k, next(k)), self.between(l, next(l)));
                // A segment has no third corner.
                let beside = |k: usize, of: usize| {
                    [k, next(next(k))].into_iter().take(self.count[of].min(3) - 1)
                };
                let pairs = beside(k, 0).flat_map(|i| beside(l, 1).map(move |j| [i, j]));
                one_sided(&u, &v, pairs.map(|[i, j]| self.between(i, j)))
            }
            Direction::Foot { corner, edge } => {
                let g = sum(&self.between(edge, next(edge)));
                let w = sum(&self.between(edge, corner));
                let (length, along) = (dot(&g, &g), dot(&g, &w));
                let across = |k: usize| length * w[k] - along * g[k];
                let across = [across(0), across(1), across(2)];
                // Upwards, if the corner is of the second triangle.
                self.is_above(&across, corner / 3)
            }
            Direction::Corners([i, j]) => self.is_above(&sum(&self.between(i, j)), 1),
        }
    }

    /// Whether a triangle is strictly above the other along a direction, at both ends.
    #[inline(never)]
    fn is_above(&self, n: &Vector<L>, above: usize) -> bool {
        self.ends.iter().all(|corners| {
            let mut below = self.corners(1 - above).map(|k| dot(n, &corners[k]));
            let Some(first) = below.next() else { return false };
            let highest = below.fold(first, |x, y| if (y - x).sign() > 0 { y } else { x });
            self.corners(above).all(|k| (dot(n, &corners[k]) - highest).sign() > 0)
        })
    }

    /// Whether a corner certainly passes a face, or an edge an edge.
    #[inline(never)]
    fn certainly_meet(&self) -> bool {
        features(self.count).any(|feature| match feature {
            Feature::Face { of, corner } => {
                let (o, corner) = (3 * of, 3 - 3 * of + corner);
                let (u, v) = (self.between(o, o + 1), self.between(o, o + 2));
                let w = self.between(o, corner);
                !has_strict_sign(&u, &v, &w) && (0..3).any(|axis| self.is_inside(o, corner, axis))
            }
            Feature::Edges([k, l]) => {
                let l = l + 3;
                let (u, v) = (self.between(k, next(k)), self.between(l, next(l)));
                !has_strict_sign(&u, &v, &self.between(k, l))
                    && (0..3).any(|axis| self.cross(k, l, axis))
            }
        })
    }

    /// Whether a corner is in a face all through the interval, seen along an axis, which never sees the face edge-on.
    #[inline(never)]
    fn is_inside(&self, o: usize, corner: usize, axis: usize) -> bool {
        let side = turn(&self.between(o, o + 1), &self.between(o, o + 2), axis);
        let Some(side) = strict_sign(&side) else { return false };
        [o, o + 1, o + 2].into_iter().all(|from| {
            let turn = turn(&self.between(from, next(from)), &self.between(from, corner), axis);
            turn.iter().all(|c| c.sign() * side >= 0)
        })
    }

    /// Whether two edges cross all through the interval, seen along an axis, and never in parallel.
    #[inline(never)]
    fn cross(&self, k: usize, l: usize, axis: usize) -> bool {
        let (g, h) = (self.between(k, next(k)), self.between(l, next(l)));
        let Some(side) = strict_sign(&turn(&g, &h, axis)) else { return false };
        let is_on = |vector: &[Vector<L>; 2], from: usize, to: usize, side: i32| {
            let turn = turn(vector, &self.between(from, to), axis);
            turn.iter().all(|c| c.sign() * side >= 0)
        };
        // The second begins on the right of the first if it turns left, and ends on the left; the first begins on the left of the second.
        is_on(&g, k, l, -side)
            && is_on(&g, k, next(l), side)
            && is_on(&h, l, k, side)
            && is_on(&h, l, next(k), -side)
    }
}

/// Whether cubics have one strict sign all through the interval: the heights of some vectors along the normal of two.
#[inline(never)]
fn one_sided<const L: usize>(
    u: &[Vector<L>; 2],
    v: &[Vector<L>; 2],
    heights: impl Iterator<Item = [Vector<L>; 2]> + Clone,
) -> bool {
    let ends = [cross(&u[0], &v[0]), cross(&u[1], &v[1])];
    let mut side = 0;
    for w in heights.clone() {
        for (end, w) in ends.iter().zip(&w) {
            let own = dot(end, w).sign();
            if own == 0 || own == -side {
                return false;
            }
            side = own;
        }
    }
    if side == 0 {
        return false;
    }
    let middle = sum(&[cross(&u[0], &v[1]), cross(&u[1], &v[0])]);
    // Thrice the inner coefficients.
    heights.into_iter().all(|w| {
        let inner = |end: usize| dot(&ends[end], &w[1 - end]) + dot(&middle, &w[end]);
        [0, 1].into_iter().all(|end| inner(end).sign() * side >= 0)
    })
}

/// Whether the determinant of three vectors has the same strict sign at both ends of the interval.
#[inline(never)]
fn has_strict_sign<const L: usize>(
    u: &[Vector<L>; 2],
    v: &[Vector<L>; 2],
    w: &[Vector<L>; 2],
) -> bool {
    let sign = |end: usize| dot(&cross(&u[end], &v[end]), &w[end]).sign();
    sign(0) * sign(1) > 0
}

/// The Bernstein coefficients of the turn of two moving vectors, seen along an axis, the second of them twice.
#[inline(never)]
fn turn<const L: usize>(u: &[Vector<L>; 2], v: &[Vector<L>; 2], axis: usize) -> [Wide<L>; 3] {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let turn = |u: &Vector<L>, v: &Vector<L>| u[j] * v[k] - u[k] * v[j];
    [turn(&u[0], &v[0]), turn(&u[0], &v[1]) + turn(&u[1], &v[0]), turn(&u[1], &v[1])]
}

/// The sign of a quadratic that is never zero, by its Bernstein coefficients.
fn strict_sign<const L: usize>([start, inner, end]: &[Wide<L>; 3]) -> Option<i32> {
    let side = start.sign();
    (side != 0 && end.sign() == side && inner.sign() * side >= 0).then_some(side)
}

// Written out, since maps of arrays keep several copies of these on the stack.

#[inline(never)]
fn minus<const L: usize>(p: &Vector<L>, q: &Vector<L>) -> Vector<L> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(never)]
fn sum<const L: usize>([p, q]: &[Vector<L>; 2]) -> Vector<L> {
    [p[0] + q[0], p[1] + q[1], p[2] + q[2]]
}

#[inline(never)]
fn dot<const L: usize>(p: &Vector<L>, q: &Vector<L>) -> Wide<L> {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(never)]
fn cross<const L: usize>(p: &Vector<L>, q: &Vector<L>) -> Vector<L> {
    let minor = |j: usize, k: usize| p[j] * q[k] - p[k] * q[j];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}
