//! The smallest distance against every two triangles, visited in another order, and against exact decisions.

use crate::bvh::tests::Owned;
use crate::bvtt::{Gap, PairBvtt, PosedBvh, Query, TrianglePair};
use crate::{Distance, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::shapes::{bumpy, family, pose_rows, sheet, sphere, tangle};

extern crate std;

fn distance(d: f64) -> Distance {
    Distance::at_least(d).unwrap()
}

/// Checks the answer to a query, whose meshes have so many triangles, and returns it.
pub(super) fn check(query: &PairBvtt<'_>, [a, b]: [usize; 2], rng: &mut impl Rng) -> Gap {
    let gap = query.distance(None, None).expect("both have triangles");
    let [low, high] = gap.interval;
    let intersects = query.any().is_some();
    assert_eq!(intersects, high == 0.0, "{gap:?}");
    if intersects {
        assert!(low == 0.0 && query.intersects(gap.pair), "{gap:?}");
        assert_eq!(query.distance(Some(Distance::default()), None).unwrap().interval, [0.0; 2]);
        return gap;
    }
    // Every pair, the last first, and a few at random.
    let mut all = query.search(None, None);
    for of_a in (0..a as u32).rev() {
        for of_b in (0..b as u32).rev() {
            all.add(&query.search(None, Some(TrianglePair { a: of_a, b: of_b })));
        }
    }
    assert_eq!(all.gap(), Some(gap));
    let any = TrianglePair { a: rng.random_range(0..=a as u32), b: rng.random_range(0..b as u32) };
    for seed in [any, gap.pair] {
        assert_eq!(query.distance(None, Some(seed)), Some(gap), "{seed:?}");
    }
    // In steps, by two workers.
    let (mut search, mut done) = (query.search(None, None), query.search(None, None));
    while !search.is_done() {
        query.seek(&mut search, 5);
        if let Some(mut half) = search.take_half() {
            half.tighten(search.reach());
            query.seek(&mut half, u64::MAX);
            assert!(half.is_done() && half.take_half().is_none());
            done.add(&half);
            search.tighten(half.reach());
        }
    }
    search.add(&done);
    assert_eq!(search.gap(), Some(gap));
    // Exactly, nothing is within the lower end, and something within the upper.
    assert!(low > 0.0 || query.any().is_none());
    assert_eq!(query.within(distance(low)).any(), None, "{gap:?}");
    assert!(query.within(distance(high)).any().is_some(), "{gap:?}");
    if low > 0.0 {
        assert_eq!(query.distance(Some(distance(low)), Some(gap.pair)), None);
    }
    let most = distance(high);
    assert_eq!(query.distance(Some(most), None), Some(gap));
    gap
}

fn posed(rng: &mut impl Rng, spread: f32, scale: f32) -> Pose {
    let rows = pose_rows(spread, rng);
    Pose::new(rows.map(|[x, y, z, t]| [x * scale, y * scale, z * scale, t]))
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn the_nearest_of_every_two() {
    let mut rng = seeded(48);
    let shapes: [MeshData; 4] =
        [sphere(4), bumpy(3), sheet(4, |x, y| 0.3 * x * y), tangle(12, 20, 2, &mut rng)];
    let mut apart = 0;
    for round in 0..60 {
        let [a, b] = [0, 1].map(|k| {
            let shape = shapes[(round * (k + 1) + k) % shapes.len()].clone();
            Owned::new(shape, [1, 3, 8][(round + k) % 3], round % 2 == 0)
        });
        let scale = [1.0, 1.0, 2.5, 1e-3][round % 4];
        let far = [1.0, 4.0, 1e4][round % 3];
        let [of_a, of_b] = [posed(&mut rng, 0.5, scale), posed(&mut rng, far, 1.0)];
        let in_world = PairBvtt::in_world(
            PosedBvh::new(a.bvh(), &of_a).unwrap(),
            PosedBvh::new(b.bvh(), &of_b).unwrap(),
        );
        let in_first = PairBvtt::new(a.bvh(), b.bvh(), of_b).unwrap();
        let counts = [&a, &b].map(|own| own.triangles.len());
        for query in [in_world, in_first] {
            apart += u32::from(check(&query, counts, &mut rng).interval[1] > 0.0);
        }
    }
    assert!((30..110).contains(&apart), "{apart}");
}

/// Lattices, slivers, points, subnormal numbers: triangles that touch, or nearly, and meshes of which most pairs are equally near.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn the_nearest_of_every_two_where_methods_fail() {
    let mut rng = seeded(49);
    let (mut apart, mut wide) = (0, 0);
    for kind in Family::ALL {
        for round in 0..12 {
            let mut own = |size| Owned::new(family(kind, 4, &mut rng), size, true);
            let (a, b) = (own(1), own(3));
            let extent = a.positions.iter().flatten().fold(0.0, |m: f32, x| m.max(x.abs()));
            let by = [0.0, 1.0, 3.0][round % 3] * extent.min(1e30);
            let pose = Pose::from_translation([by, 0.0, 0.0]);
            let Ok(query) = PairBvtt::new(a.bvh(), b.bvh(), pose) else { continue };
            let counts = [&a, &b].map(|own| own.triangles.len());
            let [low, high] = check(&query, counts, &mut rng).interval;
            apart += u32::from(high > 0.0);
            wide += u32::from(low < high * 0.999);
        }
    }
    assert!(apart > 100, "{apart}");
    assert!(wide > 3, "no pair needed integers: {wide}");
}

#[test]
fn a_limit_is_exact() {
    // Miri takes seconds for a decision in integers.
    let (size, heights) =
        if cfg!(miri) { (1, &[0.1][..]) } else { (3, &[2.0, 0.1, 1e-30, 7.0e7][..]) };
    let own = Owned::new(sheet(size, |_, _| 0.0), 2, true);
    for &z in heights {
        let pose = Pose::from_translation([0.25, 0.0, z]);
        let query = PairBvtt::new(own.bvh(), own.bvh(), pose).unwrap();
        let at = |limit: f32| query.distance(Some(Distance::new(limit).unwrap()), None);
        assert_eq!(at(z.next_down()), None);
        let gap = at(z).unwrap();
        assert!(gap.interval[0] <= f64::from(z) && gap.interval[1] == f64::from(z), "{gap:?}");
        assert_eq!(gap.points[1][2] - gap.points[0][2], f64::from(z));
        assert_eq!(query.distance(None, None).unwrap().pair, gap.pair);
    }
}

#[test]
fn a_mesh_without_triangles_is_at_no_distance() {
    let none = Owned::new(MeshData { positions: [[0.0; 3]].into(), triangles: [].into() }, 2, true);
    let some = Owned::new(sheet(2, |_, _| 0.0), 2, true);
    let query = PairBvtt::new(none.bvh(), some.bvh(), Pose::IDENTITY).unwrap();
    assert_eq!(query.distance(None, Some(TrianglePair { a: 0, b: 0 })), None);
}

fn of(triangles: &[[[f32; 3]; 3]]) -> Owned {
    let indices = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let positions = triangles.as_flattened().to_vec();
    Owned::new(MeshData { positions, triangles: indices.collect() }, 2, true)
}

/// Edges that are parallel but for their rounding to f32, and a point that is nearly as near as they are.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn near_points_of_edges_nearly_in_parallel_are_the_nearest() {
    let a = of(&[[
        [0.049754262, 0.020421863, 0.35722482],
        [-0.8938322, 0.87080514, 0.7958877],
        [0.5665641, -0.95869076, -0.44045115],
    ]]);
    let edges = [
        [0.06909349, 0.0029928905, 0.34823424],
        [-0.874493, 0.85337615, 0.7868971],
        [-0.16680667, 1.1860366, 0.97176224],
    ];
    let b = of(&[edges, [[0.049754266, 0.020421863, 0.35722482]; 3]]);
    let query = PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
    let gap = query.distance(None, None).unwrap();
    let [low, high] = gap.interval;
    assert!(high - low < 1e-12 && gap.pair.b == 0, "{gap:?}");
    assert_eq!(query.distance(Some(Distance::new(2.88e-9).unwrap()), None).unwrap().pair.b, 0);
}

/// An extent that no f32 is.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn the_largest_meshes_have_a_distance() {
    let a = of(&[[[-3e38, 0.0, 0.0], [-3e38, 1e37, 0.0], [3e38, 0.0, 0.0]]]);
    let b = of(&[[[0.0, 0.0, 1e30], [1.0, 0.0, 1e30], [0.0, 1.0, 1e30]]]);
    let query = PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
    let [low, high] = query.distance(None, None).unwrap().interval;
    assert!(low < 1e30 && (1e30..1e31).contains(&high), "{low:e} {high:e}");
}

#[test]
fn a_budget_of_nothing_is_a_step() {
    let own = Owned::new(sheet(2, |_, _| 0.0), 2, true);
    let pose = Pose::from_translation([0.0, 0.0, 1.0]);
    let query = PairBvtt::new(own.bvh(), own.bvh(), pose).unwrap();
    let mut search = query.search(None, None);
    while !search.is_done() {
        query.seek(&mut search, 0);
    }
    assert_eq!(search.gap(), query.distance(None, None));
}
