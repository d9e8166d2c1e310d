//! Names of the regions of a mesh: vertices that are posed to the same point are one.

use crate::memory::push;
use crate::{Error, Mesh, TrianglePair};
use pfront_core::bvtt::PairBvtt;

/// The vertices of the triangles of some pairs, of both meshes.
pub(crate) struct Vertices<'m> {
    meshes: [Mesh<'m>; 2],
    /// Each vertex, sorted, and the lowest at its point.
    lowest: [Vec<[u32; 2]>; 2],
}

impl<'m> Vertices<'m> {
    pub(crate) fn new(
        meshes: [Mesh<'m>; 2],
        tree: &PairBvtt<'_>,
        pairs: &[TrianglePair],
    ) -> Result<Self, Error> {
        let mut lowest = [Vec::new(), Vec::new()];
        for (of, lowest) in lowest.iter_mut().enumerate() {
            let (mut last, mut found) = (None, Vec::new());
            for &pair in pairs {
                let triangle = [pair.a, pair.b][of];
                if last.replace(triangle) == Some(triangle) {
                    continue;
                }
                let corners = tree.corners(pair)[of];
                for (vertex, p) in meshes[of].triangles()[triangle as usize].iter().zip(corners) {
                    // −0 is 0.
                    push(&mut found, (p.map(|x| (x + 0.0).to_bits()), *vertex))?;
                }
            }
            found.sort_unstable();
            found.dedup();
            for at_one in found.chunk_by(|(p, _), (q, _)| p == q) {
                for (_, vertex) in at_one {
                    push(lowest, [*vertex, at_one[0].1])?;
                }
            }
            lowest.sort_unstable();
        }
        Ok(Self { meshes, lowest })
    }

    /// A name for each region of a triangle of a mesh, as [`Region::ALL`](pfront_core::triangle::Region::ALL) has them: the same for all
    /// triangles that have it in common.
    pub(super) fn regions(&self, mesh: usize, triangle: u32) -> [u64; 7] {
        let lowest = |vertex: u32| {
            let all = &self.lowest[mesh];
            let found = all.binary_search_by_key(&vertex, |[own, _]| *own);
            found.map_or(vertex, |at| all[at][1])
        };
        let [p, q, r] = self.meshes[mesh].triangles()[triangle as usize].map(lowest);
        let name = |p: u32, q: u32| u64::from(p.min(q)) << 32 | u64::from(p.max(q));
        // No edge begins at the last of all numbers.
        let face = name(u32::MAX, u32::MAX) - u64::from(u32::MAX) + u64::from(triangle);
        [name(p, p), name(q, q), name(r, r), name(p, q), name(q, r), name(r, p), face]
    }
}
