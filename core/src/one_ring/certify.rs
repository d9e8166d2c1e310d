//! Certification of one-rings for the positions of a mesh: all of them, or those near vertices that have moved.
//!
//! The sign of a normal along an axis is that of a 2×2 determinant of coordinate differences in f32. Each of its two
//! products carries a relative error below (1+u)^4 − 1 with u = 2^-24, so 8.02u · mx · my with the largest
//! differences mx and my along the other two axes bounds the error, and underflow adds less than the smallest normal
//! number. Beyond that bound the sign is certified. In f64, u is 2^-53 and underflow adds 2^-1070.
//!
//! Turns are counted without rounding. A sector is less than half a turn, so a ring that goes round the vertex once crosses
//! the plane through the vertex across each of the two other axes once upwards and once downwards, which comparisons
//! of coordinates tell. A row that crosses one of these planes once at most makes less than a full turn.

use super::{CERTIFIED, Certified, OneRing, OneRings, RING};
use crate::Mesh;
use crate::bvh::Join;
use crate::exact::filter64::{ERROR_2D, UNDERFLOW_2D};
use crate::index::{at, at_mut, part, range, split};
use crate::parallel::parts;
use crate::vertex_set::{Moved, holds, holds_any, mark, moved_bound, number, vertices};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3A, Vec3Swizzles};

/// Options of [`OneRings::certify`].
#[derive(Clone, Copy, Default)]
pub struct CertifyOptions<'a> {
    /// Runs parts of the pass side by side, as `rayon::join` does, if the one-rings have their
    /// [links](OneRings::with_links) and all are certified anew. The certificates are the same.
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
        let positions = mesh.positions();
        match mesh.f64() {
            None => self.certify_by(mesh, options, |t| turns_of(positions, t)),
            Some(f64) => self.certify_by(mesh, options, |t| (f64.turns)(mesh, t)),
        }
    }

    /// [`OneRings::certify`] by the turns of each triangle.
    fn certify_by<'m>(
        &'m mut self,
        mesh: Mesh<'m>,
        options: &CertifyOptions<'_>,
        turns: impl Fn(&[u32; 3]) -> u32 + Sync,
    ) -> Certified<'m> {
        let (vertices, triangles) = (mesh.positions().len(), mesh.triangles());
        let Self { rings, spans, near, links, .. } = self;
        let same = core::ptr::eq(triangles, self.triangles) || triangles == self.triangles;
        if !same || rings.len() != vertices {
            rings.iter_mut().for_each(OneRing::clear);
            return Certified { mesh, rings: &[] };
        }
        let run = Run { spans, triangles };
        let is_set = |moved: &&[Moved]| moved.len() >= moved_bound(vertices);
        match options.moved.filter(is_set) {
            Some(moved) => run.certify_moved(&turns, moved, near, rings),
            None if options.join.is_some() && !links.is_empty() => {
                certify_in_parts(&turns, triangles, rings, links, options.join);
            }
            None => {
                rings.iter_mut().for_each(OneRing::clear);
                triangles.iter().for_each(|t| add(turns(t), t, rings, |_| true));
                rings.iter_mut().for_each(OneRing::certify);
            }
        }
        Certified { mesh, rings }
    }
}

/// Certifies all one-rings in two passes, over triangles and over vertices, in which each item writes to a place of its own.
///
/// `links` are those of [`OneRings::with_links`]: where the corners of each vertex end, the corners, and room for a word
/// for each triangle.
fn certify_in_parts(
    turns_of: &(impl Fn(&[u32; 3]) -> u32 + Sync),
    triangles: &[[u32; 3]],
    rings: &mut [OneRing],
    links: &mut [u32],
    join: Option<&Join<'_>>,
) {
    let (ends, rest) = split(links, rings.len() + 1);
    let (corners, turns) = split(rest, 3 * triangles.len());
    parts(join, 0, turns, &|first, turns| {
        for (turns, t) in turns.iter_mut().zip(part(triangles, first..)) {
            *turns = turns_of(t);
        }
    });
    let (ends, corners, turns) = (&*ends, &*corners, &*turns);
    parts(join, 0, rings, &|first, rings| {
        let mut start = first.checked_sub(1).map_or(0, |before| *at(ends, before));
        for (ring, &end) in rings.iter_mut().zip(part(ends, first..)) {
            ring.clear();
            if ring.is_connected() {
                for corner in range(corners, start, end - start) {
                    ring.add(*at(turns, corner / 3), corner % 3);
                }
            }
            ring.certify();
            start = end;
        }
    });
}

/// Consecutive triangles, with a span for each [`SPAN`] of them.
#[derive(Clone, Copy)]
struct Run<'r> {
    spans: &'r [Span],
    triangles: &'r [[u32; 3]],
}

