//! The triangles of a leaf that move, in vector lanes: which pairs of two leaves are certainly apart all the time, and which meet at the start.
//!
//! A leaf pair is decided like one at rest (`cull`): boxes first, at a common time, then what f32 certifies. Two triangles that share no
//! vertex are apart if
//!
//! - all corners of one are strictly on one side of the plane of the other, all the time: heights along a normal that moves with its face are
//!   cubics of time, and a cubic is positive where its Bernstein coefficients are; or
//! - a direction that stands still separates them at the start and at the end, and so between: the line between the middles of both.
//!
//! Triangles of one mesh that share a vertex have no more in common if the same holds for all corners but that one, the direction leaving it
//! between both; and two that share an edge if the angle between them is never less than a right one: the product of their normals, which look
//! to the same side of a surface, is positive, a quartic of time.
//!
//! # The bounds
//! Let u = 2^-24 and x, y, z the extents: the largest differences of corners at either end that go into a coefficient, along each axis. A
//! coefficient of a cubic has six products of three differences, each off by 8 u, or eighteen over 3, each off by 12 u: by less than 73 u xyz
//! in all. Three times the bound of [`crate::exact::filter32`] is 144 u. A height along a direction n is off by 4 u (|n_x| x + |n_y| y + |n_z| z),
//! and what compares two of them by 10 u: the margin is 24 u. Coefficients of the product of two normals are off by 68 u (x²y² + y²z² + z²x²),
//! as those in f64 in `motion`; the margin is 128 u, for extents up to 2^30, where nothing overflows.
//!
//! Within a distance d, heights have to exceed d times the length of the direction as well: of a normal that moves, d times the longest that it gets,
//! which is at most that of its longest Bernstein coefficient. Coefficients are off by 10 u (xy + yz + zx), and by less than the smallest normal number for
//! what underflows. Triangles that share a vertex are apart by so much more than they need to be.

use super::block::{BlockCache, TriangleBlock};
use super::cull::PairSets;
use super::planes::{Planes, error_bound, longest};
use super::{Bvtt, TrianglePair};
use crate::exact::filter32::UNDERFLOW;
use crate::simd::point8::{abs, chunk_starts, cross, difference, dot, highest, load, splat, sum};
use crate::simd::{LANES, Simd};
use crate::triangle::Adjacency;

/// u of f32.
const UNIT: f32 = 5.960_464_5e-8;
/// The largest extent for which the product of two normals is bounded: 2^30.
const MAX_FOLD: f32 = 1_073_741_824.0;

/// The triangles of a leaf at the start and at the end.
#[derive(Clone, Copy)]
pub(crate) struct MovingBlock<'b>(pub(super) [&'b TriangleBlock; 2]);

/// The blocks of the leaves that one side of a traversal visited last, at the start and at the end.
pub(crate) struct MovingBlocks([BlockCache; 2]);

impl MovingBlocks {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([BlockCache::new(), BlockCache::new()])
    }

    /// The block of a leaf of one side of two queries.
    #[inline(always)]
    pub(crate) fn get<S: Simd, const SELF: bool>(
        &mut self,
        node: u32,
        side: usize,
        [start, end]: [&Bvtt<'_, SELF>; 2],
    ) -> MovingBlock<'_> {
        let Self([of_start, of_end]) = self;
        MovingBlock([
            of_start.get::<S, SELF>(node, start.side(side), start.shared()),
            of_end.get::<S, SELF>(node, end.side(side), end.shared()),
        ])
    }
}

