//! The triangle tests of the core against the exact oracle, on 400,000 hard pairs a run, and 1.4 million nightly.
//!
//! Neither swapping the triangles nor permuting corners may change an answer.

use pfront::{Adjacency, Mesh};
use pfront_core::triangle::{contact, intersects, intersects_in_mesh};
use pfront_testkit::Point;
use pfront_testkit::oracle::{intersect, self_hit, share_a_vertex};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::{Triangle, families::Family};
use proptest::prelude::*;

/// Closed triangles of each family, and two fifths as many of one mesh; `PFRONT_ROUNDS` says how many.
fn rounds() -> u32 {
    std::env::var("PFRONT_ROUNDS").map_or(10_000, |rounds| rounds.parse().unwrap())
}

/// One test a family, so that they run in parallel and a failure names its family.
macro_rules! families {
    ($($name:ident: $family:ident,)*) => {
        $(#[test]
        fn $name() {
            closed_triangles(Family::$family);
            triangles_of_one_mesh(Family::$family);
        })*

        #[test]
        fn every_family_has_a_test() {
            assert_eq!([$(Family::$family),*], Family::ALL);
        }
    };
}

families! {
    random: Random,
    mesh_like: MeshLike,
    vertex_face_gap_3: VertexFaceGap3,
    vertex_face_gap_5: VertexFaceGap5,
    vertex_face_gap_7: VertexFaceGap7,
    vertex_face_gap_8: VertexFaceGap8,
    vertex_face_gap_9: VertexFaceGap9,
    edge_edge_gap: EdgeEdgeGap,
    edge_edge_gap_3: EdgeEdgeGap3,
    edge_edge_gap_5: EdgeEdgeGap5,
    edge_edge_gap_7: EdgeEdgeGap7,
    edge_edge_gap_8: EdgeEdgeGap8,
    edge_edge_gap_9: EdgeEdgeGap9,
    coplanar_axis: CoplanarAxis,
    coplanar_rotated: CoplanarRotated,
    shared_vertex: SharedVertex,
    shared_edge: SharedEdge,
    t_junction: TJunction,
    edge_through_vertex: EdgeThroughVertex,
    sliver: Sliver,
    degenerate: Degenerate,
    offset: Offset,
    scaled: Scaled,
    mixed_scale: MixedScale,
    huge: Huge,
    subnormal: Subnormal,
    lattice: Lattice,
    duplicate: Duplicate,
    raw_bits: RawBits,
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    /// Few different coordinates, of any bit pattern, make coincidences of every kind.
    #[test]
    fn any_coordinates_from_a_small_pool(
        pool in prop::collection::vec(finite(), 1..6),
        picks in prop::array::uniform18(any::<prop::sample::Index>()),
    ) {
        let x = picks.map(|i| *i.get(&pool));
        let corner = |i: usize| [x[i], x[i + 1], x[i + 2]];
        agree(&[corner(0), corner(3), corner(6)], &[corner(9), corner(12), corner(15)]);
    }

    /// A triangle against one that is a few f32 steps away from it.
    #[test]
    fn a_few_steps_apart(
        a in prop::array::uniform3(prop::array::uniform3(finite())),
        steps in prop::array::uniform3(prop::array::uniform3(-2i32..=2)),
    ) {
        let b = [0, 1, 2].map(|i| [0, 1, 2].map(|k| step(a[i][k], steps[i][k])));
        agree(&a, &b);
    }

    /// Any two triangles over four points of a small lattice.
    #[test]
    fn any_indices(
        points in prop::array::uniform4(prop::array::uniform3(-2i8..=2)),
        triangles in prop::array::uniform2(prop::array::uniform3(0u32..4)),
    ) {
        agree_within(&points.map(|p| p.map(f32::from)), triangles);
    }
}

fn finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
}

/// The f32 so many representable numbers away, as long as that is finite.
fn step(x: f32, steps: i32) -> f32 {
    let moved =
        (0..steps.abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() });
    if moved.is_finite() { moved } else { x }
}

fn closed_triangles(family: Family) {
    let mut rng = seeded(11);
    for i in 0..rounds() {
        let (a, b) = family.pair(&mut rng);
        if i % 64 == 0 {
            agree(&a, &b);
        } else {
            let order: [usize; 2] = [0; 2].map(|_| rng.random_range(0..6));
            agree_permuted(&a, &b, order, rng.random(), intersect(&a, &b));
        }
    }
}

/// All answers about a pair, in all 72 orders.
fn agree(a: &Triangle, b: &Triangle) {
    let truth = intersect(a, b);
    for i in 0..36 {
        for swap in [false, true] {
            agree_permuted(a, b, [i % 6, i / 6], swap, truth);
        }
    }
    agree_contact(a, b, truth);
}

fn agree_permuted(a: &Triangle, b: &Triangle, order: [usize; 2], swap: bool, truth: bool) {
    let [mut s, mut t] = [permuted(a, order[0]), permuted(b, order[1])];
    if swap {
        std::mem::swap(&mut s, &mut t);
    }
    assert_eq!(intersects(&s, &t), truth, "truth is {truth}: {s:?} {t:?}");
}

fn permuted<T: Copy>(t: &[T; 3], order: usize) -> [T; 3] {
    let [i, turn] = [order % 3, 1 + order / 3];
    [t[i], t[(i + turn) % 3], t[(i + 2 * turn) % 3]]
}

/// There is a contact exactly if the triangles meet, and it lies in the boxes of both.
fn agree_contact(a: &Triangle, b: &Triangle, truth: bool) {
    let found = contact(a, b);
    assert_eq!(found.is_some(), truth, "{a:?} {b:?}");
    for point in found.iter().flat_map(|c| c.segment) {
        for axis in 0..3 {
            let all = [a, b].map(|t| t.map(|p| f64::from(p[axis])));
            let (low, high) = all.iter().fold((f64::MIN, f64::MAX), |(low, high), t| {
                let [min, max] = [f64::min, f64::max].map(|f| t.iter().copied().reduce(f).unwrap());
                (low.max(min), high.min(max))
            });
            let size = all.iter().flatten().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
            let slack = size * 2f64.powi(-23);
            let x = f64::from(point[axis]);
            assert!(low - slack <= x && x <= high + slack, "{point:?} of {found:?} {a:?} {b:?}");
        }
    }
}

fn triangles_of_one_mesh(family: Family) {
    let mut rng = seeded(12);
    for _ in 0..rounds() * 2 / 5 {
        let (positions, ta, tb) = family.indexed(&mut rng);
        agree_within(&positions, [ta, tb]);
    }
}

/// All answers about two triangles of one mesh, in a few orders.
fn agree_within(positions: &[Point], [ta, tb]: [[u32; 3]; 2]) {
    let truth = self_hit(ta, tb, positions);
    let apart = truth && !share_a_vertex(ta, tb);
    for order in 0..6 {
        let triangles = [permuted(&ta, order), permuted(&tb, (order * 5 + 1) % 6)];
        let mesh = Mesh::new(positions, &triangles).unwrap();
        for (i, j) in [(0, 1), (1, 0)] {
            let answer = |adjacency| intersects_in_mesh(mesh, i, j, adjacency);
            let [rule, skip] = [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours];
            let message = || format!("truth is {truth}: {triangles:?} of {positions:?}");
            assert_eq!(answer(rule), truth, "{}", message());
            assert_eq!(answer(skip), apart, "{}", message());
        }
    }
}
