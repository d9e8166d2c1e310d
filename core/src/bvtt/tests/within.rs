//! Queries within a distance against the test of every two triangles, which is itself tested against an oracle.

use super::{at_one_go, push, with_certificates};
use crate::bvh::tests::Owned;
use crate::bvtt::nearest::{Reach, certify};
use crate::bvtt::{PairBvtt, PosedBvh, Query, SelfBvtt, TrianglePair};
use crate::triangle::{Adjacency, intersects_in_mesh, within};
use crate::{Distance, Pose, Triangle};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::oracle;
use pfront_testkit::rng::{Rng, seeded};
use pfront_testkit::shapes::{bumpy, pose_rows, sheet, sphere, tangle};
use std::vec::Vec;

extern crate std;

const DISTANCES: [f32; 5] = [0.0, 1e-30, 0.01, 0.1, 0.7];

fn sorted(mut pairs: Vec<TrianglePair>) -> Vec<TrianglePair> {
    pairs.sort_unstable();
    pairs
}

/// The pairs of a query at one go, after steps of a few tests have found the same.
fn found(query: &impl Query) -> Vec<TrianglePair> {
    let whole = at_one_go(query);
    let (mut in_steps, mut cursor) = (Vec::new(), query.start());
    while !cursor.is_done() {
        let _ = query.step(&mut cursor, 7, |pair| push(&mut in_steps, pair));
    }
    assert_eq!((in_steps, cursor.work), whole);
    sorted(whole.0)
}

fn of_every_two(
    count: [usize; 2],
    mut is_hit: impl FnMut(TrianglePair) -> bool,
) -> Vec<TrianglePair> {
    let [a, b] = count.map(|count| count as u32);
    let pairs = (0..a).flat_map(|a| (0..b).map(move |b| TrianglePair { a, b }));
    pairs.filter(|pair| is_hit(*pair)).collect()
}

fn flat(n: u32) -> MeshData {
    sheet(n, |x, y| 0.3 * x * y)
}