impl MovingBlock<'_> {
    /// The triangles in two lanes.
    pub(crate) fn pair(self, other: Self, [i, j]: [usize; 2]) -> TrianglePair {
        let triangle = |block: Self, lane: usize| block.0[0].triangles[lane % LANES];
        TrianglePair { a: triangle(self, i), b: triangle(other, j) }
    }

    /// Tests the `allowed` pairs with the triangles of `other`: pairs whose boxes overlap at a time, hits that cross at the start, and open pairs.
    /// Boxes reach farther by a growth at the start and at the end. Pairs within a distance are asked for; without one, only boxes are compared.
    #[inline(always)]
    pub(crate) fn cull<S: Simd, const SELF: bool>(
        self,
        other: Self,
        allowed: u64,
        adjacency: Adjacency,
        growth: Option<[[f32; 3]; 2]>,
        distance: Option<f32>,
    ) -> PairSets {
        let mut pairs = PairSets::default();
        let [start, end] = self.0;
        let bounds = [start.around::<S>(), end.around()];
        let mut rows = other.overlapping(&grown(bounds, growth));
        while rows != 0 {
            let j = rows.trailing_zeros() as usize % LANES;
            rows &= rows - 1;
            let shift = LANES * j;
            let [start, end] = other.0;
            let start = [splat::<S>(&start.min, j), splat(&start.max, j)];
            let bounds = [start, [splat(&end.min, j), splat(&end.max, j)]];
            let found = self.overlapping(&grown(bounds, growth)) & (allowed >> shift & 0xff) as u32;
            pairs.overlapping |= u64::from(found) << shift;
            let Some(distance) = distance else {
                pairs.open = pairs.overlapping;
                continue;
            };
            for at in chunk_starts::<S>() {
                let left = found >> at & (u32::MAX >> (u32::BITS as usize - S::WIDTH));
                if left == 0 {
                    continue;
                }
                let [hits, open, sharing] =
                    self.decide::<S, SELF>(other, [at, j], left, adjacency, distance);
                pairs.hits |= u64::from(hits) << (shift + at);
                pairs.open |= u64::from(open) << (shift + at);
                pairs.may_share_vertex |= u64::from(sharing) << (shift + at);
            }
        }
        pairs
    }

    /// Lanes whose box overlaps another at a time, both given at the start and at the end.
    ///
    /// On each axis the gap on either side is linear in time, so that each of six conditions leaves an interval of time. Signs of
    /// differences are exact, and quotients within 4 u.
    #[inline(always)]
    fn overlapping<S: Simd>(self, ends: &[[[S; 3]; 2]; 2]) -> u32 {
        let (mut found, zero) = (0, S::splat(0.0));
        for at in chunk_starts::<S>() {
            let starts = gaps(self.0[0], at, &ends[0]);
            let ends = gaps(self.0[1], at, &ends[1]);
            let (mut first, mut last) = (zero, S::splat(1.0));
            let mut meet = zero.le(zero);
            for (start, end) in starts.into_iter().zip(ends) {
                let (at_start, at_end) = (start.le(zero), end.le(zero));
                meet = meet & (at_start | at_end);
                let time = start / (start - end);
                first = S::select(&at_start, first, first.max(time));
                last = S::select(&at_end, last, last.min(time));
            }
            let last = last * S::splat(1.0 + 16.0 * UNIT) + S::splat(f32::MIN_POSITIVE);
            meet = meet & (first * S::splat(1.0 - 16.0 * UNIT)).le(last);
            found |= S::bits(meet) << at;
        }
        found & self.0[0].occupied_mask()
    }

    /// Lanes among those `left` from `at` on that certainly meet triangle `j` of `other` at the start; lanes that may meet it; and those of these that
    /// share a vertex with it.
    #[inline(always)]
    fn decide<S: Simd, const SELF: bool>(
        self,
        other: Self,
        [at, j]: [usize; 2],
        mut left: u32,
        adjacency: Adjacency,
        distance: f32,
    ) -> [u32; 3] {
        let [start, end] = self.0;
        let own = Moving::<S>::new(Planes::load(start, at, None), Planes::load(end, at, None));
        let [start, end] = other.0;
        let others = Moving::new(Planes::splat(start, j, None), Planes::splat(end, j, None));
        let (shared, mut neighbours) = (SharedCorners::new(&own, &others), 0);
        if SELF {
            neighbours = left & shared.any();
        }
        if adjacency == Adjacency::SkipNeighbours {
            left &= !neighbours;
        }
        let sharing = neighbours != 0;
        left &= !own.holds_apart(&others, sharing, &shared.of_other, distance);
        if left != 0 {
            left &= !others.holds_apart(&own, sharing, &shared.of_own, distance);
        }
        if left & neighbours != 0 {
            left &= !(S::bits(shared.opposite) & own.have_obtuse_angle(&others));
        }
        if left != 0 {
            left &= !own.is_separated(&others, sharing, &shared, distance);
        }
        let distinct = left & !neighbours;
        let mut hits = 0;
        // One lane alone gains nothing over the test of two triangles.
        if S::WIDTH > 1 && distinct != 0 {
            let ([p, _], [q, _]) = (&own.ends, &others.ends);
            let (of_q, of_p) = (p.heights(q), q.heights(p));
            let crossing =
                distinct & !p.separates::<false>(q, &of_q, 0) & !q.separates::<false>(p, &of_p, 0);
            if crossing != 0 {
                hits = p.decide(q, &of_p, &of_q, crossing)[0];
            }
        }
        [hits, left & !hits, left & neighbours]
    }
}

/// The gaps on either side of other boxes.
#[inline(always)]
fn gaps<S: Simd>(block: &TriangleBlock, at: usize, [low, high]: &[[S; 3]; 2]) -> [S; 6] {
    let [x, y, z] = difference(*low, load::<S>(&block.max, at));
    let [u, v, w] = difference(load::<S>(&block.min, at), *high);
    [x, y, z, u, v, w]
}

