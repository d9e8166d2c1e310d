//! Bringing fans up to date: all of them, or those about which something has moved.
//!
//! That all are seen from the same side takes the sign of one coordinate of each normal, in f32 beyond its
//! bound: each of two products of two differences carries a relative error below (1+u)^4 − 1 with
//! u = 2^-24, so 8.02u · mi·mj of the largest differences along the two axes, and underflow costs
//! less than the smallest normal number. That the fan goes round once is counted without any rounding:
//! a sector is below half a turn, so a fan that goes round passes from one half-plane into the other, by a
//! comparison of coordinates, once a turn each way.

use super::{DOUBTS, Fan, LINK};
use crate::bvh::{Join, Moved, moved_bound};
use crate::index::at;
use crate::vertex_set::{holds, holds_any, mark, number, vertices};
use crate::{CapacityError, Mesh};
use core::ops::Range;
use glam::Vec3A;

/// Brings the fans of a mesh up to date with its positions. `fans` are those of [`link`](super::link) for the same
/// triangles; others may make a query miss pairs.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex.
///
/// # Complexity
/// O(vertices + triangles), about 15 ns a triangle.
pub fn certify(mesh: Mesh<'_>, fans: &mut [Fan]) -> Result<(), CapacityError> {
    let positions = mesh.positions();
    CapacityError::check("fans", positions.len(), fans.len())?;
    fans.iter_mut().for_each(Fan::clear);
    for t in mesh.triangles() {
        count(positions, t, fans, 0, |_| true);
    }
    fans.iter_mut().for_each(Fan::settle);
    Ok(())
}

/// Vertices of a part that is worth another thread: a tenth of a millisecond.
const PART: usize = 8192;
/// As many spans as there are may reach into parts so many times, before it is better to divide nothing.
const REACH: usize = 2;

/// [`certify`] in parts that `join` may run side by side, as `rayon::join` does; the fans are the same.
///
/// Vertices are divided, and each part looks at the triangles of those `spans`, as [`find_spans`] found them, that
/// reach into it: at twice as many as there are at most. Where triangles near one another in the mesh have vertices
/// that are not, there is one part. Spans of other triangles may make a query miss pairs, as fans of others do.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex, or there are fewer spans than [`span_bound`].
///
/// # Complexity
/// O(vertices + triangles), in parts of at most 8192 vertices; to divide m of them takes O(triangles / 64 · log m).
///
/// # Examples
/// ```
/// # use pfront_core::{CapacityError, Mesh, fans::{Fan, Span, certify_with}};
/// # fn f(mesh: Mesh<'_>, spans: &[Span], fans: &mut [Fan]) -> Result<(), CapacityError> {
/// certify_with(mesh, spans, fans, &|a, b| {
///     a();
///     b();
/// })?;
/// # Ok(())
/// # }
/// ```
pub fn certify_with(
    mesh: Mesh<'_>,
    spans: &[Span],
    fans: &mut [Fan],
    join: &Join<'_>,
) -> Result<(), CapacityError> {
    CapacityError::check("fans", mesh.positions().len(), fans.len())?;
    CapacityError::check("spans", span_bound(mesh.triangles().len()), spans.len())?;
    let spans = &spans[..span_bound(mesh.triangles().len())];
    let reached = spans.iter().map(|span| span.parts().len()).sum::<usize>();
    if reached > REACH * spans.len() {
        return certify(mesh, fans);
    }
    let run = Run { spans, triangles: mesh.triangles() };
    Parts { positions: mesh.positions(), join }.certify(0, fans, run);
    Ok(())
}

/// Consecutive triangles, with their spans.
#[derive(Clone, Copy)]
struct Run<'p> {
    spans: &'p [Span],
    triangles: &'p [[u32; 3]],
}

impl Run<'_> {
    /// From the first to the last that reach into these parts.
    fn reaching(self, parts: Range<usize>) -> Self {
        let reaches = |span: &Span| {
            let own = span.parts();
            own.start < parts.end && parts.start < own.end
        };
        let Self { spans, triangles } = self;
        let first = spans.iter().position(reaches).unwrap_or(spans.len());
        let end = spans.iter().rposition(reaches).map_or(first, |last| last + 1);
        let [from, to] = [first, end].map(|span| (span * SPAN).min(triangles.len()));
        Self { spans: &spans[first..end], triangles: &triangles[from..to] }
    }
}

