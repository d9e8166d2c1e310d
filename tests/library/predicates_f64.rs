//! The triangle tests in f64 against the oracle, which is in integers of any length, and queries about two triangles with
//! them: what lanes and shadows decide is no other than what the positions say.
//!
//! `PFRONT_ROUNDS` sets how many pairs of each family are asked about in each way.

use pfront::{Adjacency, Bvh, Mesh, Node, Pose64};
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use pfront_core::triangle::{intersects_f64, intersects_in_mesh};
use pfront_testkit::families::{Family, InF64};
use pfront_testkit::oracle::{intersect, self_hit, share_a_vertex};
use pfront_testkit::rng::seeded;

fn rounds() -> usize {
    let asked = std::env::var("PFRONT_ROUNDS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(400)
}

/// One leaf around all of a shadow.
fn leaf(shadow: &[[f32; 3]], count: u32) -> [Node; 1] {
    let pfront::Aabb { min, max } = pfront::Aabb::of(shadow);
    [Node { min, max, first: 0, count }]
}

#[test]
fn two_triangles() {
    let (mut rng, mut seen) = (seeded(72), [0_u64; 2]);
    for family in Family::ALL {
        for change in InF64::ALL {
            for _ in 0..rounds() {
                let Some((a, b)) = change.pair(family, &mut rng) else { continue };
                let [u, v, w] = b;
                let truth = intersect(&a, &b);
                seen[usize::from(truth)] += 1;
                let what = || format!("{family:?} {change:?} {a:?} {b:?}");
                assert_eq!(intersects_f64(&a, &b), Ok(truth), "{}", what());
                assert_eq!(intersects_f64(&[v, w, u], &a), Ok(truth), "{}", what());
                let mut shadows = [[[0.0; 3]; 3]; 2];
                let [s, t] = &mut shadows;
                let mesh = [
                    Mesh::from_f64(&a, &[[0, 1, 2]], s).unwrap(),
                    Mesh::from_f64(&b, &[[0, 1, 2]], t).unwrap(),
                ];
                let leaves = mesh.map(|mesh| leaf(mesh.shadow(), 1));
                let [s, t] = [0, 1].map(|i| Bvh::new_unchecked(mesh[i], &leaves[i], &[0]));
                let query = PairBvtt::in_f64(s, t, &Pose64::IDENTITY).unwrap();
                assert_eq!(query.count(), u64::from(truth), "{}", what());
                let contact = query.contact_f64(pfront::TrianglePair { a: 0, b: 0 });
                assert_eq!(contact.is_some(), truth, "{}", what());
                let numbers = contact.iter().flat_map(|c| c.segment).flatten();
                assert!(numbers.into_iter().all(f64::is_finite), "{}", what());
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 10 * rounds() as u64), "{seen:?}");
    println!("{seen:?} apart and not");
}

#[test]
fn two_triangles_of_one_mesh() {
    let (mut rng, mut seen) = (seeded(73), [0_u64; 2]);
    for family in Family::ALL {
        for change in InF64::ALL {
            for _ in 0..rounds() / 4 {
                let (points, a, b) = family.indexed(&mut rng);
                let Some(points) = change.points(points, &mut rng) else { continue };
                let truth = self_hit(a, b, &points);
                let (mut shadow, triangles) = ([[0.0; 3]; 6], [a, b]);
                let mesh = Mesh::from_f64(&points, &triangles, &mut shadow).unwrap();
                let what = || format!("{family:?} {change:?} {points:?} {triangles:?}");
                let leaf = leaf(mesh.shadow(), 2);
                let bvh = Bvh::new_unchecked(mesh, &leaf, &[0, 1]);
                for (adjacency, truth) in [
                    (Adjacency::SharedIndexRule, truth),
                    (Adjacency::SkipNeighbours, truth && !share_a_vertex(a, b)),
                ] {
                    seen[usize::from(truth)] += 1;
                    for (i, j) in [(0, 1), (1, 0)] {
                        let hit = intersects_in_mesh(mesh, i, j, adjacency);
                        assert_eq!(hit, truth, "{}", what());
                    }
                    let query = SelfBvtt::new(bvh).with_adjacency(adjacency);
                    assert_eq!(query.count(), u64::from(truth), "{}", what());
                }
            }
        }
    }
    assert!(seen.iter().all(|&count| count > rounds() as u64), "{seen:?}");
    println!("{seen:?} apart and not");
}
