//! Vertices about which a mesh is no trouble.
//!
//! Nearly all triangle pairs of a deforming mesh whose boxes overlap are neighbours, and nearly all of
//! these are at peace: the triangles about a vertex form a fan, and the fan does not touch itself. It
//! cannot if there is an axis along which every triangle of the fan is seen from the same side and the
//! fan goes round the vertex at most once, for then the projection along the axis takes the fan one to
//! one into a plane, in which its triangles are sectors side by side. Any two of them then share just the
//! corners that they share by index, and collide by none of the rules of
//! [`Adjacency`](crate::triangle::Adjacency). One certificate a vertex so stands for some fifteen pairs,
//! and needs no tolerance where the surface is flat. Where none is found (a sharp fold, a fan of
//! several leaves) pairs are tested as ever.

mod certify;
#[cfg(test)]
mod tests;

pub use certify::{Span, certify, certify_moved, certify_with, find_spans, span_bound};

use crate::index::{at, split};
use crate::{CapacityError, Mesh};
use bytemuck::{Pod, Zeroable};

/// What is known of the triangles about one vertex.
///
/// [`link`] makes these from the triangles of a mesh, once; [`certify`] brings them up to date with its
/// positions, each time they change; [`SelfQuery::with_fans`](crate::bvtt::SelfQuery::with_fans) uses them.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Fan(u32);

/// The triangles about the vertex are a ring, each next to the one before.
const RING: u32 = 1 << 31;
/// They are a row.
const ROW: u32 = 1 << 30;
const LINK: u32 = RING | ROW;
const CERTIFIED: u32 = 1;

/// The most triangles in a fan: they are counted in four bits.
const MOST: usize = 15;

impl Fan {
    /// Whether no two triangles about the vertex collide, by the positions last given to [`certify`].
    #[inline]
    #[must_use]
    pub fn is_certified(self) -> bool {
        self.0 & CERTIFIED != 0
    }

    /// Before its triangles are counted.
    fn clear(&mut self) {
        self.0 &= LINK;
    }

    /// Once they are: a ring must go round once; a row less than once, as it surely does if it enters only one
    /// half-plane.
    fn settle(&mut self) {
        let count = |coordinate: u32| {
            let (up, down) = (self.0 >> (8 * coordinate) & 15, self.0 >> (8 * coordinate + 4) & 15);
            if self.0 & RING != 0 { up == 1 } else { up + down <= 1 }
        };
        let once = u32::from(count(0)) | u32::from(count(1)) << 1 | u32::from(count(2)) << 2;
        let doubts = self.0 >> DOUBTS;
        let axes = !(doubts & doubts >> 3) & 7;
        // An axis is no good with what is counted along itself.
        let others = (once << 1 | once >> 2) | (once << 2 | once >> 1);
        let certified = self.0 & LINK != 0 && axes & others != 0;
        self.0 = self.0 & LINK | u32::from(certified);
    }
}

/// While [`certify`] is at it, from here on a bit for each of the six sides from which some triangle of
/// the fan is not surely seen; below, for each coordinate, four bits for the times that the fan goes up
/// through that of the vertex and four for the times it goes down.
const DOUBTS: u32 = 24;

/// How many words [`link`] needs.
#[must_use]
pub const fn link_scratch_bound(vertices: usize, triangles: usize) -> usize {
    vertices + 1 + 3 * triangles
}

/// Finds out which vertices have one fan, a ring or a row. None of them is certified yet. Of meshes of
/// more than 2^32 / 3 triangles, none ever is.
///
/// # Errors
/// [`CapacityError`] if `fans` has not one entry a vertex, or `scratch` fewer words than
/// [`link_scratch_bound`].
///
/// # Complexity
/// O(vertices + triangles).
///
/// # Examples
/// ```
/// use pfront_core::{Mesh, fans::{self, Fan, link_scratch_bound}};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// let mut known = [Fan::default(); 3];
/// fans::link(mesh, &mut [0; link_scratch_bound(3, 1)], &mut known)?;
/// assert!(!known[0].is_certified());
/// fans::certify(mesh, &mut known)?;
/// assert!(known[0].is_certified());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn link(mesh: Mesh<'_>, scratch: &mut [u32], fans: &mut [Fan]) -> Result<(), CapacityError> {
    let (vertices, triangles) = (mesh.positions().len(), mesh.triangles());
    CapacityError::check("fans", vertices, fans.len())?;
    let need = link_scratch_bound(vertices, triangles.len());
    CapacityError::check("scratch", need, scratch.len())?;
    if triangles.len() > u32::MAX as usize / 3 {
        // Their corners cannot be numbered.
        fans.fill(Fan(0));
        return Ok(());
    }
    let (ends, corners) = split(scratch, vertices + 1);
    // Corners by vertex: their number 3t + k, the triangle and the corner.
    ends.fill(0);
    for &vertex in triangles.as_flattened() {
        if let Some(count) = ends.get_mut(vertex as usize + 1) {
            *count += 1;
        }
    }
    let mut sum = 0;
    for end in &mut *ends {
        sum += *end;
        *end = sum;
    }
    for (corner, &vertex) in triangles.as_flattened().iter().enumerate() {
        if let Some(end) = ends.get_mut(vertex as usize)
            && let Some(slot) = corners.get_mut(*end as usize)
        {
            *slot = corner as u32;
            *end += 1;
        }
    }
    let mut start = 0;
    for (fan, &end) in fans.iter_mut().zip(ends.iter()) {
        *fan = linked(triangles, corners.get(start..end as usize).unwrap_or_default());
        start = end as usize;
    }
    Ok(())
}

/// Whether a vertex is there twice.
fn repeats(vertices: &[u32]) -> bool {
    let mut rest = vertices;
    while let [first, others @ ..] = rest {
        if others.contains(first) {
            return true;
        }
        rest = others;
    }
    false
}

/// Whether corners at one vertex make a ring or a row.
fn linked(triangles: &[[u32; 3]], corners: &[u32]) -> Fan {
    if corners.is_empty() || corners.len() > MOST {
        return Fan(0);
    }
    let (mut from, mut to) = ([0; MOST], [0; MOST]);
    for ((&corner, from), to) in corners.iter().zip(&mut from).zip(&mut to) {
        let (t, k) = (at(triangles, corner / 3), corner as usize % 3);
        (*from, *to) = (t[(k + 1) % 3], t[(k + 2) % 3]);
    }
    let [from, to] = [&from, &to].map(|v| v.get(..corners.len()).unwrap_or_default());
    if repeats(from) || repeats(to) {
        return Fan(0);
    }
    let first = from.iter().position(|v| !to.contains(v));
    let start = first.unwrap_or(0);
    let (mut at, mut seen) = (start, 1);
    while let Some(next) = from.iter().position(|v| to.get(at) == Some(v))
        && next != start
    {
        seen += 1;
        at = next;
    }
    match (seen == from.len(), first) {
        (false, _) => Fan(0),
        (true, None) => Fan(RING),
        (true, Some(_)) => Fan(ROW),
    }
}
