//! Small meshes for the tests: smooth, flat, tangled, degenerate, from every scale of f32.

use crate::families::Family;
use crate::{MeshData, Point, Rows, Triangle, grid_triangles};
use rand::{Rng, RngExt};

/// Triangles of a family, `pairs` times two, that share no index.
pub fn family(family: Family, pairs: usize, rng: &mut impl Rng) -> MeshData {
    MeshData::of((0..pairs).flat_map(|_| <[Triangle; 2]>::from(family.pair(rng))))
}

/// Random indices into few lattice points: every degenerate triangle and every way to share.
pub fn tangle(vertices: u32, triangles: usize, size: i32, rng: &mut impl Rng) -> MeshData {
    let mut lattice = || [0; 3].map(|_| rng.random_range(-size..=size) as f32);
    let positions = (0..vertices).map(|_| lattice()).collect();
    let mut corners = || [0; 3].map(|_| rng.random_range(0..vertices));
    let triangles = (0..triangles).map(|_| corners()).collect();
    MeshData { positions, triangles }
}

/// A row of triangles, each of which shares an edge with the next.
pub fn strip(triangles: u32) -> MeshData {
    let vertices = if triangles == 0 { 0 } else { triangles + 2 };
    let position = |v: u32| [v as f32, (v % 2) as f32, 0.1 * v as f32];
    MeshData {
        positions: (0..vertices).map(position).collect(),
        triangles: (0..triangles).map(|t| [t, t + 1, t + 2]).collect(),
    }
}

/// A square of n × n cells over −1 ..= 1 at the heights of a function.
pub fn sheet(n: u32, height: impl Fn(f32, f32) -> f32) -> MeshData {
    let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| (at(i), at(j))));
    MeshData {
        positions: points.map(|(x, y)| [x, y, height(x, y)]).collect(),
        triangles: grid_triangles([n as usize + 1; 2], [n as usize; 2]),
    }
}

/// A sheet with hills.
pub fn bumpy(n: u32) -> MeshData {
    sheet(n, |x, y| 0.2 * (3.5 * x).sin() * (4.5 * y).cos())
}

/// A closed sphere of radius 1: a sheet bent round, with triangles without area at the poles.
pub fn sphere(n: u32) -> MeshData {
    use std::f64::consts::PI;
    let bend = |[u, v, _]: [f32; 3]| {
        // The seam has the same positions, but not the same vertices, on both sides.
        let (u, v) = (if u == 1.0 { -PI } else { f64::from(u) * PI }, f64::from(v) * PI / 2.0);
        let ring = if v.abs() == PI / 2.0 { 0.0 } else { v.cos() };
        [ring * u.cos(), ring * u.sin(), v.sin()].map(|x| x as f32)
    };
    sheet(n, |_, _| 0.0).map(bend)
}

/// Several meshes as one.
pub fn union(meshes: &[MeshData]) -> MeshData {
    let mut all = MeshData::default();
    for mesh in meshes {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// A point of the cube of an edge length around the origin.
pub fn point(edge: f32, rng: &mut impl Rng) -> Point {
    [0; 3].map(|_| rng.random_range(-0.5..0.5f32) * edge)
}

/// A turn about a random axis, rounded to f32, and a move by at most `reach`.
pub fn pose_rows(reach: f32, rng: &mut impl Rng) -> Rows {
    let mut q = [0; 4].map(|_| rng.random_range(-1.0..1.0f64));
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q = q.map(|x| x / length);
    let [w, x, y, z] = q;
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let mut row =
        |[x, y, z]: [f64; 3]| [x as f32, y as f32, z as f32, rng.random_range(-1.0..=1.0) * reach];
    rotation.map(&mut row)
}

/// Positions posed as `accuracy.md` (contract 2) fixes it, written out here once more.
pub fn posed(positions: &[Point], rows: &Rows) -> Vec<Point> {
    let coordinate = |r: [f32; 4], p: &Point| {
        let (x, y, z) = (r[0] * p[0], r[1] * p[1], r[2] * p[2]);
        let xy = x + y;
        let xyz = xy + z;
        xyz + r[3]
    };
    positions.iter().map(|p| rows.map(|r| coordinate(r, p))).collect()
}
