//! The truth, by the exact oracle in a loop over all pairs.

use pfront::TrianglePair;
use pfront_testkit::MeshData;
use pfront_testkit::Point;
use pfront_testkit::oracle::{intersect, self_hit, share_a_vertex};
use std::collections::HashMap;

/// The oracle, and what it has said: from step to step most triangles stay, and it takes its time.
#[derive(Debug, Default)]
pub(crate) struct Truth {
    known: HashMap<[[[u32; 3]; 3]; 2], bool>,
}

impl Truth {
    /// Triangles of two meshes in one frame that meet, sorted.
    pub(crate) fn between(&mut self, a: &MeshData, b: &MeshData) -> Vec<TrianglePair> {
        let mut found = Vec::new();
        for i in 0..a.triangles.len() {
            for j in 0..b.triangles.len() {
                if self.meet(corners(a, i), corners(b, j)) {
                    found.push(pair(i, j));
                }
            }
        }
        found
    }

    /// Triangles of one mesh that meet by the rule of shared indices, or share none and meet; sorted.
    pub(crate) fn within(&mut self, soup: &MeshData, skip_neighbours: bool) -> Vec<TrianglePair> {
        let mut found = Vec::new();
        for (i, &s) in soup.triangles.iter().enumerate() {
            for (j, &t) in soup.triangles.iter().enumerate().skip(i + 1) {
                let hit = if share_a_vertex(s, t) {
                    !skip_neighbours && self_hit(s, t, &soup.positions)
                } else {
                    self.meet(corners(soup, i), corners(soup, j))
                };
                if hit {
                    found.push(pair(i, j));
                }
            }
        }
        found
    }

    fn meet(&mut self, a: [Point; 3], b: [Point; 3]) -> bool {
        let key = [a, b].map(|t| t.map(|p| p.map(f32::to_bits)));
        boxes_meet(&a, &b) && *self.known.entry(key).or_insert_with(|| intersect(&a, &b))
    }
}

/// Pairs of triangles of one mesh whose boxes overlap, sorted.
pub(crate) fn overlapping(soup: &MeshData) -> Vec<TrianglePair> {
    let count = soup.triangles.len();
    let all = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
    let meet = all.filter(|&(i, j)| boxes_meet(&corners(soup, i), &corners(soup, j)));
    meet.map(|(i, j)| pair(i, j)).collect()
}

fn boxes_meet(a: &[Point; 3], b: &[Point; 3]) -> bool {
    let range =
        |[p, q, r]: &[Point; 3], k: usize| (p[k].min(q[k]).min(r[k]), p[k].max(q[k]).max(r[k]));
    (0..3).all(|k| {
        let (s, t) = (range(a, k), range(b, k));
        s.0 <= t.1 && t.0 <= s.1
    })
}

fn corners(soup: &MeshData, triangle: usize) -> [Point; 3] {
    soup.triangles[triangle].map(|v| soup.positions[v as usize])
}

fn pair(a: usize, b: usize) -> TrianglePair {
    TrianglePair { a: a as u32, b: b as u32 }
}
