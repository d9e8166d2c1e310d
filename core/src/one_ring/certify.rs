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

use super::OneRings;
use super::certified::Certified;
use super::ring::{CERTIFIED, OneRing, RING};
use crate::Mesh;
use crate::bvh::Join;
use crate::exact::filter64::{ERROR_2D, UNDERFLOW_2D};
use crate::parallel::parts;
use glam::{DVec3, Vec3A, Vec3Swizzles};

impl OneRings<'_> {
    /// Certifies the one-rings for the positions of a mesh. With `join`, and if they have their
    /// [links](OneRings::with_links), parts of the pass run side by side; the certificates are the same.
    ///
    /// If the triangles of the mesh are not those of [`OneRings::new`], nothing is certified.
    ///
    /// # Complexity
    /// O(vertices + triangles).
    pub fn certify<'m>(&'m mut self, mesh: Mesh<'m>, join: Option<&Join<'_>>) -> Certified<'m> {
        let positions = mesh.shadow();
        if mesh.is_f64() {
            self.certify_by(mesh, join, |t| turns_in_f64(mesh, t))
        } else {
            self.certify_by(mesh, join, |t| turns_of(positions, t))
        }
    }

    /// [`OneRings::certify`] by the turns of each triangle.
    fn certify_by<'m>(
        &'m mut self,
        mesh: Mesh<'m>,
        join: Option<&Join<'_>>,
        turns: impl Fn(&[u32; 3]) -> u32 + Sync,
    ) -> Certified<'m> {
        let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles());
        let Self { rings, links, .. } = self;
        let same = core::ptr::eq(triangles, self.triangles) || triangles == self.triangles;
        if !same || rings.len() != vertices {
            rings.iter_mut().for_each(OneRing::clear);
            return Certified::new(mesh, &[]);
        }
        if join.is_some() && !links.is_empty() {
            certify_in_parts(&turns, triangles, rings, links, join);
        } else {
            rings.iter_mut().for_each(OneRing::clear);
            triangles.iter().for_each(|t| add(turns(t), t, rings));
            rings.iter_mut().for_each(OneRing::certify);
        }
        Certified::new(mesh, rings)
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
    let (ends, rest) = links.split_at_mut(rings.len() + 1);
    let (corners, turns) = rest.split_at_mut(3 * triangles.len());
    parts(join, 0, turns, &|first, turns| {
        for (turns, t) in turns.iter_mut().zip(&triangles[first..]) {
            *turns = turns_of(t);
        }
    });
    let (ends, corners, turns) = (&*ends, &*corners, &*turns);
    parts(join, 0, rings, &|first, rings| {
        let mut start = first.checked_sub(1).map_or(0, |before| ends[before]);
        for (ring, &end) in rings.iter_mut().zip(&ends[first..]) {
            ring.clear();
            if ring.is_connected() {
                for corner in &corners[start as usize..][..(end - start) as usize] {
                    ring.add(turns[(corner / 3) as usize], corner % 3);
                }
            }
            ring.certify();
            start = end;
        }
    });
}

/// From this bit on, the turns of a triangle hold its uncertified signs.
const SIGNS: u32 = 24;

/// While a one-ring is being certified, its six lowest bits say which planes through the vertex it crosses, upwards or
/// downwards, as [`crossed`] has them; the six from here on, which of them more than once.
const TWICE: u32 = 6;
/// The six from here on say which signs are not certified for all of its triangles: those of [`uncertified_signs`].
const UNCERTIFIED: u32 = 12;
const SIX: u32 = 0x3f;

impl OneRing {
    /// Adds a triangle, by [`turns_of`] it, at one of its corners.
    #[inline(always)]
    fn add(&mut self, turns: u32, corner: u32) {
        let crossed = turns >> (6 * corner) & SIX;
        self.0 |= (self.0 & crossed) << TWICE | crossed | turns >> SIGNS << UNCERTIFIED;
    }

    /// Applies the theorem, once all triangles are added.
    fn certify(&mut self) {
        let [up, down] = [0, 3].map(|first| self.0 >> first & 7);
        let [up_twice, down_twice] = [0, 3].map(|first| self.0 >> (TWICE + first) & 7);
        // The planes that a ring crosses upwards once, and a row at most once either way.
        let once = if self.0 & RING != 0 {
            up & !up_twice
        } else {
            !(up & down | up_twice | down_twice) & 7
        };
        let uncertified = self.0 >> UNCERTIFIED & SIX;
        let same_sign = !(uncertified & uncertified >> 3) & 7;
        // Turns about an axis are counted along either of the other two.
        let turned = (once << 1 | once >> 2) | (once << 2 | once >> 1);
        let certified = self.is_connected() && same_sign & turned != 0;
        self.clear();
        self.0 |= if certified { CERTIFIED } else { 0 };
    }
}

/// Adds a triangle, by its turns, to the one-rings of its corners.
#[inline(always)]
fn add(turns: u32, t: &[u32; 3], rings: &mut [OneRing]) {
    for (corner, &vertex) in (0..).zip(t) {
        let ring = &mut rings[vertex as usize];
        if ring.is_connected() {
            ring.add(turns, corner);
        }
    }
}

/// The planes through corner k that a triangle crosses, upwards from bit 6k on and downwards from bit 6k + 3 on; its
/// uncertified signs from [`SIGNS`] on.
#[inline(always)]
fn turns_of(positions: &[[f32; 3]], t: &[u32; 3]) -> u32 {
    let [p, q, r] = t.map(|vertex| Vec3A::from_array(positions[vertex as usize]));
    let signs = uncertified_signs(q - p, r - p);
    signs << SIGNS | crossed([p, q, r], |x, y| x.cmpge(y).bitmask())
}

/// [`turns_of`] a triangle of a mesh in f64.
fn turns_in_f64(mesh: Mesh<'_>, t: &[u32; 3]) -> u32 {
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