struct Parts<'p> {
    positions: &'p [[f32; 3]],
    join: &'p Join<'p>,
}

impl Parts<'_> {
    /// The fans of the vertices from `first` on.
    fn certify(&self, first: usize, fans: &mut [Fan], run: Run<'_>) {
        let len = fans.len();
        let own = first / PART..(first + len).div_ceil(PART);
        let run = run.reaching(own.clone());
        let half = len.div_ceil(2).next_multiple_of(PART);
        if half < len {
            let (low, high) = fans.split_at_mut(half);
            let mut low = || self.certify(first, low, run);
            return (self.join)(&mut low, &mut || self.certify(first + half, high, run));
        }
        let spans = run.spans.iter().zip(run.triangles.chunks(SPAN));
        fans.iter_mut().for_each(Fan::clear);
        for (_, triangles) in spans.filter(|(span, _)| span.parts().contains(&own.start)) {
            for t in triangles {
                count(self.positions, t, fans, first, |_| true);
            }
        }
        fans.iter_mut().for_each(Fan::settle);
    }
}

/// How many consecutive triangles one [`Span`] tells of.
const SPAN: usize = 64;

/// The smallest and the largest index of a vertex of some consecutive triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span([u32; 2]);

impl Span {
    /// The parts that it reaches into.
    fn parts(self) -> Range<usize> {
        let [first, last] = self.0.map(|vertex| vertex as usize / PART);
        first..last + 1
    }
}

/// How many spans so many triangles have.
#[must_use]
pub const fn span_bound(triangles: usize) -> usize {
    triangles.div_ceil(SPAN)
}

/// Finds the spans of the triangles, which [`certify_moved`] goes by. They are short if triangles that are
/// near one another in the mesh have vertices that are.
///
/// # Errors
/// [`CapacityError`] if there are fewer than [`span_bound`].
///
/// # Complexity
/// O(triangles).
pub fn find_spans(mesh: Mesh<'_>, spans: &mut [Span]) -> Result<(), CapacityError> {
    CapacityError::check("spans", span_bound(mesh.triangles().len()), spans.len())?;
    for (span, triangles) in spans.iter_mut().zip(mesh.triangles().chunks(SPAN)) {
        let all = triangles.as_flattened().iter();
        span.0 = all.fold([u32::MAX, 0], |[first, last], &v| [first.min(v), last.max(v)]);
    }
    Ok(())
}

/// [`certify`] after some vertices of a mesh have moved: brings up to date the fans of these and of their
/// neighbours, on which alone that has a bearing.
///
/// `spans` are those of [`find_spans`]. `moved` holds what has moved since the fans were up to date, by
/// [`mark_moved`](crate::bvh::build::mark_moved). `scratch` may hold anything.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex, `spans` fewer than [`span_bound`], or `moved` or
/// `scratch` fewer words than [`moved_bound`].
///
/// # Complexity
/// O(m + vertices / 32 + triangles / 64) for m triangles in spans that hold a vertex which has moved or
/// its neighbour.
///
/// # Examples
/// ```
/// use pfront_core::{Mesh, build::{Moved, mark_moved}, fans::{self, Fan, Span, link_scratch_bound}};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// let (mut known, mut spans) = ([Fan::default(); 3], [Span::default()]);
/// fans::link(mesh, &mut [0; link_scratch_bound(3, 1)], &mut known)?;
/// fans::certify(mesh, &mut known)?;
/// fans::find_spans(mesh, &mut spans)?;
///
/// let after = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
/// let mut moved = [Moved::default()];
/// mark_moved(&points, &after, &mut moved)?;
/// let mesh = mesh.with_positions(&after)?;
/// fans::certify_moved(mesh, &spans, &moved, &mut [Moved::default()], &mut known)?;
/// assert!(!known[0].is_certified(), "a triangle without area");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn certify_moved(
    mesh: Mesh<'_>,
    spans: &[Span],
    moved: &[Moved],
    scratch: &mut [Moved],
    fans: &mut [Fan],
) -> Result<(), CapacityError> {
    let positions = mesh.positions();
    CapacityError::check("fans", positions.len(), fans.len())?;
    CapacityError::check("spans", span_bound(mesh.triangles().len()), spans.len())?;
    CapacityError::check("moved", moved_bound(positions.len()), moved.len())?;
    CapacityError::check("scratch", moved_bound(positions.len()), scratch.len())?;
    // Whatever shares a triangle with a vertex that has moved.
    let near = scratch;
    near.fill(Moved::default());
    with_any(mesh, spans, moved, |t| t.iter().for_each(|&vertex| mark(near, vertex)));
    number(near);
    update(near, fans, Fan::clear);
    with_any(mesh, spans, near, |t| count(positions, t, fans, 0, |vertex| holds(near, vertex)));
    update(near, fans, Fan::settle);
    Ok(())
}