/// Boxes at both ends with their lower corners lowered by the errors, and the upper ones raised.
#[inline(always)]
fn grown<S: Simd>(
    [start, end]: [[[S; 3]; 2]; 2],
    errors: Option<[[f32; 3]; 2]>,
) -> [[[S; 3]; 2]; 2] {
    let Some([[a, b, c], [d, e, f]]) = errors else { return [start, end] };
    let of_start = [S::splat(a), S::splat(b), S::splat(c)];
    let of_end = [S::splat(d), S::splat(e), S::splat(f)];
    [
        [difference(start[0], of_start), sum(start[1], of_start)],
        [difference(end[0], of_end), sum(end[1], of_end)],
    ]
}

/// A triangle in each lane that moves.
struct Moving<S> {
    /// The triangle at the start and at the end.
    ends: [Planes<S>; 2],
    /// The Bernstein coefficients of the normal, the second of them twice.
    normal: [[S; 3]; 3],
    /// For each axis, the largest extent of the edges from the first corner at either end.
    extent: [S; 3],
}

/// Corners of one triangle from the first corner of another, at the start and at the end, and the extent of both along each axis.
struct Relative<S> {
    ends: [[[S; 3]; 3]; 2],
    extent: [S; 3],
}

impl<S: Simd> Moving<S> {
    #[inline(always)]
    fn new(start: Planes<S>, end: Planes<S>) -> Self {
        let ([p, q, r], [t, u, v]) = (start.corners, end.corners);
        let ([g, h], [i, j]) =
            ([difference(q, p), difference(r, p)], [difference(u, t), difference(v, t)]);
        let normal = [start.normal, sum(cross(g, j), cross(i, h)), end.normal];
        let extent = highest(start.extent, end.extent);
        Self { ends: [start, end], normal, extent }
    }

    #[inline(always)]
    fn relative(&self, other: &Self) -> Relative<S> {
        let [start, end] = &other.ends;
        let (mut ends, mut extent) = ([start.corners, end.corners], self.extent);
        for (end, own) in ends.iter_mut().zip(&self.ends) {
            for corner in end {
                *corner = difference(*corner, own.corners[0]);
                extent = highest(extent, abs(*corner));
            }
        }
        Relative { ends, extent }
    }

    /// The height over this plane, along its normal, of a point at a distance, at the most.
    #[inline(always)]
    fn height_of(&self, distance: f32) -> S {
        let ([n, middle, n_end], [x, y, z]) = (self.normal, self.extent);
        let length = longest(n).max(longest(middle) * S::splat(0.5)).max(longest(n_end));
        let error = (x * y + y * z + z * x) * S::splat(16.0 * UNIT);
        let smallest = S::splat(f32::MIN_POSITIVE);
        (length + error + smallest) * S::splat(distance) + smallest
    }

    /// Lanes in which all corners of `other`, but those that are `shared`, are certainly strictly on one side of this plane all the time.
    #[inline(always)]
    fn holds_apart(
        &self,
        other: &Self,
        sharing: bool,
        shared: &[S::Mask; 3],
        distance: f32,
    ) -> u32 {
        let Relative { ends: [start, end], extent } = self.relative(other);
        let mut bound = error_bound(extent, None) * S::splat(3.0);
        if distance > 0.0 {
            bound = (bound + self.height_of(distance)) * S::splat(1.000_001);
        }
        let [n, middle, n_end] = self.normal;
        let (third, infinity) = (S::splat(1.0 / 3.0), S::splat(f32::INFINITY));
        let (mut low, mut high) = (infinity, S::splat(f32::NEG_INFINITY));
        for corner in 0..3 {
            let (w, w_end) = (start[corner], end[corner]);
            let first = dot(n, w);
            let second = (dot(middle, w) + dot(n, w_end)) * third;
            let third = (dot(n_end, w) + dot(middle, w_end)) * third;
            let last = dot(n_end, w_end);
            let mut least = first.min(second).min(third.min(last));
            let mut most = first.max(second).max(third.max(last));
            if sharing {
                least = S::select(&shared[corner], infinity, least);
                most = S::select(&shared[corner], S::splat(f32::NEG_INFINITY), most);
            }
            (low, high) = (low.min(least), high.max(most));
        }
        let apart = bound.le(low) | high.le(S::splat(0.0) - bound);
        if !sharing {
            return S::bits(apart);
        }
        // Where all are shared, none is on a side.
        let [p, q, r] = *shared;
        S::bits(apart) & !S::bits(p & q & r)
    }

