//! Separating axes: two convex sets are apart exactly if they are along one of finitely many directions.
//!
//! For triangles: the two normals and the nine cross products of edges, and for coplanar ones the six
//! directions in their planes orthogonal to edges. Nothing is normalised, nothing has a tolerance.

use glam::Vec3;
use pfront::pfront_core::Triangle;

pub(super) fn meet(a: &Triangle, b: &Triangle) -> bool {
    let [a, b] = [a, b].map(|t| t.map(Vec3::from_array));
    let edges = |t: &[Vec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (edges_a, edges_b) = (edges(&a), edges(&b));
    let (normal_a, normal_b) = (edges_a[0].cross(edges_a[1]), edges_b[0].cross(edges_b[1]));
    let separates = |axis: Vec3| {
        let range = |t: &[Vec3; 3]| {
            let [x, y, z] = t.map(|p| axis.dot(p));
            [x.min(y).min(z), x.max(y).max(z)]
        };
        let (p, q) = (range(&a), range(&b));
        p[1] < q[0] || q[1] < p[0]
    };
    let apart = separates(normal_a)
        || separates(normal_b)
        || edges_a.iter().any(|e| edges_b.iter().any(|f| separates(e.cross(*f))))
        || edges_a.iter().any(|e| separates(normal_a.cross(*e)))
        || edges_b.iter().any(|e| separates(normal_b.cross(*e)));
    !apart
}
