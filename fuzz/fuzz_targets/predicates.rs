//! Six points of any finite bit pattern, as two triangles and as two triangles of one mesh, against the
//! oracle, in two orders.
//!
//! Coordinates are picked from a short list in the input, since independent ones never coincide.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use pfront::pfront_core::triangle::{contact, intersects, intersects_in_mesh};
use pfront::{Adjacency, Mesh};
use pfront_testkit::oracle::{intersect, self_hit, share_a_vertex};

#[derive(Arbitrary, Debug)]
struct Input {
    values: [u32; 18],
    /// The number of the value that each coordinate takes.
    picks: [u8; 18],
    triangles: [[u8; 3]; 2],
}

fuzz_target!(|input: Input| {
    let value = |pick: u8| f32::from_bits(input.values[pick as usize % 18]);
    let points: [[f32; 3]; 6] =
        std::array::from_fn(|i| std::array::from_fn(|k| value(input.picks[3 * i + k])));
    if points.iter().flatten().all(|x| x.is_finite()) {
        let [p, q, r, s, t, u] = points;
        closed(&[p, q, r], &[s, t, u]);
        within(&points, input.triangles.map(|t| t.map(|v| u32::from(v % 6))));
    }
});

fn closed(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) {
    let truth = intersect(a, b);
    let turned = [a[2], a[0], a[1]];
    for (a, b) in [(a, b), (b, a), (&turned, b), (b, &turned)] {
        assert_eq!(intersects(a, b), truth, "{a:?} {b:?}");
        let found = contact(a, b);
        assert_eq!(found.is_some(), truth, "{a:?} {b:?}");
        for x in found.iter().flat_map(|c| c.segment.iter().chain(&c.normals)).flatten() {
            assert!(x.is_finite(), "{found:?} of {a:?} {b:?}");
        }
    }
}

fn within(points: &[[f32; 3]], triangles: [[u32; 3]; 2]) {
    let [a, b] = triangles;
    let truth = self_hit(a, b, points);
    let mesh = Mesh::new(points, &triangles).unwrap();
    for (i, j) in [(0, 1), (1, 0)] {
        for (adjacency, truth) in [
            (Adjacency::SharedIndexRule, truth),
            (Adjacency::SkipNeighbours, truth && !share_a_vertex(a, b)),
        ] {
            let hit = intersects_in_mesh(mesh, i, j, adjacency);
            assert_eq!(hit, truth, "{triangles:?} of {points:?}");
        }
    }
}
