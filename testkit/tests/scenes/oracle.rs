//! Oracles for the scenes: whether a mesh is closed.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use pfront_testkit::MeshData;

/// The directed edges. Each may occur once, no triangle may be degenerate, no position twice, and
/// no vertex unused.
pub(crate) fn directed_edges(mesh: &MeshData) -> HashSet<(u32, u32)> {
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
pub(crate) fn assert_closed(mesh: &MeshData, genus: i64) {
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
