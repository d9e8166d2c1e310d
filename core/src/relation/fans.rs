//! The triangles around each edge.
//!
//! Half-edge `3 t + k` is that of triangle t from its corner k to the next. The half-edges of one edge are sorted next to each
//! other by their vertices, and linked to a ring.

use crate::bvtt::TrianglePair;

/// The vertices of a half-edge, lower first, and whether it runs from the lower to the higher.
#[inline]
pub(super) fn edge_of(corners: &[[u32; 3]], half_edge: u32) -> ([u32; 2], bool) {
    let triangle = &corners[(half_edge / 3) as usize];
    let k = (half_edge % 3) as usize;
    let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
    if from < to { ([from, to], true) } else { ([to, from], false) }
}

/// Writes the half-edges of all triangles with three different vertices, sorted by their edges, and returns how many there are. Takes
/// a word for each vertex: those of a vertex that is the lower of the two are few, and gathered first.
pub(super) fn sort_by_edge(corners: &[[u32; 3]], ends: &mut [u32], out: &mut [u32]) -> usize {
    let half_edges = || {
        let are_different = |&(_, &[p, q, r]): &(u32, &[u32; 3])| p != q && q != r && r != p;
        let of = |(triangle, _)| (0..3).map(move |k| 3 * triangle + k);
        (0..).zip(corners).filter(are_different).flat_map(of)
    };
    let lower = |half_edge: u32| edge_of(corners, half_edge).0[0] as usize;
    ends.fill(0);
    half_edges().for_each(|half_edge| ends[lower(half_edge)] += 1);
    let mut len = 0;
    for end in &mut *ends {
        (len, *end) = (len + *end, len);
    }
    for half_edge in half_edges() {
        let end = &mut ends[lower(half_edge)];
        out[*end as usize] = half_edge;
        *end += 1;
    }
    let mut begin = 0;
    for &end in &*ends {
        let of_one = &mut out[begin..end as usize];
        of_one.sort_unstable_by_key(|&half_edge| (edge_of(corners, half_edge).0[1], half_edge));
        begin = end as usize;
    }
    len as usize
}

/// Links the half-edges of one edge to a ring, in order.
pub(super) fn link(ring: impl Iterator<Item = u32>, next: &mut [u32]) {
    let (mut first, mut last) = (None, None);
    for half_edge in ring {
        match last {
            Some(last) => next[last as usize] = half_edge,
            None => first = Some(half_edge),
        }
        last = Some(half_edge);
    }
    if let (Some(first), Some(last)) = (first, last) {
        next[last as usize] = first;
    }
}

/// The half-edges of the ring of one, that one first.
pub(super) fn fan(next: &[u32], half_edge: u32) -> impl Iterator<Item = u32> + '_ {
    let following = move |&at: &u32| Some(next[at as usize]).filter(|&at| at != half_edge);
    core::iter::successors(Some(half_edge), following)
}

/// Sets of triangles, as trees of parents in one array.
pub(super) struct Sets<'s>(pub(super) &'s mut [u32]);

impl Sets<'_> {
    /// The lowest triangle of the set of one.
    pub(super) fn root(&mut self, mut triangle: u32) -> u32 {
        while self.0[triangle as usize] != triangle {
            let above = self.0[self.0[triangle as usize] as usize];
            self.0[triangle as usize] = above;
            triangle = above;
        }
        triangle
    }

    pub(super) fn join(&mut self, of: u32, with: u32) {
        let (a, b) = (self.root(of), self.root(with));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// A bit of each of some triangles.
pub(super) struct Bits<'s>(pub(super) &'s mut [u32]);

impl Bits<'_> {
    #[inline]
    pub(super) fn set(&mut self, index: u32) {
        self.0[index as usize / 32] |= 1 << (index % 32);
    }

    #[inline]
    pub(super) fn has(&self, index: u32) -> bool {
        self.0[index as usize / 32] >> (index % 32) & 1 != 0
    }

    /// Sets those of a pair.
    pub(super) fn set_pair(&mut self, pair: TrianglePair) {
        self.set(pair.a);
        self.set(pair.b);
    }
}
