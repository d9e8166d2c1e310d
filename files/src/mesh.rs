//! Triangle meshes as files have them.

use std::collections::{HashMap, HashSet};

/// An indexed triangle mesh, in f64 unless said otherwise: neither coordinates nor indices are checked, except that a reader
/// gives only indices of vertices that there are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh<S = f64> {
    /// Vertex positions.
    pub positions: Vec<[S; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl<S> TriangleMesh<S> {
    /// Adds a polygon as a fan around its first corner.
    pub(crate) fn push_fan(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
    }
}

impl TriangleMesh {
    /// How many coordinates no f32 is equal to. If there is none, the mesh may as well be in f32.
    pub fn beyond_f32(&self) -> usize {
        let is_beyond = |x: &&f64| !x.is_nan() && f64::from(**x as f32).to_bits() != x.to_bits();
        self.positions.as_flattened().iter().filter(is_beyond).count()
    }

    /// The mesh with the f32 nearest to each coordinate.
    pub fn into_f32(self) -> TriangleMesh<f32> {
        let positions = self.positions.iter().map(|p| p.map(|x| x as f32)).collect();
        TriangleMesh { positions, triangles: self.triangles }
    }

    /// The same with vertices at exactly the same place joined, where −0 is 0; each stays where it first appears. Triangles
    /// keep their numbers. A mesh with an index out of range stays as it is.
    ///
    /// # Examples
    /// ```
    /// use pfront_files::TriangleMesh;
    /// let positions = vec![[0.0; 3], [1.0; 3], [2.0; 3], [-0.0; 3], [1.0; 3], [3.0; 3]];
    /// let mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2], [3, 4, 5]] }.welded();
    /// assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    /// ```
    #[must_use]
    pub fn welded(self) -> Self {
        if self.triangles.iter().flatten().any(|&v| v as usize >= self.positions.len()) {
            return self;
        }
        let mut seen = HashMap::with_capacity(self.positions.len());
        let mut positions = Vec::new();
        let mut join = |p: [f64; 3]| {
            *seen.entry(place(&p)).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        };
        let joined: Vec<u32> = self.positions.into_iter().map(&mut join).collect();
        let triangles = self.triangles.into_iter().map(|t| t.map(|v| joined[v as usize]));
        Self { triangles: triangles.collect(), positions }
    }

    /// How many vertices lie exactly where another does, if no two triangles share a vertex: neighbours within such a
    /// soup are not known to be neighbours.
    pub fn unwelded(&self) -> usize {
        let mut used = vec![false; self.positions.len()];
        let mut is_new =
            |&v: &u32| used.get_mut(v as usize).is_some_and(|used| !std::mem::replace(used, true));
        if self.triangles.len() < 2 || !self.triangles.iter().flatten().all(&mut is_new) {
            return 0;
        }
        let places: HashSet<_> = self.positions.iter().map(place).collect();
        self.positions.len() - places.len()
    }

    /// Some of the triangles, with the vertices from the first to the last that they use.
    #[must_use]
    pub fn part(&self, triangles: std::ops::Range<usize>) -> Self {
        let part = &self.triangles[triangles];
        let used = || part.iter().flatten().copied();
        let first = used().min().unwrap_or(0);
        let end = used().max().map_or(0, |last| last as usize + 1).min(self.positions.len());
        let positions = self.positions.get(first as usize..end).unwrap_or_default().to_vec();
        Self { positions, triangles: part.iter().map(|t| t.map(|v| v - first)).collect() }
    }
}

/// The bits of a position, those of 0 for −0.
fn place(position: &[f64; 3]) -> [u64; 3] {
    position.map(|x| (x + 0.0).to_bits())
}
