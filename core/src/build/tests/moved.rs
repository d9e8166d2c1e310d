//! Tests of refits that look only at what has moved.

use super::*;
use crate::build::moved::{holds, holds_any, vertices};
use crate::fans::{Fan, certify, certify_moved, link, link_scratch_bound};

fn bits<T: bytemuck::NoUninit>(values: &[T]) -> &[u32] {
    bytemuck::cast_slice(values)
}

/// The positions after some vertices have moved: none, one, a run of them, every fifth, all.
fn moves(positions: &[[f32; 3]], random: &mut Random) -> Vec<Vec<[f32; 3]>> {
    let n = positions.len();
    let start = (random.unit() * n as f32) as usize;
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
            let moved = |i| if chosen(i) { random.point(9.0) } else { positions[i] };
            (0..n).map(moved).collect()
        })
        .collect()
}

#[test]
fn what_has_moved_is_all_that_a_refit_needs() {
    let joins = joins();
    for (name, (positions, triangles)) in meshes() {
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let mut random = Random(13);
        let mut fans = vec![Fan::default(); positions.len()];
        let need = link_scratch_bound(positions.len(), triangles.len());
        link(mesh, &mut vec![0; need], &mut fans).unwrap();
        certify(mesh, &mut fans).unwrap();
        with_builds(mesh, 2, |build, bvh| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let (mut whole, mut fans) = (nodes.clone(), fans.clone());
            let mut all_fans = fans.clone();
            let mut table = vec![Below::default(); survey_bound(nodes.len())];
            let mut fresh = table.clone();
            let mut marks = vec![Moved::default(); moved_bound(positions.len())];
            let mut scratch = marks.clone();
            survey(mesh, &mut nodes, order, &mut table, joins[0]).unwrap();
            let mut before = positions.clone();
            for (way, after) in moves(&positions, &mut random).into_iter().enumerate() {
                let context = format!("{build} of {name}, way {way}");
                marks.fill(Moved::default());
                mark_moved(&before, &after, &mut marks).unwrap();
                let moved = mesh.with_positions(&after).unwrap();
                // The third of the joins does only half.
                let join = joins[way % 2 * 3];
                let found = refit_moved(moved, &mut nodes, order, &marks, &mut table, join);
                let (found, expected) = (found.unwrap(), refit(moved, &mut whole, order));
                assert_eq!(bits(&nodes), bits(&whole), "{context}");
                assert!((found - expected).abs() <= 1e-6 * expected, "{context}: {found}");
                // Nothing drifts.
                let surveyed = survey(moved, &mut whole, order, &mut fresh, join).unwrap();
                assert!(found == surveyed && table == fresh, "{context}");
                let tree = Bvh::trusted(moved, &nodes, order);
                certify_moved(&tree, &table, &marks, &mut scratch, &mut fans).unwrap();
                certify(moved, &mut all_fans).unwrap();
                assert_eq!(fans, all_fans, "{context}");
                before = after;
            }
        });
    }
}

#[test]
fn a_set_knows_what_it_holds() {
    let mut random = Random(17);
    for (vertices_in_all, share) in [(1, 0.5), (31, 0.1), (32, 0.1), (33, 0.0), (400, 0.01)] {
        let before = vec![[0.0; 3]; vertices_in_all];
        let after = before.iter().map(|p| if random.unit() < share { [1.0; 3] } else { *p });
        let after: Vec<_> = after.collect();
        let mut set = vec![Moved::default(); moved_bound(vertices_in_all)];
        mark_moved(&before, &after, &mut set).unwrap();
        let held: Vec<_> = (0..vertices_in_all).filter(|&i| after[i] != before[i]).collect();
        assert_eq!(vertices(&set).collect::<Vec<_>>(), held);
        for first in 0..vertices_in_all as u32 {
            assert_eq!(holds(&set, first), held.contains(&(first as usize)));
            for last in (first..vertices_in_all as u32).step_by(if cfg!(miri) { 29 } else { 1 }) {
                let any = held.iter().any(|&i| (first..=last).contains(&(i as u32)));
                assert_eq!(holds_any(&set, [first, last]), any, "{first} to {last}");
            }
        }
    }
}

#[test]
fn a_table_or_a_set_one_short_is_an_error_that_names_the_need() {
    let (positions, triangles) = grid(8);
    let mesh = Mesh::new(&positions, &triangles).unwrap();
    with_builds(mesh, 1, |_, bvh| {
        let run = |rows: usize, words: usize, scratch: usize, fans: usize| {
            let (mut nodes, order) = (bvh.nodes().to_vec(), bvh.order());
            let (table, moved) =
                (&mut *vec![Below::default(); rows], vec![Moved::default(); words]);
            let made = survey(mesh, &mut nodes, order, table, joins()[0]).err();
            let refitted = refit_moved(mesh, &mut nodes, order, &moved, table, joins()[0]).err();
            let scratch = &mut *vec![Moved::default(); scratch];
            let fans = &mut *vec![Fan::default(); fans];
            let certified = certify_moved(&bvh, table, &moved, scratch, fans).err();
            [made, refitted, certified].map(|e| e.map(|e| (e.buffer, e.needed, e.capacity)))
        };
        let (rows, words) = (bvh.nodes().len() / 2 - 1, 3);
        assert_eq!(run(rows, words, words, 81), [None; 3]);
        let table = Some(("table", rows, rows - 1));
        assert_eq!(run(rows - 1, words, words, 81), [table; 3]);
        let moved = Some(("moved", words, words - 1));
        assert_eq!(run(rows, words - 1, words, 81), [None, moved, moved]);
        let scratch = Some(("scratch", words, words - 1));
        assert_eq!(run(rows, words, words - 1, 81), [None, None, scratch]);
        assert_eq!(run(rows, words, words, 80), [None, None, Some(("fans", 81, 80))]);
    });
    let short = mark_moved(&positions, &positions, &mut [Moved::default(); 2]).err();
    assert_eq!(short.map(|e| e.needed), Some(3));
}
