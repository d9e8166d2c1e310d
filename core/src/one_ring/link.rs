//! Connectivity of one-rings: which vertices have triangles that form one ring or one row.

use super::{OneRing, OneRings, RING, ROW};
use crate::index::{at, at_mut, range, split};

/// Returns the number of words of scratch that [`OneRings::new`] needs.
#[must_use]
pub const fn link_scratch_bound(vertices: usize, triangles: usize) -> usize {
    vertices + 1 + 3 * triangles
}

/// Returns the number of words of [`OneRings::with_links`]: those of the scratch, and one for each triangle.
#[must_use]
pub const fn links_bound(vertices: usize, triangles: usize) -> usize {
    link_scratch_bound(vertices, triangles) + triangles
}

impl OneRings<'_> {
    /// Sorts the corners by vertex, and links those of each vertex.
    pub(super) fn link(&mut self, scratch: &mut [u32]) {
        let triangles = self.triangles;
        self.rings.fill(OneRing(0));
        if triangles.len() > u32::MAX as usize / 3 {
            // Corners are numbered 3t + k in 32 bits.
            return;
        }
        let (ends, corners) = split(scratch, self.rings.len() + 1);
        ends.fill(0);
        let all = || triangles.as_flattened().iter().map(|&vertex| vertex as usize);
        // A corner without a vertex is in no mesh, and may be left out.
        let vertices = self.rings.len();
        for vertex in all().filter(|&vertex| vertex < vertices) {
            *at_mut(ends, vertex + 1) += 1;
        }
        let mut sum = 0;
        for end in &mut *ends {
            sum += *end;
            *end = sum;
        }
        for (corner, vertex) in all().enumerate().filter(|&(_, vertex)| vertex < vertices) {
            let end = at_mut(ends, vertex);
            *at_mut(corners, *end) = corner as u32;
            *end += 1;
        }
        let mut start = 0;
        for (ring, &end) in self.rings.iter_mut().zip(ends.iter()) {
            *ring = linked(triangles, range(corners, start, end - start));
            start = end;
        }
    }
}

/// Links the triangles at the corners of one vertex.
fn linked(triangles: &[[u32; 3]], corners: &[u32]) -> OneRing {
    let mut edges = [[0; 2]; OneRing::MAX_TRIANGLES];
    if corners.len() > edges.len() {
        return OneRing(0);
    }
    // The edges that face the vertex, each from one vertex to another.
    let (edges, _) = split(&mut edges, corners.len());
    for (edge, corner) in edges.iter_mut().zip(corners) {
        let (t, k) = (at(triangles, corner / 3), *corner as usize % 3);
        *edge = [t[(k + 1) % 3], t[(k + 2) % 3]];
    }
    let repeats = |k: usize| {
        let others = |i: usize| edges.iter().skip(i + 1);
        edges.iter().enumerate().any(|(i, edge)| others(i).any(|other| other[k] == edge[k]))
    };
    if repeats(0) || repeats(1) {
        return OneRing(0);
    }
    let first = edges.iter().find(|[from, _]| edges.iter().all(|[_, to]| to != from));
    let Some(start) = first.or(edges.first()) else { return OneRing(0) };
    let (mut end, mut connected) = (start[1], 1);
    while end != start[0]
        && let Some(next) = edges.iter().find(|[from, _]| *from == end)
    {
        end = next[1];
        connected += 1;
    }
    match (connected == edges.len(), first) {
        (false, _) => OneRing(0),
        (true, None) => OneRing(RING),
        (true, Some(_)) => OneRing(ROW),
    }
}
