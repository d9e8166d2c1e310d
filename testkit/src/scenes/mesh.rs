//! Indexed triangle meshes, and the grids that all but the sphere are made of.
//!
//! A grid that wraps in both directions is a torus, so it is closed and manifold whatever shape its
//! vertices take: a knot, a bored gear and a bored worm need no caps and no stitching.

use glam::{DVec2, DVec3};

/// An indexed triangle mesh: no vertex is stored twice, and every triangle is counter-clockwise
/// seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The signed volume enclosed, positive when the triangles face outward; it means nothing for
    /// an open mesh.
    ///
    /// # Panics
    /// When a triangle names a vertex that does not exist.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let corner = |v: u32| DVec3::from(self.positions[v as usize].map(f64::from));
        self.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// Centre of the bounding box, and the radius about it that reaches every vertex.
    pub(crate) fn bounding_sphere(&self) -> (DVec3, f64) {
        let points = || self.positions.iter().map(|p| DVec3::from(p.map(f64::from)));
        let Some(first) = points().next() else { return (DVec3::ZERO, 0.0) };
        let (min, max) = points().fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p)));
        let center = (min + max) / 2.0;
        (center, points().map(|p| p.distance(center)).fold(0.0, f64::max))
    }
}

/// Rounds a computed point to the precision that meshes are stored in.
pub(crate) fn round(p: DVec3) -> [f32; 3] {
    p.to_array().map(|x| x as f32)
}

/// A torus of `rows` × `columns` vertices, 2 · `rows` · `columns` triangles; `point(row, column)`
/// places each. Outside is where (column direction) × (row direction) points.
pub(crate) fn closed_grid(
    rows: usize,
    columns: usize,
    point: impl Fn(usize, usize) -> DVec3,
) -> TriMesh {
    let vertices = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    TriMesh {
        positions: vertices.map(|(i, j)| round(point(i, j))).collect(),
        triangles: grid_triangles(rows, columns, rows, columns),
    }
}

/// The triangles of `row_steps` × `column_steps` cells over `rows` × `columns` vertices, indices
/// taken modulo the grid: as many steps as vertices close it, one fewer leaves it open.
pub(crate) fn grid_triangles(
    rows: usize,
    columns: usize,
    row_steps: usize,
    column_steps: usize,
) -> Vec<[u32; 3]> {
    let vertex = |i: usize, j: usize| ((i % rows) * columns + j % columns) as u32;
    let cells = (0..row_steps).flat_map(|i| (0..column_steps).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| {
            let (near, far) = (vertex(i, j), vertex(i + 1, j + 1));
            [[near, vertex(i, j + 1), far], [near, far, vertex(i + 1, j)]]
        })
        .collect()
}

/// Points along an open polyline, `steps[k]` from corner k on; the last corner is left out.
pub(crate) fn subdivide(corners: &[DVec2], steps: &[usize]) -> Vec<DVec2> {
    let sides = corners.windows(2).zip(steps);
    sides
        .flat_map(|(side, &n)| (0..n).map(move |k| side[0].lerp(side[1], k as f64 / n as f64)))
        .collect()
}

/// `count` scaled by `density` (1 at the default size), rounded, and at least `least`.
pub(crate) fn scaled(count: usize, density: f64, least: usize) -> usize {
    ((count as f64 * density).round() as usize).max(least)
}
