//! Certification of one-rings for the positions of a mesh: all of them, or those near vertices that have moved.
//!
//! The sign of a normal along an axis is that of a 2×2 determinant of coordinate differences in f32. Each of its two
//! products carries a relative error below (1+u)^4 − 1 with u = 2^-24, so 8.02u · mx · my with the largest
//! differences mx and my along the other two axes bounds the error, and underflow adds less than the smallest normal
//! number. Beyond that bound the sign is certified.
//!
//! Turns are counted without rounding. A sector is less than half a turn, so a ring that goes round the vertex once crosses
//! the plane through the vertex across each of the two other axes once upwards and once downwards, which comparisons
//! of coordinates tell. A row that crosses one of these planes once at most makes less than a full turn.

use super::{CERTIFIED, Certified, OneRing, OneRings, RING};
use crate::Mesh;
use crate::bvh::Join;
use crate::index::{at, at_mut, range};
use crate::vertex_set::{Moved, holds, holds_any, mark, moved_bound, number, vertices};
use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use glam::Vec3A;

/// Options of [`OneRings::certify`].
#[derive(Clone, Copy, Default)]
pub struct CertifyOptions<'a> {
    /// Runs two tasks, side by side if it can, as `rayon::join` does. The certificates are the same. One task is as
    /// large as 8192 vertices, and where triangles near one another in the mesh have vertices that are not, there
    /// is only one.
    pub join: Option<&'a Join<'a>>,
    /// Certifies only the one-rings near these vertices anew. They must contain all that have moved since the last
    /// certification, by [`mark_moved`](crate::bvh::mark_moved), else a query may miss pairs.
    pub moved: Option<&'a [Moved]>,
}

impl OneRings<'_> {
    /// Certifies the one-rings for the positions of a mesh.
    ///
    /// If the triangles of the mesh are not those of [`OneRings::new`], nothing is certified.
    ///
    /// # Complexity
    /// O(vertices + triangles); with [`CertifyOptions::moved`],
    /// O(m + vertices / 32 + triangles / 64) for m triangles in runs of 64 that hold a vertex which has moved, or a
    /// neighbour of one.
    pub fn certify<'m>(
        &'m mut self,
        mesh: Mesh<'m>,
        options: &CertifyOptions<'_>,
    ) -> Certified<'m> {
        let (positions, triangles) = (mesh.positions(), mesh.triangles());
        let Self { rings, spans, near, .. } = self;
        let same = core::ptr::eq(triangles, self.triangles) || triangles == self.triangles;
        if !same || rings.len() != positions.len() {
            rings.iter_mut().for_each(OneRing::clear);
            return Certified { mesh, rings: &[] };
        }
        let run = Run { spans, triangles };
        let is_set = |moved: &&[Moved]| moved.len() >= moved_bound(positions.len());
        match options.moved.filter(is_set) {
            Some(moved) => run.certify_moved(positions, moved, near, rings),
            None => {
                let reached = spans.iter().map(|span| span.parts().len()).sum::<usize>();
                let join = options.join.filter(|_| reached <= MAX_REACH * spans.len());
                Pass { positions, join }.certify(0, rings, run);
            }
        }
        Certified { mesh, rings }
    }
}

/// Vertices of a task that is worth another thread: a tenth of a millisecond.
const PART: usize = 8192;
/// The most parts that a span may reach into, on average, for parts to be worth it.
const MAX_REACH: usize = 2;

/// Certification of all one-rings.
struct Pass<'p> {
    positions: &'p [[f32; 3]],
    join: Option<&'p Join<'p>>,
}

impl Pass<'_> {
    /// Certifies the one-rings of the vertices from `first` on, by those triangles of `run` that reach them.
    fn certify(&self, first: usize, rings: &mut [OneRing], run: Run<'_>) {
        let half = rings.len().div_ceil(2).next_multiple_of(PART);
        if let Some(join) = self.join
            && half < rings.len()
        {
            let run = run.reaching(first..first + rings.len());
            let (low, high) = rings.split_at_mut(half);
            let mut low = || self.certify(first, low, run);
            return join(&mut low, &mut || self.certify(first + half, high, run));
        }
        let part = first..first + rings.len();
        rings.iter_mut().for_each(OneRing::clear);
        let spans = run.spans.iter().zip(run.triangles.chunks(SPAN));
        for (_, triangles) in spans.filter(|(span, _)| span.reaches(&part)) {
            for t in triangles {
                add(self.positions, t, rings, first, |_| true);
            }
        }
        rings.iter_mut().for_each(OneRing::certify);
    }
}

/// Consecutive triangles, with a span for each [`SPAN`] of them.
#[derive(Clone, Copy)]
struct Run<'r> {
    spans: &'r [Span],
    triangles: &'r [[u32; 3]],
}

