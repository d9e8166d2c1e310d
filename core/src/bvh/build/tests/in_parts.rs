//! Builds in parts, in memory that just suffices.

use super::*;
use crate::bvh::*;

#[test]
fn parts_give_the_tree_of_the_whole() {
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let count = triangles.len();
        for leaf_size in [1, 3, 8] {
            with_builds(mesh, leaf_size, |build, whole| {
                for (way, join) in joins().into_iter().enumerate() {
                    let mut nodes = vec![Node::EMPTY; node_bound(count)];
                    let mut order = vec![0; count];
                    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                    let options = BuildOptions { leaf_size, join: Some(join) };
                    let in_parts = if build == "sah" {
                        sah(mesh, &options, storage, &mut vec![Node::EMPTY; count]).unwrap()
                    } else {
                        let mut keys = vec![7; 2 * count];
                        morton(mesh, &options, storage, &mut keys).unwrap()
                    };
                    let context = format!("{build} of {name}, way {way}, leaves of {leaf_size}");
                    let bits = |bvh: Bvh<'_>| bytemuck::cast_slice::<_, u32>(bvh.nodes()).to_vec();
                    assert_eq!(bits(in_parts), bits(whole), "{context}");
                    assert_eq!(in_parts.order(), whole.order(), "{context}");
                }
            });
        }
    }
}

#[test]
fn keys_are_sorted_by_their_upper_bits() {
    let mut rng = seeded(11);
    for (count, bits) in
        [(0, 9), (1, 27), (25, 27), (64, 3), (65, 27), (500, 27), (900, 1), (900, 27)]
    {
        let key = |index| rng.random_range(0..1_u64 << bits) << 31 | index;
        let keys: Vec<u64> = (0..count).map(key).collect();
        let (mut found, mut sorted) = (vec![0; keys.len()], keys.clone());
        sorted.sort_unstable();
        for join in [None].into_iter().chain(joins().map(Some)) {
            radix::sort(&mut keys.clone(), &mut found, 31, join);
            assert_eq!(found, sorted, "{count} keys of {bits} bits");
        }
    }
}

#[test]
fn builds_need_no_more_nodes_than_there_are_and_say_how_many() {
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let count = triangles.len();
        for leaf_size in [8, 3, 1] {
            let context = format!("{name} with leaves of {leaf_size}");
            let mut roomy = vec![];
            with_builds(mesh, leaf_size, |_, bvh| roomy.push(bvh.nodes().to_vec()));
            let in_nodes = |by_sah: bool, nodes: usize, join: Option<&Join<'_>>| {
                let (mut nodes, mut order) = (vec![Node::EMPTY; nodes], vec![0; count]);
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                let options = BuildOptions { leaf_size, join };
                let built = if by_sah {
                    sah(mesh, &options, storage, &mut vec![Node::EMPTY; count])
                } else {
                    morton(mesh, &options, storage, &mut vec![0; 2 * count])
                };
                built.map(|bvh| bvh.nodes().to_vec())
            };
            for (by_sah, roomy) in [(true, &roomy[0]), (false, &roomy[1])] {
                for join in [None].into_iter().chain(joins().map(Some)) {
                    assert_eq!(
                        in_nodes(by_sah, roomy.len(), join).as_ref(),
                        Ok(roomy),
                        "{context}"
                    );
                }
                if let Some(short) = roomy.len().checked_sub(1) {
                    let error = in_nodes(by_sah, short, None).unwrap_err();
                    assert_eq!((error.buffer, error.needed), ("nodes", roomy.len()), "{context}");
                }
            }
        }
    }
}