fn posed(rng: &mut impl Rng, spread: f32, scale: f32) -> Pose {
    let rows = pose_rows(spread, rng);
    Pose::new(rows.map(|[x, y, z, t]| [x * scale, y * scale, z * scale, t]))
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn pairs_within_a_distance_are_those_of_every_two() {
    let mut rng = seeded(45);
    let shapes: [MeshData; 4] = [sphere(4), bumpy(4), flat(4), tangle(30, 30, 2, &mut rng)];
    let mut hits = 0;
    for round in 0..9 {
        let [a, b] = [0, 1].map(|k| {
            let shape = shapes[(round * (k + 1) + k) % shapes.len()].clone();
            Owned::new(shape, [1, 3, 8][(round + k) % 3], round % 2 == 0)
        });
        let scale = [1.0, 1.0, 2.5, 0.3][round % 4];
        let [of_a, of_b] = [posed(&mut rng, 0.5, scale), posed(&mut rng, 1.5, 1.0)];
        for distance in DISTANCES {
            let in_world = PairBvtt::in_world(
                PosedBvh::new(a.bvh(), &of_a).unwrap(),
                PosedBvh::new(b.bvh(), &of_b).unwrap(),
            );
            let in_first = PairBvtt::new(a.bvh(), b.bvh(), of_b).unwrap();
            for (query, of_a) in [(in_world, of_a), (in_first, Pose::IDENTITY)] {
                let corners = |own: &Owned, pose: &Pose, triangle: u32| -> Triangle {
                    own.bvh().mesh().shadow_triangle(triangle).map(|p| pose.apply(p))
                };
                let truth = of_every_two([a.triangles.len(), b.triangles.len()], |pair| {
                    within(&corners(&a, &of_a, pair.a), &corners(&b, &of_b, pair.b), distance)
                });
                assert_eq!(
                    found(&query.within(Distance::new(distance).unwrap())),
                    truth,
                    "{round} {distance}"
                );
                hits += truth.len();
            }
        }
    }
    assert!(hits > 3_000, "{hits}");
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn a_mesh_is_near_itself_where_no_vertex_is_shared() {
    let mut rng = seeded(46);
    for round in 0..6 {
        let shape = match round % 3 {
            0 => tangle(30, 30, 2, &mut rng),
            1 => bumpy(5),
            _ => flat(5),
        };
        let own = Owned::new(shape, [1, 8][round % 2], round % 2 == 0);
        let (mesh, count) = (own.bvh().mesh(), own.triangles.len());
        for adjacency in [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours] {
            for distance in DISTANCES {
                let truth = of_every_two([count; 2], |pair| {
                    let [a, b] = [pair.a, pair.b].map(|t| own.triangles[t as usize]);
                    let corners = |triangle| mesh.shadow_triangle(triangle);
                    pair.a < pair.b
                        && if a.iter().any(|vertex| b.contains(vertex)) {
                            intersects_in_mesh(mesh, pair.a, pair.b, adjacency)
                        } else {
                            within(&corners(pair.a), &corners(pair.b), distance)
                        }
                });
                let query = SelfBvtt::new(own.bvh()).with_adjacency(adjacency);
                let query = query.within(Distance::new(distance).unwrap());
                assert_eq!(found(&query), truth, "{round} {distance}");
                with_certificates(mesh, |certified| {
                    assert_eq!(found(&query.with_certificates(certified)), truth, "{round}");
                });
            }
        }
    }
}

/// Lanes are never wrong, and leave little open.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn lanes_certify_the_truth() {
    let mut rng = seeded(47);
    let mut answers = [0; 3];
    for family in Family::ALL {
        for _ in 0..40 {
            let (a, b) = family.pair(&mut rng);
            let extent = a.iter().chain(&b).flatten().fold(0.0, |m: f32, x| m.max(x.abs()));
            let exponent = (extent.to_bits() >> 23).clamp(27, 227);
            let scale = f32::from_bits((254 - exponent) << 23);
            for distance in [0.0, 1e-6, 1e-3, 0.1, 1.0].map(|d| d * extent) {
                let reach = Reach { scale, distance: distance * scale, error: 0.0 };
                let [is_within, is_beyond] = certify::<f32>(a, b, &reach);
                let truth = oracle::within(&a, &b, distance);
                assert!(is_within == 0 || truth, "{family:?} {a:?} {b:?} {distance:e}");
                assert!(is_beyond == 0 || !truth, "{family:?} {a:?} {b:?} {distance:e}");
                answers[if is_within != 0 {
                    0
                } else if is_beyond != 0 {
                    1
                } else {
                    2
                }] += 1;
            }
        }
    }
    assert!(answers[0] > 500 && answers[1] > 500, "{answers:?}");
}

#[test]
fn distances_from_none_to_the_largest() {
    let own = Owned::new(flat(2), 2, true);
    let at = |z: f32| {
        PairBvtt::new(own.bvh(), own.bvh(), Pose::from_translation([0.0, 0.0, z])).unwrap()
    };
    let count = |z: f32, distance: f32| at(z).within(Distance::new(distance).unwrap()).count();
    assert_eq!(count(1e30, f32::MAX), 64);
    assert_eq!([count(9.0, 1.0), count(9.0, 11.0)], [0, 64]);
    assert_eq!(SelfBvtt::new(own.bvh()).within(Distance::new(1e-3).unwrap()).count(), 0);
}

#[test]
fn the_last_distance_counts() {
    let own = Owned::new(flat(2), 2, true);
    let [none, some] = [0.0, 1.0].map(|d| Distance::new(d).unwrap());
    let above = Pose::from_translation([0.0, 0.0, 0.5]);
    let pair = PairBvtt::new(own.bvh(), own.bvh(), above).unwrap();
    let (intersecting, near) = (found(&pair), found(&pair.within(some)));
    assert!(intersecting.len() < near.len());
    assert_eq!(found(&pair.within(some).within(none)), intersecting);
    assert_eq!(found(&pair.within(none).within(some)), near);
    let itself = SelfBvtt::new(own.bvh());
    assert_eq!(found(&itself.within(some).within(none)), found(&itself));
}
