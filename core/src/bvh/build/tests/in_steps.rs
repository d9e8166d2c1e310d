//! Builds in steps.

use super::*;
use crate::bvh::*;

#[test]
fn steps_build_the_tree_of_the_whole() {
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let n = triangles.len();
        for leaf_size in [1, 8] {
            let options = BuildOptions { leaf_size, join: None };
            let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
            let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
            let whole = sah(mesh, &options, storage, &mut vec![Node::EMPTY; n]).unwrap();
            let mut expected = whole.nodes().to_vec();
            refit(mesh, &mut expected, whole.order(), Refit::default()).unwrap();

            let (mut steps, mut order) = (SahSteps::new(), vec![0; n]);
            let (mut nodes, mut items) = (Vec::new(), Vec::new());
            let mut largest = 0;
            while !steps.is_done(mesh) {
                // Room is made as it is needed.
                nodes.resize(steps.nodes() + 2, Node::EMPTY);
                items.resize((items.len() + 100).min(n), Node::EMPTY);
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                let gone = steps.step(mesh, &options, storage, &mut items).unwrap();
                assert!(gone > 0, "{name}");
                largest = largest.max(gone);
            }
            nodes.truncate(steps.nodes());
            refit(mesh, &mut nodes, &order, Refit::default()).unwrap();
            assert_eq!(order, whole.order(), "{name}");
            assert_eq!(bytemuck::cast_slice::<_, u32>(&nodes), bytemuck::cast_slice(&expected));
            assert!(largest <= n);
        }
    }
}

#[test]
fn a_step_without_room_is_an_error_and_can_be_done_again() {
    let MeshData { positions, triangles } = sheet(3, |_, _| 0.0);
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    let (options, mut steps) = (BuildOptions::default(), SahSteps::new());
    let mut advance = |nodes: usize, order: usize, items: usize| {
        let (mut nodes, mut order) = (vec![Node::EMPTY; nodes], vec![0; order]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        steps.step(mesh, &options, storage, &mut vec![Node::EMPTY; items]).map_err(|e| e.buffer)
    };
    assert_eq!(advance(2, 17, 18), Err("order"));
    assert_eq!(advance(1, 18, 18), Err("nodes"));
    assert_eq!(advance(2, 18, 0), Err("items"));
    assert_eq!(advance(2, 18, 10), Ok(10));
    assert_eq!(advance(2, 18, 18), Ok(8));
    assert_eq!(advance(3, 18, 18), Err("nodes"));
    assert_eq!(advance(4, 18, 18), Ok(18));
}
