//! Connectivity of one-rings: which vertices have triangles that form one ring or one row.

use super::certify::Span;
use super::{OneRing, OneRings, RING, ROW};
use crate::index::{at, at_mut, range, split};

/// Returns the number of words of scratch that [`OneRings::new`] needs.
#[must_use]
pub const fn link_scratch_bound(vertices: usize, triangles: usize) -> usize {
    vertices + 1 + 3 * triangles
}

impl OneRings<'_> {
    /// Sorts the corners by vertex, and links those of each vertex.
    pub(super) fn link(&mut self, scratch: &mut [u32]) {
        let triangles = self.triangles;
        self.rings.fill(OneRing(0));
        Span::find(triangles, self.spans);
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
    let n = corners.len();
    if n == 0 || n > OneRing::MAX_TRIANGLES {
        return OneRing(0);
    }
    // The edges that face the vertex, each from one vertex to another.
    let mut edges = [[0; 2]; OneRing::MAX_TRIANGLES];
    let edges = &mut edges[..n];
    for (edge, corner) in edges.iter_mut().zip(corners) {
        let (t, k) = (at(triangles, corner / 3), *corner as usize % 3);
        *edge = [t[(k + 1) % 3], t[(k + 2) % 3]];
    }
    let first = edges.iter().position(|[from, _]| edges.iter().all(|[_, to]| to != from));
    edges.swap(0, first.unwrap_or(0));
    for i in 1..n {
        let last = edges[i - 1][1];
        let Some(next) = (i..n).find(|&j| edges[j][0] == last) else { return OneRing(0) };
        edges.swap(i, next);
    }
    // Each vertex has one edge from it and one to it at most.
    let last = edges[n - 1][1];
    let is_simple = |i: usize| {
        let from = edges[i][0];
        from != last && edges[..i].iter().all(|edge| edge[0] != from)
    };
    match (1..n).all(is_simple) {
        false => OneRing(0),
        true if edges[0][0] == last => OneRing(RING),
        true => OneRing(ROW),
    }
}
