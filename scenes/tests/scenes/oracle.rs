//! Oracles for the scenes: whether a mesh is closed, and how two posed meshes touch. All naive.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use pfront_scenes::{Pose, TriMesh};

pub(crate) type Triangle = [DVec3; 3];

/// The directed edges. Each may occur once, no triangle may be degenerate, no position twice, and
/// no vertex unused.
pub(crate) fn directed_edges(mesh: &TriMesh) -> HashSet<(u32, u32)> {
    let places: HashSet<[u32; 3]> =
        mesh.positions.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
    assert_eq!(places.len(), mesh.positions.len(), "a position occurs twice");
    let mut edges = HashSet::new();
    let mut used = vec![false; mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        let [p, q, r] = [a, b, c].map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
        assert!((q - p).cross(r - p).length() > 0.0, "triangle {a} {b} {c} has no area");
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert(edge), "edge {edge:?} occurs twice in one direction");
            used[edge.0 as usize] = true;
        }
    }
    assert!(used.iter().all(|&u| u), "a vertex is in no triangle");
    edges
}

/// Closed, manifold at edges and vertices, consistently turned, and turned outward.
pub(crate) fn assert_closed(mesh: &TriMesh, genus: i64) {
    let edges = directed_edges(mesh);
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "an edge has one triangle");
    // With one fan round each vertex in a connected mesh, Euler's formula fixes the genus.
    let euler = mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64;
    assert_eq!(euler, 2 - 2 * genus);
    let mut next: HashMap<(u32, u32), u32> = HashMap::new();
    let mut degree = vec![0; mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (v, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            next.insert((v, from), to);
            degree[v as usize] += 1;
        }
    }
    for &[v, start, _] in &mesh.triangles {
        let (mut at, mut steps) = (start, 0);
        while steps == 0 || at != start {
            (at, steps) = (next[&(v, at)], steps + 1);
        }
        assert_eq!(steps, degree[v as usize], "the triangles round vertex {v} are not one fan");
    }
    assert!(mesh.volume() > 0.0, "the mesh is inside out");
}

/// The mesh's triangles in the world.
pub(crate) fn posed(mesh: &TriMesh, pose: &Pose) -> Vec<Triangle> {
    let place = |v: u32| {
        let p = mesh.positions[v as usize].map(f64::from);
        DVec3::from(pose.map(|r| {
            let [x, y, z, t] = r.map(f64::from);
            x * p[0] + y * p[1] + z * p[2] + t
        }))
    };
    mesh.triangles.iter().map(|t| t.map(place)).collect()
}

/// A grid of cells over triangles, by which to find those near others.
pub(crate) struct Grid<'a> {
    triangles: &'a [Triangle],
    cell: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Grid<'a> {
    pub(crate) fn new(triangles: &'a [Triangle], cell: f64) -> Self {
        let mut grid = Self { triangles, cell, cells: HashMap::new() };
        for (k, t) in triangles.iter().enumerate() {
            for cell in grid.covered(t) {
                grid.cells.entry(cell).or_default().push(k);
            }
        }
        grid
    }

    fn covered(&self, t: &Triangle) -> Vec<[i64; 3]> {
        let (lo, hi) = bounds(t);
        let [lo, hi] = [lo, hi].map(|p| (p / self.cell).floor().to_array().map(|x| x as i64));
        let mut cells = Vec::new();
        for x in lo[0]..=hi[0] {
            for y in lo[1]..=hi[1] {
                cells.extend((lo[2]..=hi[2]).map(|z| [x, y, z]));
            }
        }
        cells
    }

    /// The triangles whose boxes overlap that of `t`.
    pub(crate) fn near(&self, t: &Triangle) -> Vec<usize> {
        let (lo, hi) = bounds(t);
        let cells = self.covered(t);
        let found = cells.iter().filter_map(|c| self.cells.get(c)).flatten().copied();
        let mut found: Vec<usize> = found
            .filter(|&k| {
                let (l, h) = bounds(&self.triangles[k]);
                l.cmple(hi).all() && lo.cmple(h).all()
            })
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn bounds(t: &Triangle) -> (DVec3, DVec3) {
    (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]))
}

