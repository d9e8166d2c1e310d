//! Builds in parts, in memory that just suffices.

use super::*;
use crate::bvh::*;

#[test]
fn parts_give_the_tree_of_the_whole() {
    for (name, (positions, triangles)) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let count = triangles.len();
        // Miri takes seconds for each.
        let (some, ways) = if cfg!(miri) { (5, 3) } else { (1, 0) };
        for options in options([1, 3, 8]).into_iter().step_by(some) {
            with_options(mesh, options, |build, whole| {
                for (way, join) in joins().into_iter().enumerate().skip(ways) {
                    let mut nodes = vec![Node::EMPTY; node_bound(count)];
                    let mut order = vec![0; count];
                    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                    let in_parts = if build == "sah" {
                        let mut items = vec![SahItem::default(); sah_scratch_bound(count)];
                        sah_with(mesh, &options, storage, &mut items, join).unwrap()
                    } else {
                        let mut keys = vec![7; morton_scratch_bound(count)];
                        morton_with(mesh, &options, storage, &mut keys, join).unwrap()
                    };
                    let context = format!("{build} of {name}, way {way}, {options:?}");
                    let bits = |bvh: Bvh<'_>| bytemuck::cast_slice::<_, u32>(bvh.nodes()).to_vec();
                    assert_eq!(bits(in_parts), bits(whole), "{context}");
                    assert_eq!(in_parts.order(), whole.order(), "{context}");
                }
            });
        }
    }
}

#[test]
fn keys_are_sorted_by_any_bits() {
    let mut random = Random(11);
    let mut key = |bits: u32| {
        (0..3).fold(0, |k, _| k << 22 ^ u64::from(random.unit().to_bits())) & !0 >> (64 - bits)
    };
    for (count, width) in [(0, 9), (1, 64), (25, 40), (60, 33), (900, 1), (900, 33), (900, 64)] {
        // Miri takes seconds a digit.
        for range in
            [0..64, 31..64, 20..41, 63..64, 5..5].into_iter().skip(if cfg!(miri) { 3 } else { 0 })
        {
            let mut keys: Vec<u64> = (0..few(count)).map(|_| key(width)).collect();
            let mut sorted = keys.clone();
            let picked = |key: &u64| key >> range.start & ((1_u128 << range.len()) - 1) as u64;
            sorted.sort_by_key(picked);
            // Bits above the range are the same for all keys.
            let above = !0_u64.unbounded_shl(range.end);
            keys.iter_mut().chain(&mut sorted).for_each(|key| *key &= above);
            let mut spare = vec![0; keys.len()];
            radix::sort(&mut keys, &mut spare, range.clone(), parts::Parts::new(None));
            assert_eq!(keys, sorted, "{count} keys of {width} bits by {range:?}");
        }
    }
}

#[test]
fn morton_needs_no_more_nodes_than_there_are_and_says_how_many() {
    for (name, (positions, triangles)) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let count = triangles.len();
        // Miri is slow, and slower to make threads.
        let some = if cfg!(miri) { 1 } else { usize::MAX };
        for options in options([8, 3, 1]).into_iter().take(some) {
            let context = format!("{name} with {options:?}");
            let mut roomy = vec![];
            with_options(mesh, options, |_, bvh| roomy = bvh.nodes().to_vec());
            let in_nodes = |nodes: usize, join: Option<&Join<'_>>| {
                let (mut nodes, mut order) = (vec![Node::EMPTY; nodes], vec![0; count]);
                let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                let mut scratch = vec![0; 2 * count];
                match join {
                    Some(join) => morton_with(mesh, &options, storage, &mut scratch, join),
                    None => morton(mesh, &options, storage, &mut scratch),
                }
                .map(|bvh| bvh.nodes().to_vec())
            };
            for join in [None].into_iter().chain(joins().map(Some).into_iter().take(some)) {
                assert_eq!(in_nodes(roomy.len(), join).as_ref(), Ok(&roomy), "{context}");
            }
            if let Some(short) = roomy.len().checked_sub(1) {
                let error = in_nodes(short, None).unwrap_err();
                assert_eq!((error.buffer, error.needed), ("nodes", roomy.len()), "{context}");
            }
        }
    }
}
