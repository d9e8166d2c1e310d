//! The triangle tests in f64 against the oracle, which is in integers of any length, and queries about two triangles with
//! them: what lanes and shadows decide is no other than what the positions say.
//!
//! `PFRONT_ROUNDS` sets how many pairs of each family are asked about in each way.

use pfront::{Accuracy, Adjacency, Bvh, Mesh, Node, Pose64};
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use pfront_core::triangle::{intersects_f64, intersects_in_mesh};
use pfront_testkit::families::Family;
use pfront_testkit::oracle::{intersect, self_hit, share_a_vertex};
use pfront_testkit::rng::{Rng, RngExt, seeded};

type Point = [f64; 3];

/// The largest coordinate.
const LIMIT: f64 = 4.253529586511731e37;

/// What is made of the coordinates of a family in f32.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Nothing.
    Widen,
    /// Each is off by up to two steps of f64.
    Noise,
    /// Each axis has a scale of its own, a power of two, so that one may be subnormal beside another.
    Scale,
    /// All are moved far away, where they lose digits.
    Move,
    /// Each is replaced by any number, the same for the same.
    Replace,
}

impl Change {
    const ALL: [Self; 5] = [Self::Widen, Self::Noise, Self::Scale, Self::Move, Self::Replace];

    fn make(self, points: [[f32; 3]; 6], rng: &mut impl Rng) -> Option<[Point; 6]> {
        let wide = points.map(|p| p.map(f64::from));
        let scales = [0; 3].map(|_| 2_f64.powi(rng.random_range(-1000..=90)));
        let offset = [0; 3].map(|_| 1e7 * rng.random_range(-1.0..1.0));
        let salt: u64 = rng.random();
        let mut noise =
            |x: f64| f64::from_bits(x.to_bits().wrapping_add_signed(rng.random_range(-2..=2)));
        let made = wide.map(|p| {
            [0, 1, 2].map(|k| match self {
                Self::Widen => p[k],
                Self::Noise if p[k] == 0.0 => p[k],
                Self::Noise => noise(p[k]),
                Self::Scale => p[k] * scales[k],
                Self::Move => p[k] + offset[k],
                Self::Replace => {
                    let bits = (p[k].to_bits() ^ salt).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                    f64::from_bits(bits ^ (bits >> 29))
                }
            })
        });
        made.as_flattened().iter().all(|x| x.abs() <= LIMIT).then_some(made)
    }
}

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
        for change in Change::ALL {
            for _ in 0..rounds() {
                let (a, b) = family.pair(&mut rng);
                let points = [a[0], a[1], a[2], b[0], b[1], b[2]];
                let Some([p, q, r, u, v, w]) = change.make(points, &mut rng) else { continue };
                let (a, b) = ([p, q, r], [u, v, w]);
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
                let leaves = mesh.map(|mesh| leaf(mesh.positions(), 1));
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
        for change in Change::ALL {
            for _ in 0..rounds() / 4 {
                let (points, a, b) = family.indexed(&mut rng);
                let Some(points) = change.make(points, &mut rng) else { continue };
                let truth = self_hit(a, b, &points);
                let (mut shadow, triangles) = ([[0.0; 3]; 6], [a, b]);
                let mesh = Mesh::from_f64(&points, &triangles, &mut shadow).unwrap();
                let what = || format!("{family:?} {change:?} {points:?} {triangles:?}");
                let leaf = leaf(mesh.positions(), 2);
                let bvh = Bvh::new_unchecked(mesh, &leaf, &[0, 1]);
                for (adjacency, truth) in [
                    (Adjacency::SharedIndexRule, truth),
                    (Adjacency::SkipNeighbours, truth && !share_a_vertex(a, b)),
                ] {
                    seen[usize::from(truth)] += 1;
                    for (i, j) in [(0, 1), (1, 0)] {
                        let hit = intersects_in_mesh(mesh, i, j, adjacency, Accuracy::Exact);
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