/// Every intersecting pair, in general position.
pub(crate) fn pairs(a: &[Triangle], b: &[Triangle], cell: f64) -> Vec<(usize, usize)> {
    let grid = Grid::new(a, cell);
    let of = |(j, t): (usize, &Triangle)| {
        let near = grid.near(t).into_iter().filter(|&i| intersect(&a[i], t));
        near.map(move |i| (i, j)).collect::<Vec<_>>()
    };
    b.iter().enumerate().flat_map(of).collect()
}

/// Pairs of triangles of one mesh that cross and share no vertex.
pub(crate) fn self_pairs(mesh: &TriMesh, positions: &[[f32; 3]], cell: f64) -> Vec<(usize, usize)> {
    let corner = |v: u32| DVec3::from(positions[v as usize].map(f64::from));
    let triangles: Vec<Triangle> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
    let apart = |&(i, j): &(usize, usize)| {
        i < j && !mesh.triangles[i].iter().any(|v| mesh.triangles[j].contains(v))
    };
    let grid = Grid::new(&triangles, cell);
    let mut found = Vec::new();
    for (j, t) in triangles.iter().enumerate() {
        let near = grid.near(t).into_iter().map(|i| (i, j)).filter(apart);
        found.extend(near.filter(|&(i, _)| intersect(&triangles[i], t)));
    }
    found
}

/// In general position two triangles meet when an edge of one pierces the other.
pub(crate) fn intersect(a: &Triangle, b: &Triangle) -> bool {
    let edges = |t: &Triangle| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    edges(a).iter().any(|&e| pierces(e, b)) || edges(b).iter().any(|&e| pierces(e, a))
}

/// More than f32 rounds coordinates of these scenes by.
const ROUNDING: f64 = 1e-5;

fn pierces((p, q): (DVec3, DVec3), [a, b, c]: &Triangle) -> bool {
    let side = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let [above, below] = [side(*a, *b, *c, p), side(*a, *b, *c, q)];
    // An edge in the triangle's plane, but for rounding to f32, does not pierce it.
    let flat = ROUNDING * (*b - *a).cross(*c - *a).length();
    if (above > 0.0) == (below > 0.0) || above.abs().max(below.abs()) < flat {
        return false;
    }
    let turns = [side(p, q, *a, *b), side(p, q, *b, *c), side(p, q, *c, *a)].map(|s| s > 0.0);
    turns[0] == turns[1] && turns[1] == turns[2]
}

/// How deep the deepest vertex of `a` lies in the closed mesh `b`; 0 when none does.
pub(crate) fn depth(a: &[Triangle], b: &[Triangle]) -> f64 {
    let bounds_of = |ts: &[Triangle]| {
        ts.iter().map(bounds).reduce(|x, y| (x.0.min(y.0), x.1.max(y.1))).expect("triangles")
    };
    let (lo, hi) = bounds_of(b);
    // In an oblique direction the ray meets no edge.
    let far = DVec3::new(0.571, 0.613, 0.743) * 1e3;
    let inside = |p: DVec3| b.iter().filter(|t| pierces((p, p + far), t)).count() % 2 == 1;
    let vertices: HashSet<[u64; 3]> =
        a.iter().flatten().map(|p| p.to_array().map(f64::to_bits)).collect();
    vertices
        .iter()
        .map(|p| DVec3::from(p.map(f64::from_bits)))
        .filter(|p| p.cmpge(lo).all() && p.cmple(hi).all() && inside(*p))
        .map(|p| b.iter().map(|t| distance(p, t)).fold(f64::INFINITY, f64::min))
        .fold(0.0, f64::max)
}

fn distance(p: DVec3, [a, b, c]: &Triangle) -> f64 {
    let normal = (*b - *a).cross(*c - *a).normalize();
    let foot = p - normal * (p - *a).dot(normal);
    let edges = [(*a, *b), (*b, *c), (*c, *a)];
    if edges.iter().all(|&(x, y)| (y - x).cross(foot - x).dot(normal) >= 0.0) {
        return p.distance(foot);
    }
    let to_edge = |(x, y): (DVec3, DVec3)| {
        let along = ((p - x).dot(y - x) / (y - x).length_squared()).clamp(0.0, 1.0);
        p.distance(x.lerp(y, along))
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}
