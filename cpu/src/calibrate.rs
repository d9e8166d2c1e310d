//! The k of |n| = m1 + k·m2, measured.

use pfront_core::bvh::node_bound;
use pfront_core::bvh::{self, BuildOptions, BvhStorage};
use pfront_core::bvtt::{Cursor, PairQuery, Query, Work};
use pfront_core::{Mesh, Node, Pose};
use std::ops::ControlFlow;
use std::time::Instant;

/// What a triangle test costs in box tests, unless [`Settings`](crate::Settings) say otherwise; as
/// [`calibrate`] found it on x86-64 (an Intel Xeon: 6.2 to 7.1 in twelve runs).
pub const TRIANGLE_COST: f32 = 6.5;

/// Cells along a side of the test sheet: two triangles each.
const SIDE: usize = 48;
const RUNS: usize = 5;

/// Measures what a triangle test costs in box tests on this machine, in about 10 ms: for
/// [`Settings::triangle_cost`](crate::Settings::triangle_cost), which says when that is worth while. No
/// two runs give quite the same.
///
/// It walks two small sheets, once close together, which is mostly box tests, and once through each other,
/// and solves for the time of either test. [`TRIANGLE_COST`] where the clock is too coarse for that.
#[must_use]
pub fn calibrate() -> f32 {
    measure().filter(|k| (0.25..64.0).contains(k)).unwrap_or(TRIANGLE_COST)
}

fn measure() -> Option<f32> {
    let at = |i: usize| i as f32 / SIDE as f32;
    let wave = |x: f32, y: f32| 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
    let grid = (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (at(i), at(j))));
    let positions: Vec<_> = grid.map(|(x, y)| [x, y, wave(x, y)]).collect();
    let corner = |i: usize, j: usize| (j * (SIDE + 1) + i) as u32;
    let cells = (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j)));
    let triangles: Vec<_> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| corner(i + x, j + y));
            [[a, b, c], [b, d, c]]
        })
        .collect();
    let n = triangles.len();
    let mesh = Mesh::new(&positions, &triangles).ok()?;
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let mut scratch = vec![0; bvh::morton_scratch_bound(n)];
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let bvh = bvh::morton(mesh, &BuildOptions::default(), storage, &mut scratch).ok()?;
    let walk = |pose| Some(best_of(&PairQuery::new(bvh, bvh, pose).ok()?));
    let (time1, work1) = walk(Pose::from_translation([0.003, 0.004, 0.03]))?;
    let (time2, work2) = walk(Pose::from_translation([0.003, 0.004, 0.001]))?;
    let [a, b] = [work1, work2].map(|w| (w.box_tests as f64, w.triangle_tests as f64));
    // time = x·boxes + y·triangles, twice.
    let x = time1 * b.1 - time2 * a.1;
    let y = a.0 * time2 - b.0 * time1;
    Some((y / x) as f32)
}

/// The shortest of some walks in seconds, and what each does.
fn best_of(query: &PairQuery<'_>) -> (f64, Work) {
    let mut best = (f64::INFINITY, Work::default());
    for _ in 0..RUNS {
        let clock = Instant::now();
        let mut cursor: Cursor = query.start();
        // Never broken off.
        let _ = query.visit(&mut cursor, |_| ControlFlow::Continue(()));
        best = (best.0.min(clock.elapsed().as_secs_f64()), cursor.work());
    }
    best
}
