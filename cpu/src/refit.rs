//! Refitting on several threads.

use pfront_core::{Mesh, Node, build};

/// [`build::refit_with`] in the rayon pool of the calling thread.
///
/// # Panics
/// As [`build::refit_with`].
///
/// # Examples
/// ```
/// # use pfront_core::{Mesh, Node, build::REBUILD_RATIO};
/// # fn rebuild() {}
/// # fn f(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32], when_built: f32) {
/// if pfront_cpu::refit(mesh, nodes, order) > REBUILD_RATIO * when_built {
///     rebuild();
/// }
/// # }
/// ```
pub fn refit(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) -> f32 {
    build::refit_with(mesh, nodes, order, &|a, b| {
        rayon::join(a, b);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::build::{BuildOptions, BvhStorage, SahItem};
    use pfront_core::bvh::node_bound;
    use pfront_scenes::icosphere;

    #[test]
    fn parts_give_the_boxes_of_the_whole() {
        for triangles in [0, 1, 20, 30_000] {
            let mut ball = icosphere(triangles.max(20));
            ball.triangles.truncate(triangles);
            let squeezed: Vec<_> =
                ball.positions.iter().map(|p| [p[0], p[1] * p[0], 0.0]).collect();
            let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
            let n = ball.triangles.len();
            for morton in [false, true] {
                let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                let options = BuildOptions { leaf_size: 1 };
                let built = if morton {
                    build::morton(mesh, &options, storage, &mut vec![0; 2 * n])
                } else {
                    build::sah(mesh, &options, storage, &mut vec![SahItem::default(); n])
                };
                let used = built.unwrap().nodes().len();
                nodes.truncate(used);
                let mut whole = nodes.clone();
                let moved = mesh.with_positions(&squeezed).unwrap();
                let quality = build::refit(moved, &mut whole, &order);
                let in_parts = refit(moved, &mut nodes, &order);
                assert!((in_parts - quality).abs() <= 1e-5 * quality, "{in_parts} {quality}");
                assert!(nodes == whole);
            }
        }
    }
}