impl Run<'_> {
    /// Certifies the one-rings of vertices that share a triangle with one that has moved, or have moved.
    fn certify_moved(
        self,
        turns_of: &impl Fn(&[u32; 3]) -> u32,
        moved: &[Moved],
        near: &mut [Moved],
        rings: &mut [OneRing],
    ) {
        near.fill(Moved::default());
        self.for_each_with(moved, |t| t.iter().for_each(|&vertex| mark(near, vertex)));
        number(near);
        vertices(near).for_each(|vertex| at_mut(rings, vertex).clear());
        self.for_each_with(near, |t| add(turns_of(t), t, rings, |vertex| holds(near, vertex)));
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
}

/// While a one-ring is being certified, six bits from here on say which signs are not certified for all of its
/// triangles: those of [`uncertified_signs`]. Below, each coordinate has four bits for the times that the ring crosses
/// the plane through the vertex upwards, and four for downwards.
const SIGNS: u32 = 24;

impl OneRing {
    /// Adds a triangle, by [`turns_of`] it, at one of its corners.
    #[inline(always)]
    fn add(&mut self, turns: u32, corner: u32) {
        let crossed = SPREAD[(turns >> (6 * corner)) as usize & 63];
        self.0 = self.0.wrapping_add(crossed) | turns >> SIGNS << SIGNS;
    }

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

/// Adds a triangle, by its turns, to those one-rings of its corners that are `due`.
#[inline(always)]
fn add(turns: u32, t: &[u32; 3], rings: &mut [OneRing], due: impl Fn(u32) -> bool) {
    for (corner, &vertex) in (0..).zip(t) {
        let ring = at_mut(rings, vertex);
        if ring.is_connected() && due(vertex) {
            ring.add(turns, corner);
        }
    }
}

/// The planes through corner k that a triangle crosses, upwards from bit 6k on and downwards from bit 6k + 3 on; its
/// uncertified signs from [`SIGNS`] on.
#[inline(always)]
fn turns_of(positions: &[[f32; 3]], t: &[u32; 3]) -> u32 {
    let [p, q, r] = t.map(|vertex| Vec3A::from_array(*at(positions, vertex)));
    let signs = uncertified_signs(q - p, r - p);
    signs << SIGNS | crossed([p, q, r], |x, y| x.cmpge(y).bitmask())
}

/// [`turns_of`] a triangle of a mesh in f64.
pub(crate) fn turns_in_f64(mesh: Mesh<'_>, t: &[u32; 3]) -> u32 {
    let [p, q, r] = t.map(|vertex| DVec3::from_array(mesh.position_f64(vertex)));
    let (u, v) = (q - p, r - p);
    let (extent, normal) = (u.abs().max(v.abs()), u.cross(v));
    let bound = extent.yzx() * extent.zxy() * ERROR_2D + DVec3::splat(UNDERFLOW_2D);
    let signs = normal.cmpgt(bound).bitmask() | normal.cmplt(-bound).bitmask() << 3;
    (!signs & 0x3f) << SIGNS | crossed([p, q, r], |x, y| x.cmpge(y).bitmask())
}

/// The planes that a triangle crosses around each corner, where it goes from the next corner to the one after, by the bits
/// that tell which coordinates of one point are not below those of another.
#[inline(always)]
fn crossed<V: Copy>([p, q, r]: [V; 3], not_below: impl Fn(V, V) -> u32) -> u32 {
    let around = |corner, next, after| {
        let (from, to) = (not_below(next, corner), not_below(after, corner));
        !from & to & 7 | (from & !to & 7) << 3
    };
    around(p, q, r) | around(q, r, p) << 6 | around(r, p, q) << 12
}

/// Each of three bits in a byte of its own, and in the upper half of a byte each of the three above.
const SPREAD: [u32; 64] = {
    let mut spread = [0; 64];
    let mut bits = 0;
    while bits < 64 {
        spread[bits] = bytes(bits as u32 & 7) | bytes(bits as u32 >> 3) << 4;
        bits += 1;
    }
    spread
};

/// Each of three bits in a byte of its own.
const fn bytes(bits: u32) -> u32 {
    (bits | bits << 7 | bits << 14) & 0x1_0101
}

/// Bound of the error of a 2×2 determinant, relative to the extents: see the module.
const TURN_ERROR: f32 = 4.9e-7;

/// 2^60: products of two differences stay far from overflow.
const MAX_DIFFERENCE: f32 = 1.152_921_5e18;

/// Bit k is set if the coordinate k of the normal u × v is not certified to be positive, and bit k + 3 if it is not
/// certified to be negative.
#[inline]
fn uncertified_signs(u: Vec3A, v: Vec3A) -> u32 {
    let extent = u.abs().max(v.abs());
    if extent.max_element() > MAX_DIFFERENCE {
        return 0x3f;
    }
    let normal = u.cross(v);
    let bound = Vec3A::new(extent.y * extent.z, extent.z * extent.x, extent.x * extent.y)
        * TURN_ERROR
        + Vec3A::splat(f32::MIN_POSITIVE);
    let (positive, negative) = (normal.cmpgt(bound).bitmask(), normal.cmplt(-bound).bitmask());
    !(positive | negative << 3) & 0x3f
}