    /// Lanes in which the line between the middles of both certainly separates the triangles at the start and at the end, but for one vertex that
    /// they share, which is then between both.
    #[inline(always)]
    fn is_separated(
        &self,
        other: &Self,
        sharing: bool,
        shared: &SharedCorners<S>,
        distance: f32,
    ) -> u32 {
        let (Relative { ends: others, extent }, own) =
            (self.relative(other), self.relative(self).ends);
        let mut n = [S::splat(0.0); 3];
        for (others, own) in others.iter().zip(&own) {
            for (p, q) in own.iter().zip(others) {
                n = sum(n, difference(*q, *p));
            }
        }
        let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_FOLD));
        let mut margin = dot(abs(n), extent) * S::splat(24.0 * UNIT) + S::splat(UNDERFLOW);
        if distance > 0.0 {
            margin = (margin + longest(n) * S::splat(distance)) * S::splat(1.000_001);
        }
        let mut apart = holds;
        let infinity = [S::splat(f32::INFINITY), S::splat(f32::NEG_INFINITY)];
        for (others, own) in others.iter().zip(&own) {
            let [mut end, mut begin] = [infinity[1], infinity[0]];
            // The shared vertex, if there is one: the least and the greatest height.
            let mut between = infinity;
            for corner in 0..3 {
                let [mut of_own, mut of_other] = [dot(n, own[corner]), dot(n, others[corner])];
                if sharing {
                    let (is_own, is_other) = (&shared.of_own[corner], &shared.of_other[corner]);
                    between = [
                        between[0].min(S::select(is_own, of_own, infinity[0])),
                        between[1].max(S::select(is_own, of_own, infinity[1])),
                    ];
                    of_own = S::select(is_own, infinity[1], of_own);
                    of_other = S::select(is_other, infinity[0], of_other);
                }
                (end, begin) = (end.max(of_own), begin.min(of_other));
            }
            apart = apart & (end + margin).le(begin.min(between[0]));
            if sharing {
                apart = apart & (between[1] + margin).le(begin);
            }
        }
        S::bits(apart) & if sharing { !shared.several() } else { u32::MAX }
    }

    /// Lanes in which the product of both normals is certainly positive all the time: where triangles go along a shared edge in opposite directions, the
    /// angle between them is obtuse.
    #[inline(always)]
    fn have_obtuse_angle(&self, other: &Self) -> u32 {
        let ([a, b, c], [p, q, r]) = (self.normal, other.normal);
        let extent = highest(self.extent, other.extent);
        let (quarter, sixth) = (S::splat(0.25), S::splat(1.0 / 6.0));
        let outer = dot(a, p).min(dot(c, r));
        let inner = (dot(a, q) + dot(b, p)).min(dot(b, r) + dot(c, q)) * quarter;
        let least = outer.min(inner).min((dot(a, r) + dot(b, q) + dot(c, p)) * sixth);
        let [x, y, z] = [extent[0] * extent[0], extent[1] * extent[1], extent[2] * extent[2]];
        let margin = (x * y + y * z + z * x) * S::splat(128.0 * UNIT) + S::splat(UNDERFLOW);
        let holds = extent[0].max(extent[1]).max(extent[2]).le(S::splat(MAX_FOLD));
        S::bits(holds & margin.le(least))
    }
}

/// Corners of two triangles that are the same vertices of a mesh.
struct SharedCorners<S: Simd> {
    of_own: [S::Mask; 3],
    of_other: [S::Mask; 3],
    /// Lanes that share an edge, which both go along in opposite directions.
    opposite: S::Mask,
}

impl<S: Simd> SharedCorners<S> {
    #[inline(always)]
    fn new(own: &Moving<S>, other: &Moving<S>) -> Self {
        let ([p, q, r], [u, v, w]) = (own.ends[0].vertices, other.ends[0].vertices);
        // Each corner of the one, and of the other.
        let (pu, pv, pw) = (p.eq(u), p.eq(v), p.eq(w));
        let (qu, qv, qw) = (q.eq(u), q.eq(v), q.eq(w));
        let (ru, rv, rw) = (r.eq(u), r.eq(v), r.eq(w));
        Self {
            of_own: [pu | pv | pw, qu | qv | qw, ru | rv | rw],
            of_other: [pu | qu | ru, pv | qv | rv, pw | qw | rw],
            opposite: (pv & qu | pw & qv | pu & qw)
                | (qv & ru | qw & rv | qu & rw)
                | (rv & pu | rw & pv | ru & pw),
        }
    }

    #[inline(always)]
    fn any(&self) -> u32 {
        let [p, q, r] = self.of_own;
        S::bits(p | q | r)
    }

    /// Lanes that share more than one vertex.
    #[inline(always)]
    fn several(&self) -> u32 {
        let [p, q, r] = self.of_own;
        S::bits(p & q | q & r | r & p)
    }
}
