//! Builds, refits and certificates in the parts that [`pfront_cpu::join`] runs: the same as in one.

use pfront_core::bvh::{BuildOptions, BvhStorage, Join, Refit, morton, node_bound, refit, sah};
use pfront_core::one_ring::{OneRings, history_bound, links_bound};
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

#[test]
fn parts_give_the_certificates_of_the_whole() {
    let mut ball = icosphere(30_000);
    for (p, i) in ball.positions.iter_mut().zip(0..) {
        // Some vertices stick out, so that those around them are not certified.
        let out = if i % 17 == 0 { 1.5 } else { 1.0 };
        *p = p.map(|x| x * out);
    }
    let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
    let (vertices, triangles) = (ball.positions.len(), ball.triangles.len());
    let mut history = vec![0; history_bound(vertices)];
    let mut links = vec![0; links_bound(vertices, triangles)];
    OneRings::new(vertices, &ball.triangles, &mut history, &mut links).unwrap();
    let mut certified = |join: Option<&Join<'_>>| -> Vec<bool> {
        let rings = OneRings::new_unchecked(vertices, &ball.triangles, &mut history);
        let mut rings = rings.with_links(&mut links).unwrap();
        let certified = rings.certify(mesh, join);
        (0..vertices as u32).map(|vertex| certified.is_certified(vertex)).collect()
    };
    let whole = certified(None);
    assert!(whole.contains(&true) && whole.contains(&false));
    for _ in 0..4 {
        assert_eq!(certified(Some(&join)), whole);
    }
}
