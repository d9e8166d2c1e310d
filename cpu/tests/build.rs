//! Builds and refits in the parts that [`pfront_cpu::join`] runs: the same as in one.

use pfront_core::bvh::{BuildOptions, BvhStorage, Join, Refit, morton, node_bound, refit, sah};
use pfront_core::{Mesh, Node};
use pfront_cpu::join;
use pfront_testkit::scenes::icosphere;

#[test]
fn parts_give_the_tree_of_the_whole() {
    for triangles in [0, 1, 20, 30_000, 200_000] {
        let mut ball = icosphere(triangles.max(20));
        ball.triangles.truncate(triangles);
        let squeezed: Vec<_> = ball.positions.iter().map(|p| [p[0], p[1] * p[0], 0.0]).collect();
        let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
        let n = ball.triangles.len();
        for (by_morton, leaf_size) in [(false, 1), (false, 8), (true, 1), (true, 8)] {
            let (mut items, mut keys) = (vec![Node::EMPTY; n], vec![0; 2 * n]);
            let threads: Option<&Join<'_>> = Some(&join);
            let mut built = |join: Option<&Join<'_>>| {
                let options = BuildOptions { leaf_size, join };
                let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                let bvh = match by_morton {
                    false => sah(mesh, &options, storage, &mut items),
                    true => morton(mesh, &options, storage, &mut keys),
                };
                let used = bvh.unwrap().nodes().len();
                nodes.truncate(used);
                (nodes, order)
            };
            let (mut whole, order) = built(None);
            let (mut nodes, same_order) = built(threads);
            assert!(nodes == whole && order == same_order, "{triangles} {by_morton}");

            let moved = mesh.with_positions(&squeezed).unwrap();
            let quality = refit(moved, &mut whole, &order, Refit::default());
            let options = Refit { join: threads, ..Refit::default() };
            assert_eq!(refit(moved, &mut nodes, &order, options), quality);
            assert!(nodes == whole);
        }
    }
}
