//! Triangle meshes as files have them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

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

impl<S> TriangleMesh<S> {
    /// Adds the triangles of a strip, of which every other is turned round. Triangles with a corner twice are left out.
    pub(crate) fn push_strip(&mut self, corners: &[u32]) {
        let turns = [false, true].into_iter().cycle();
        self.triangles.extend(
            corners
                .windows(3)
                .zip(turns)
                .filter(|(t, _)| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
                .map(|(t, odd)| if odd { [t[1], t[0], t[2]] } else { [t[0], t[1], t[2]] }),
        );
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

    /// Joins vertices at exactly the same place, where −0 is 0; each stays where it first appears. Triangles keep their
    /// numbers.
    pub(crate) fn weld(&mut self) {
        let mut seen = HashMap::with_capacity(self.positions.len());
        self.join(|position, next| match seen.entry(place(position)) {
            Entry::Occupied(first) => *first.get(),
            Entry::Vacant(new) => *new.insert(next),
        });
    }

    /// Joins each vertex with the first within a distance, and returns how many that moves. Triangles keep their numbers.
    ///
    /// # Examples
    /// ```
    /// use pfront_files::TriangleMesh;
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1e-7, 0.0]];
    /// let mut mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2], [2, 3, 0]] };
    /// assert_eq!(mesh.weld_within(1e-6), 1);
    /// assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 0]]);
    /// ```
    pub fn weld_within(&mut self, distance: f64) -> usize {
        self.weld();
        let before = self.positions.len();
        if distance > 0.0 && distance.is_finite() {
            // Cells by the bits of their numbers, as coordinates may be far larger than the distance.
            let mut cells: HashMap<[u64; 3], Vec<(u32, [f64; 3])>> = HashMap::new();
            self.join(|position, next| {
                let at = position.map(|x| {
                    let cell = (x / distance).floor();
                    if cell.is_finite() { cell } else { x }
                });
                let beside = |i: i32| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
                let near = (0..27).filter_map(|i| {
                    let by = beside(i);
                    cells.get(&place(&[0, 1, 2].map(|k| at[k] + f64::from(by[k]))))
                });
                let is_near = |(_, other): &&(u32, [f64; 3])| {
                    let square = |k: usize| (position[k] - other[k]).powi(2);
                    square(0) + square(1) + square(2) <= distance * distance
                };
                let first = near.flatten().filter(is_near).map(|(number, _)| *number).min();
                first.unwrap_or_else(|| {
                    cells.entry(place(&at)).or_default().push((next, *position));
                    next
                })
            });
        }
        before - self.positions.len()
    }

    /// Joins vertices: `first` gives the number of the vertex that one becomes, or the number that is next.
    fn join(&mut self, mut first: impl FnMut(&[f64; 3], u32) -> u32) {
        let mut kept = 0;
        let mut numbers = Vec::with_capacity(self.positions.len());
        for vertex in 0..self.positions.len() {
            let number = first(&self.positions[vertex], kept);
            if number == kept {
                self.positions[kept as usize] = self.positions[vertex];
                kept += 1;
            }
            numbers.push(number);
        }
        self.positions.truncate(kept as usize);
        self.triangles.as_flattened_mut().iter_mut().for_each(|v| *v = numbers[*v as usize]);
    }

    /// Some of the triangles, with the vertices that they use in the order of their numbers.
    #[must_use]
    pub fn part(&self, triangles: &[u32]) -> Self {
        let part: Vec<_> = triangles.iter().map(|&t| self.triangles[t as usize]).collect();
        let mut used: Vec<u32> = part.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap_or_else(|at| at) as u32;
        let triangles = part.iter().map(|t| t.map(number)).collect();
        let positions = used.iter().map(|&v| self.positions[v as usize]).collect();
        Self { positions, triangles }
    }
}

/// The bits of a position, those of 0 for −0.
fn place(position: &[f64; 3]) -> [u64; 3] {
    position.map(|x| (x + 0.0).to_bits())
}