impl Run<'_> {
    /// The spans from the first to the last that reach some vertices.
    fn reaching(self, part: Range<usize>) -> Self {
        let Self { spans, triangles } = self;
        let reaches = |span: &Span| span.reaches(&part);
        let first = spans.iter().position(reaches).unwrap_or(spans.len());
        let end = spans.iter().rposition(reaches).map_or(first, |last| last + 1);
        let [from, to] = [first, end].map(|span| (span * SPAN).min(triangles.len()));
        let spans = range(spans, first as u32, (end - first) as u32);
        Self { spans, triangles: range(triangles, from as u32, (to - from) as u32) }
    }

    /// Certifies the one-rings of vertices that share a triangle with one that has moved, or have moved.
    fn certify_moved(
        self,
        positions: &[[f32; 3]],
        moved: &[Moved],
        near: &mut [Moved],
        rings: &mut [OneRing],
    ) {
        near.fill(Moved::default());
        self.for_each_with(moved, |t| t.iter().for_each(|&vertex| mark(near, vertex)));
        number(near);
        vertices(near).for_each(|vertex| at_mut(rings, vertex).clear());
        self.for_each_with(near, |t| add(positions, t, rings, 0, |vertex| holds(near, vertex)));
        vertices(near).for_each(|vertex| at_mut(rings, vertex).certify());
    }

    /// Calls `visit` for each triangle that has a vertex of the set.
    #[inline(always)]
    fn for_each_with(self, set: &[Moved], mut visit: impl FnMut(&[u32; 3])) {
        let spans = self.spans.iter().zip(self.triangles.chunks(SPAN));
        for (_, triangles) in spans.filter(|(span, _)| holds_any(set, span.0)) {
            let any = |t: &&[u32; 3]| t.iter().any(|&vertex| holds(set, vertex));
            triangles.iter().filter(any).for_each(&mut visit);
        }
    }
}

/// How many consecutive triangles have one [`Span`].
const SPAN: usize = 64;

/// Returns the number of spans of so many triangles.
pub(super) const fn span_bound(triangles: usize) -> usize {
    triangles.div_ceil(SPAN)
}

/// The smallest and the largest vertex index of some consecutive triangles.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Span([u32; 2]);

impl Span {
    pub(super) fn find(triangles: &[[u32; 3]], spans: &mut [Self]) {
        for (span, triangles) in spans.iter_mut().zip(triangles.chunks(SPAN)) {
            let all = triangles.as_flattened().iter();
            span.0 = all.fold([u32::MAX, 0], |[first, last], &v| [first.min(v), last.max(v)]);
        }
    }

    /// The parts whose vertices lie within the span.
    fn parts(self) -> Range<usize> {
        let [first, last] = self.0.map(|vertex| vertex as usize / PART);
        first..last + 1
    }

    fn reaches(self, vertices: &Range<usize>) -> bool {
        let [first, last] = self.0.map(|vertex| vertex as usize);
        first < vertices.end && vertices.start <= last
    }
}

/// While a one-ring is being certified, six bits from here on say which signs are not certified for all of its
/// triangles: those of [`uncertified_signs`]. Below, each coordinate has four bits for the times that the ring crosses
/// the plane through the vertex upwards, and four for downwards.
const SIGNS: u32 = 24;

impl OneRing {
    /// Applies the theorem, once all triangles are added.
    fn certify(&mut self) {
        let turns_once = |coordinate: u32| {
            let [up, down] = [0, 4].map(|shift| self.0 >> (8 * coordinate + shift) & 15);
            if self.0 & RING != 0 { up == 1 } else { up + down <= 1 }
        };
        let once = (0..3).fold(0, |bits, k| bits | u32::from(turns_once(k)) << k);
        let uncertified = self.0 >> SIGNS;
        let same_sign = !(uncertified & uncertified >> 3) & 7;
        // Turns about an axis are counted along either of the other two.
        let turned = (once << 1 | once >> 2) | (once << 2 | once >> 1);
        let certified = self.is_connected() && same_sign & turned != 0;
        self.clear();
        self.0 |= if certified { CERTIFIED } else { 0 };
    }
}

/// Adds a triangle to those one-rings of its corners that are `due`. `rings` begins with the one of vertex `first`.
#[inline(always)]
fn add(
    positions: &[[f32; 3]],
    t: &[u32; 3],
    rings: &mut [OneRing],
    first: usize,
    due: impl Fn(u32) -> bool,
) {
    let [p, q, r] = t.map(|vertex| Vec3A::from_array(*at(positions, vertex)));
    let signs = uncertified_signs(q - p, r - p) << SIGNS;
    // Around a corner, the triangle goes from the next corner to the one after.
    let above = |x: Vec3A, y: Vec3A| x.cmpge(y).bitmask();
    let corners =
        [[above(q, p), above(r, p)], [above(r, q), above(p, q)], [above(p, r), above(q, r)]];
    for (&vertex, [from, to]) in t.iter().zip(corners) {
        // Vertices of another part are not ours to certify.
        let Some(ring) = rings.get_mut((vertex as usize).wrapping_sub(first)) else { continue };
        if ring.is_connected() && due(vertex) {
            let up = SPREAD[(!from & to) as usize & 7];
            let down = SPREAD[(from & !to) as usize & 7] << 4;
            ring.0 = ring.0.wrapping_add(up + down) | signs;
        }
    }
}

/// Each of three bits in a byte of its own.
const SPREAD: [u32; 8] = [0, 1, 0x100, 0x101, 0x1_0000, 0x1_0001, 0x1_0100, 0x1_0101];

/// Bit k is set if the coordinate k of the normal u × v is not certified to be positive, and bit k + 3 if it is not
/// certified to be negative.
#[inline]
fn uncertified_signs(u: Vec3A, v: Vec3A) -> u32 {
    const BOUND: f32 = 4.9e-7;
    /// 2^60: products of two stay far from overflow.
    const MAX_DIFFERENCE: f32 = 1.152_921_5e18;
    let extent = u.abs().max(v.abs());
    if extent.max_element() > MAX_DIFFERENCE {
        return 0x3f;
    }
    let normal = u.cross(v);
    let bound = Vec3A::new(extent.y * extent.z, extent.z * extent.x, extent.x * extent.y) * BOUND
        + Vec3A::splat(f32::MIN_POSITIVE);
    let (positive, negative) = (normal.cmpgt(bound).bitmask(), normal.cmplt(-bound).bitmask());
    !(positive | negative << 3) & 0x3f
}
