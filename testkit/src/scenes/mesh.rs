//! The grids that all meshes but the sphere are made of.
//!
//! A grid that wraps in both directions is a torus, so it is closed and manifold whatever shape its
//! vertices take: a knot, a bored gear and a bored worm need no caps and no stitching.

use crate::MeshData;
use glam::{DVec2, DVec3};

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
) -> MeshData {
    let vertices = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    MeshData {
        positions: vertices.map(|(i, j)| round(point(i, j))).collect(),
        triangles: grid_triangles([rows, columns], [rows, columns]),
    }
}

/// The triangles of `row_steps` × `column_steps` cells over `rows` × `columns` vertices, indices
/// taken modulo the grid: as many steps as vertices close it, one fewer leaves it open.
pub(crate) fn grid_triangles(
    [rows, columns]: [usize; 2],
    [row_steps, column_steps]: [usize; 2],
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