/// Changes the fans of a set of vertices.
fn update(set: &[Moved], fans: &mut [Fan], change: impl Fn(&mut Fan)) {
    for vertex in vertices(set) {
        fans.get_mut(vertex).map(&change);
    }
}

/// Calls `visit` for each triangle that has a vertex of the set.
#[inline(always)]
fn with_any(mesh: Mesh<'_>, spans: &[Span], set: &[Moved], mut visit: impl FnMut(&[u32; 3])) {
    let spans = spans.iter().zip(mesh.triangles().chunks(SPAN));
    for (_, triangles) in spans.filter(|(span, _)| holds_any(set, span.0)) {
        let any = |t: &&[u32; 3]| t.iter().any(|&vertex| holds(set, vertex));
        triangles.iter().filter(any).for_each(&mut visit);
    }
}

/// Counts a triangle in those fans of its corners that are `due`. The fans are those of some vertices from `first` on.
#[inline(always)]
fn count(
    positions: &[[f32; 3]],
    t: &[u32; 3],
    fans: &mut [Fan],
    first: usize,
    due: impl Fn(u32) -> bool,
) {
    let [p, q, r] = t.map(|vertex| Vec3A::from_array(*at(positions, vertex)));
    let doubts = sides_in_doubt(q - p, r - p) << DOUBTS;
    // Seen from a corner, a fan goes from the next one to the one after.
    let above = |x: Vec3A, y: Vec3A| x.cmpge(y).bitmask();
    let passes =
        [[above(q, p), above(r, p)], [above(r, q), above(p, q)], [above(p, r), above(q, r)]];
    for (&vertex, [next, after]) in t.iter().zip(passes) {
        let Some(Fan(word)) = fans.get_mut((vertex as usize).wrapping_sub(first)) else { continue };
        if *word & LINK != 0 && due(vertex) {
            let passed =
                SPREAD[(!next & after) as usize & 7] + (SPREAD[(next & !after) as usize & 7] << 4);
            *word = word.wrapping_add(passed) | doubts;
        }
    }
}

/// One in the byte of each bit.
const SPREAD: [u32; 8] = [0, 1, 0x100, 0x101, 0x1_0000, 0x1_0001, 0x1_0100, 0x1_0101];

/// A bit for each axis along which the triangle with these two edges is not surely seen counter-clockwise,
/// and three bits on for clockwise.
#[inline]
fn sides_in_doubt(u: Vec3A, v: Vec3A) -> u32 {
    const BOUND: f32 = 4.9e-7;
    /// 2^60: products of two overflow nowhere near.
    const MOST: f32 = 1.152_921_5e18;
    let extent = u.abs().max(v.abs());
    if extent.max_element() > MOST {
        return 0x3f;
    }
    let normal = u.cross(v);
    let bound = Vec3A::new(extent.y * extent.z, extent.z * extent.x, extent.x * extent.y) * BOUND
        + Vec3A::splat(f32::MIN_POSITIVE);
    let (seen, unseen) = (normal.cmpgt(bound).bitmask(), normal.cmplt(-bound).bitmask());
    !(seen | unseen << 3) & 0x3f
}
