//! Tests of refits that look only at what has moved.

use super::*;
use crate::bvh::*;
use crate::vertex_set::holds_any;

fn filling(table: &mut [RefitRow]) -> Refit<'_> {
    Refit { table, ..Refit::default() }
}

fn bits<T: bytemuck::NoUninit>(values: &[T]) -> &[u32] {
    bytemuck::cast_slice(values)
}

/// The positions after some vertices have moved: none, one, a run of them, every fifth, all.
fn moves(positions: &[[f32; 3]], rng: &mut ChaCha8Rng) -> Vec<Vec<[f32; 3]>> {
    let n = positions.len();
    let start = rng.random_range(0..n.max(1));
    let chosen: [&dyn Fn(usize) -> bool; 5] = [
        &|_| false,
        &|i| i == start,
        &|i| (start..start + n / 8 + 1).contains(&i),
        &|i| i % 5 == start % 5,
        &|_| true,
    ];
    chosen
        .iter()
        .map(|chosen| {
            let moved = |i| if chosen(i) { point(9.0, rng) } else { positions[i] };
            (0..n).map(moved).collect()
        })
        .collect()
}

#[test]
fn what_has_moved_is_all_that_a_refit_needs() {
    let joins = joins();
    for (name, MeshData { positions, triangles }) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let mut rng = seeded(13);
        with_builds(mesh, 2, |build, bvh| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let mut whole = nodes.clone();
            let mut table = vec![RefitRow::default(); nodes.len() / 2];
            let mut fresh = table.clone();
            let mut marks = vec![Moved::default(); positions.len().div_ceil(32)];
            refit(mesh, &mut nodes, order, filling(&mut table)).unwrap();
            let mut before = positions.clone();
            for (way, after) in moves(&positions, &mut rng).into_iter().enumerate() {
                let context = format!("{build} of {name}, way {way}");
                marks.fill(Moved::default());
                mark_moved(&before, &after, &mut marks).unwrap();
                let moved = mesh.with_positions(&after).unwrap();
                // The third of the joins does only half.
                let join = joins[way % 2 * 3];
                let options = Refit { join: Some(join), table: &mut table, moved: Some(&marks) };
                let found = refit(moved, &mut nodes, order, options).unwrap();
                let expected = refit(moved, &mut whole, order, Refit::default()).unwrap();
                assert_eq!(bits(&nodes), bits(&whole), "{context}");
                assert_eq!(found, expected, "{context}");
                // Nothing drifts.
                refit(moved, &mut whole, order, filling(&mut fresh)).unwrap();
                assert_eq!(table, fresh, "{context}");
                before = after;
            }
        });
    }
}

#[test]
fn a_set_knows_what_it_holds() {
    let mut rng = seeded(17);
    for (vertices_in_all, share) in [(1, 0.5), (31, 0.1), (32, 0.1), (33, 0.0), (400, 0.01)] {
        let before = vec![[0.0; 3]; vertices_in_all];
        let after = before.iter().map(|p| if rng.random_bool(share) { [1.0; 3] } else { *p });
        let after: Vec<_> = after.collect();
        let mut set = vec![Moved::default(); vertices_in_all.div_ceil(32)];
        mark_moved(&before, &after, &mut set).unwrap();
        let held: Vec<_> = (0..vertices_in_all).filter(|&i| after[i] != before[i]).collect();
        for first in 0..vertices_in_all as u32 {
            for last in first..vertices_in_all as u32 {
                let any = held.iter().any(|&i| (first..=last).contains(&(i as u32)));
                assert_eq!(holds_any(&set, [first, last]), any, "{first} to {last}");
            }
        }
    }
}

#[test]
fn a_table_or_a_set_one_short_is_an_error_that_names_the_need() {
    let MeshData { positions, triangles } = sheet(8, |_, _| 0.0);
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    let short = |error: CapacityError| (error.buffer, error.needed, error.capacity);
    with_builds(mesh, 1, |_, bvh| {
        let run = |rows: usize, words: usize| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let (table, moved) =
                (&mut *vec![RefitRow::default(); rows], vec![Moved::default(); words]);
            let made = Refit { table: &mut *table, ..Refit::default() };
            let made = refit(mesh, &mut nodes, order, made).err();
            let refitted = Refit { table, moved: Some(&moved), join: None };
            let refitted = refit(mesh, &mut nodes, order, refitted).err();
            [made, refitted].map(|error| error.map(short))
        };
        assert_eq!(run(128, 3), [None; 2]);
        assert_eq!(run(127, 3), [Some(("table", 128, 127)); 2]);
        assert_eq!(run(128, 2), [None, Some(("moved", 3, 2))]);
    });
    let marked = mark_moved(&positions, &positions, &mut [Moved::default(); 2]).err();
    assert_eq!(marked.map(short), Some(("moved", 3, 2)));
}
