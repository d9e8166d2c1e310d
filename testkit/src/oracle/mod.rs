//! Exact truth: which triangles share a point, decided by another method than the library's.
//!
//! The library decides signs of orientation determinants, case by case. Here there are no cases.
//! Two convex hulls are apart exactly if a plane separates them strictly, and if any plane does, so
//! does the one orthogonal to the shortest vector z between them (`separated`, below). The vector z is a
//! difference of two corners, or what is left of one orthogonally to an edge, or orthogonal to two edges:
//! 78 candidates for two triangles, all of which are tried in integers. Nothing changes where triangles are
//! segments or points, coplanar, or equal.

mod crossing;
mod distance;
mod lattice;
mod meet;
mod mesh;
mod motion;
mod segment;
mod sturm;
mod volume;

pub use crossing::crossing_points;
pub use distance::{within, within_at, within_each};
pub use lattice::Coordinate;
pub use meet::{Meet, OnLattice, meet};
pub use mesh::{pairs, self_hit, self_pairs, share_a_vertex};
pub use motion::{MovingTriangle, meet_while_moving, self_hit_while_moving};
pub use segment::first_parameter;
pub use volume::overlap_volume;

use lattice::{Integer, Vector, cross, dot, minus, times};

/// Whether two closed triangles share a point; one without area is its segment or point.
pub fn intersect<C: Coordinate>(a: &[[C; 3]; 3], b: &[[C; 3]; 3]) -> bool {
    hulls_meet(a, b)
}

/// Whether the convex hulls of two sets of points share a point. The hull of no points is empty.
pub fn hulls_meet<C: Coordinate>(a: &[[C; 3]], b: &[[C; 3]]) -> bool {
    if a.is_empty() || b.is_empty() {
        return false;
    }
    match lattice::small(a, b) {
        Some([a, b]) => !separated(&a, &b),
        None => {
            let [a, b] = lattice::wide(a, b);
            !separated(&a, &b)
        }
    }
}

/// Whether some plane has the hull of `p` strictly on one side and the hull of `q` on the other.
///
/// If the hulls are apart, let z be the shortest vector from one to the other, that is the point
/// nearest to the origin in the convex set D = hull(p) − hull(q). All of D has z·x ≥ z·z > 0, so z
/// is the normal of such a plane. z lies inside a face of D and is orthogonal to it. A face of D is
/// the difference of a face of hull(p) and one of hull(q), so that it is
/// a corner of D: z = pᵢ − qⱼ; or an edge, along an edge w of p or q: z = (pᵢ − qⱼ) less its part
/// along w; or wider, and contains the directions of two edges: z is along their cross product.
fn separated<T: Integer>(p: &[Vector<T>], q: &[Vector<T>]) -> bool {
    let separates = |normal: &Vector<T>| {
        let [p, q] = [p, q].map(|set| set.iter().map(|x| dot(normal, x)).collect::<Vec<_>>());
        p.iter().max() < q.iter().min() || q.iter().max() < p.iter().min()
    };
    let edges: Vec<_> = [p, q].into_iter().flat_map(edges).collect();
    let gaps: Vec<_> = p.iter().flat_map(|x| q.iter().map(|y| minus(x, y))).collect();
    let orthogonal = |gap, w| minus(&times(&dot(w, w), gap), &times(&dot(w, gap), w));

    let mut wider =
        edges.iter().enumerate().flat_map(|(i, v)| edges[..i].iter().map(|w| cross(v, w)));
    wider.any(|normal| separates(&normal))
        || gaps.iter().any(separates)
        || gaps.iter().any(|gap| edges.iter().any(|w| separates(&orthogonal(gap, w))))
}

fn edges<T: Integer>(p: &[Vector<T>]) -> impl Iterator<Item = Vector<T>> {
    p.iter().enumerate().flat_map(|(i, x)| p[..i].iter().map(move |y| minus(x, y)))
}
