//! Connectivity of one-rings: which vertices have triangles that form one ring or one row.

use super::OneRings;
use super::ring::{OneRing, RING, ROW};
use crate::sort::sort;

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
        let (ends, corners) = scratch.split_at_mut(self.rings.len() + 1);
        ends.fill(0);
        let all = || triangles.as_flattened().iter().map(|&vertex| vertex as usize);
        // A corner without a vertex is in no mesh, and may be left out.
        let vertices = self.rings.len();
        for vertex in all().filter(|&vertex| vertex < vertices) {
            ends[vertex + 1] += 1;
        }
        let mut sum = 0;
        for end in &mut *ends {
            sum += *end;
            *end = sum;
        }
        for (corner, vertex) in all().enumerate().filter(|&(_, vertex)| vertex < vertices) {
            let end = &mut ends[vertex];
            corners[*end as usize] = corner as u32;
            *end += 1;
        }
        let mut start = 0;
        for (ring, &end) in self.rings.iter_mut().zip(ends.iter()) {
            *ring = linked(triangles, &mut corners[start as usize..end as usize]);
            start = end;
        }
    }
}

/// The most triangles that are linked by comparing all of them with each other. A policy: most vertices of a mesh have six.
const FEW: usize = 15;

/// The edge that faces a corner, from one vertex to another.
fn edge(triangles: &[[u32; 3]], corner: u32) -> [u32; 2] {
    let (t, k) = (&triangles[(corner / 3) as usize], corner as usize % 3);
    [t[(k + 1) % 3], t[(k + 2) % 3]]
}

/// Links the triangles at the corners of one vertex, whose order may change.
fn linked(triangles: &[[u32; 3]], corners: &mut [u32]) -> OneRing {
    let mut edges = [[0; 2]; FEW];
    if corners.len() > edges.len() {
        return linked_by_sorting(triangles, corners);
    }
    let edges = &mut edges[..corners.len()];
    for (to, &corner) in edges.iter_mut().zip(&*corners) {
        *to = edge(triangles, corner);
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

/// [`linked`] for any number of triangles, in O(n log n).
#[cold]
fn linked_by_sorting(triangles: &[[u32; 3]], corners: &mut [u32]) -> OneRing {
    let from = |&corner: &u32| edge(triangles, corner)[0];
    sort(corners, from);
    let corners = &*corners;
    if corners.iter().zip(corners.iter().skip(1)).any(|(one, other)| from(one) == from(other)) {
        return OneRing(0);
    }
    let next = |vertex: u32| {
        let found = corners.binary_search_by_key(&vertex, from).ok()?;
        Some(edge(triangles, corners[found])[1])
    };
    // Goes from edge to edge until no edge goes on, or there were as many as there are, or it is where it began. Since no two
    // edges begin at one vertex, it goes through no edge twice unless it goes round.
    let walk = |start: u32| {
        let (mut end, mut edges) = (start, 0);
        while edges < corners.len()
            && let Some(after) = next(end)
        {
            (end, edges) = (after, edges + 1);
            if end == start {
                break;
            }
        }
        (end, edges)
    };
    let Some(start) = corners.first().map(from) else { return OneRing(0) };
    let size = OneRing::size(corners.len());
    let (end, edges) = walk(start);
    if end == start {
        return if edges == corners.len() { OneRing(RING | size) } else { OneRing(0) };
    }
    // All vertices of a row are the end of one edge and the start of another, but for the first and the last, which the walk
    // has found if this is a row.
    let ends = corners.iter().map(|&corner| edge(triangles, corner));
    let first = ends.fold(end, |all, [from, to]| all ^ from ^ to);
    let (end, edges) = walk(first);
    let is_row = edges == corners.len() && end != first && next(end).is_none();
    if is_row { OneRing(ROW | size) } else { OneRing(0) }
}
