//! Meshes as plain arrays.

use crate::{Point, Triangle};
use glam::DVec3;
use std::collections::HashMap;

/// An indexed triangle mesh in f32: neither coordinates nor indices are checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<Point>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshData {
    /// Triangles that share no vertex.
    pub fn of(triangles: impl IntoIterator<Item = Triangle>) -> Self {
        let positions: Vec<_> = triangles.into_iter().flatten().collect();
        let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        Self { triangles: triangles.collect(), positions }
    }

    /// The same triangles with every vertex changed.
    pub fn map(mut self, change: impl FnMut(Point) -> Point) -> Self {
        self.positions = self.positions.into_iter().map(change).collect();
        self
    }

    /// The signed volume enclosed, positive when the triangles face outward; it means nothing for an open mesh.
    ///
    /// # Panics
    /// When a triangle names a vertex that does not exist.
    pub fn volume(&self) -> f64 {
        let corner = |v: u32| DVec3::from(self.positions[v as usize].map(f64::from));
        self.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// The centre of the bounding box, and the radius about it that reaches every vertex.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        let points = || self.positions.iter().map(|p| DVec3::from(p.map(f64::from)));
        let Some(first) = points().next() else { return (DVec3::ZERO, 0.0) };
        let (min, max) = points().fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p)));
        let center = (min + max) / 2.0;
        (center, points().map(|p| p.distance(center)).fold(0.0, f64::max))
    }

    /// The same with vertices at exactly the same place joined, where −0 is 0; each stays where it first
    /// appears. Triangles keep their numbers. A mesh with an index out of range stays as it is.
    ///
    /// # Examples
    /// ```
    /// use pfront_testkit::MeshData;
    /// let positions = vec![[0.0; 3], [1.0; 3], [2.0; 3], [-0.0; 3], [1.0; 3], [3.0; 3]];
    /// let mesh = MeshData { positions, triangles: vec![[0, 1, 2], [3, 4, 5]] }.welded();
    /// assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    /// ```
    pub fn welded(self) -> Self {
        if self.triangles.iter().flatten().any(|&v| v as usize >= self.positions.len()) {
            return self;
        }
        let mut seen = HashMap::with_capacity(self.positions.len());
        let mut positions = Vec::new();
        let mut join = |p: Point| {
            *seen.entry(p.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        };
        let joined: Vec<u32> = self.positions.into_iter().map(&mut join).collect();
        let triangles = self.triangles.into_iter().map(|t| t.map(|v| joined[v as usize]));
        Self { triangles: triangles.collect(), positions }
    }
}
