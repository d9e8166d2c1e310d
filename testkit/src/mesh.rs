//! Meshes as plain arrays, as files and generators have them.

use crate::{Point, Triangle};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// An indexed triangle mesh, in f32 unless said otherwise: neither coordinates nor indices are checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData<P = Point> {
    /// Vertex positions.
    pub positions: Vec<P>,
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
}

impl<P: Place> MeshData<P> {
    /// Adds a polygon as a fan around its first corner.
    pub fn push_fan(&mut self, corners: &[u32]) {
        let [first, rest @ ..] = corners else { return };
        self.triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
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
        let mut join = |p: P| {
            *seen.entry(p.place()).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        };
        let joined: Vec<u32> = self.positions.into_iter().map(&mut join).collect();
        let triangles = self.triangles.into_iter().map(|t| t.map(|v| joined[v as usize]));
        Self { triangles: triangles.collect(), positions }
    }

    /// Some of the triangles, with the vertices from the first to the last that they use; an index out of range stays
    /// so.
    pub fn part(&self, triangles: Range<usize>) -> Self {
        let part = &self.triangles[triangles];
        let used = || part.iter().flatten().copied();
        let first = used().min().unwrap_or(0);
        let end = used().max().map_or(0, |last| last as usize + 1).min(self.positions.len());
        let positions = self.positions.get(first as usize..end).unwrap_or_default().to_vec();
        Self { positions, triangles: part.iter().map(|t| t.map(|v| v - first)).collect() }
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
        let places: HashSet<_> = self.positions.iter().map(P::place).collect();
        self.positions.len() - places.len()
    }
}

/// A position of a vertex.
pub trait Place: Copy {
    /// Its bits, those of 0 for −0.
    fn place(&self) -> [u64; 3];
}

impl Place for Point {
    fn place(&self) -> [u64; 3] {
        self.map(|x| (x + 0.0).to_bits().into())
    }
}

impl Place for [f64; 3] {
    fn place(&self) -> [u64; 3] {
        self.map(|x| (x + 0.0).to_bits())
    }
}
