//! Queries in f64 against the test of every two triangles.

use super::at_one_go;
use crate::bvh::{BuildOptions, BvhStorage, morton, node_bound};
use crate::bvtt::{PairBvtt, PosedBvh, Query, SelfBvtt, TrianglePair};
use crate::triangle::{Adjacency, intersects_f64, intersects_in_mesh};
use crate::{Bvh, Mesh, Node, Pose, Pose64};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use std::vec;
use std::vec::Vec;

extern crate std;

/// A mesh in f64 with all that it borrows.
struct Owned {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    shadow: Vec<[f32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    origin: [f64; 3],
    /// Whether the mesh is in f64; else its positions are those of the shadow.
    is_f64: bool,
}

impl Owned {
    fn new(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, is_f64: bool) -> Self {
        let mut shadow = vec![[0.0; 3]; positions.len()];
        let origin = if is_f64 {
            Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap().origin()
        } else {
            shadow = positions.iter().map(|p| p.map(|x| x as f32)).collect();
            [0.0; 3]
        };
        let n = triangles.len();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let mut scratch = vec![0; 2 * n];
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let mesh = Mesh::new(&shadow, &triangles).unwrap();
        let used = morton(mesh, &BuildOptions::default(), storage, &mut scratch).unwrap();
        let used = used.nodes().len();
        nodes.truncate(used);
        Self { positions, triangles, shadow, nodes, order, origin, is_f64 }
    }

    fn mesh(&self) -> Mesh<'_> {
        if self.is_f64 {
            Mesh::from_f64_unchecked(&self.positions, &self.shadow, self.origin, &self.triangles)
        } else {
            Mesh::new_unchecked(&self.shadow, &self.triangles)
        }
    }

    fn bvh(&self) -> Bvh<'_> {
        Bvh::new_unchecked(self.mesh(), &self.nodes, &self.order)
    }

    fn posed(&self, pose: &Pose64) -> Vec<[[f64; 3]; 3]> {
        let all = 0..self.triangles.len() as u32;
        all.map(|t| self.mesh().triangle_f64(t).map(|p| pose.apply(p))).collect()
    }
}

/// Triangles of some size about a point: some share vertices, some lie in planes.
fn soup(
    rng: &mut impl Rng,
    count: usize,
    size: f64,
    centre: [f64; 3],
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let grid = [0.0, 0.125][rng.random_range(0..2)];
    let coordinate = |rng: &mut _, c: f64| {
        let x: f64 = RngExt::random_range(rng, -1.0..1.0);
        let x = if grid > 0.0 { (x / grid).round() * grid } else { x };
        c + size * x
    };
    let positions: Vec<_> = (0..count).map(|_| centre.map(|c| coordinate(rng, c))).collect();
    let corner = |rng: &mut _, near: u32| (near + RngExt::random_range(rng, 0..9)) % count as u32;
    let triangles = (0..count as u32).map(|i| [i, corner(rng, i), corner(rng, i)]).collect();
    (positions, triangles)
}

fn pose(rng: &mut impl Rng, far: f64) -> Pose64 {
    let axis = glam::DVec3::new(rng.random(), rng.random(), rng.random()).normalize();
    let turn = glam::DQuat::from_axis_angle(axis, rng.random_range(-3.0..3.0));
    let turn = if rng.random() { turn } else { glam::DQuat::IDENTITY };
    let t = [0; 3].map(|_| far * rng.random_range(-1.0..1.0));
    Pose64::from_rotation_translation(turn.to_array(), t)
}

fn brute(a: &[[[f64; 3]; 3]], b: &[[[f64; 3]; 3]]) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    for (i, p) in (0..).zip(a) {
        for (j, q) in (0..).zip(b) {
            if intersects_f64(p, q).unwrap() {
                pairs.push(TrianglePair { a: i, b: j });
            }
        }
    }
    pairs
}

fn sorted(query: &impl Query) -> Vec<TrianglePair> {
    let (mut pairs, _) = at_one_go(query);
    pairs.sort_unstable();
    pairs
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn pairs_in_f64_as_every_two_triangles() {
    let mut rng = seeded(31);
    let mut hits = 0;
    for round in 0..240 {
        let far = [0.0, 1.0, 5e6, 1e12][round % 4];
        let size = [1.0, 1e-3, 1e4][round % 3];
        let mesh = |rng: &mut _, is_f64| {
            let centre = [0; 3].map(|_| far * RngExt::random_range(rng, -1.0..1.0));
            let (positions, triangles) = soup(rng, 60, size, centre);
            (Owned::new(positions, triangles, is_f64), centre)
        };
        let ((a, of_a), (b, of_b)) = (mesh(&mut rng, true), mesh(&mut rng, round % 5 != 0));
        // In the world, so that both come to lie in the same place.
        let (pose_a, mut pose_b) = (pose(&mut rng, far), pose(&mut rng, 0.0));
        let (place_a, place_b) = (pose_a.apply(of_a), pose_b.apply(of_b));
        for k in 0..3 {
            pose_b.rows[k][3] += place_a[k] - place_b[k] + size * rng.random_range(-0.5..0.5);
        }
        let expected = brute(&a.posed(&pose_a), &b.posed(&pose_b));
        let world = |pose: &Pose64, bvh| PosedBvh::in_f64(bvh, pose).unwrap();
        let query = PairBvtt::in_world(world(&pose_a, a.bvh()), world(&pose_b, b.bvh()));
        assert_eq!(sorted(&query), expected, "round {round}");
        let boxes = world(&pose_a, a.bvh()).aabb().unwrap();
        for p in a.posed(&pose_a).into_iter().flatten() {
            assert!(
                (0..3).all(|k| f64::from(boxes.min[k]) <= p[k] && p[k] <= f64::from(boxes.max[k]))
            );
        }
        hits += expected.len();
        // In the frame of the first.
        let a_from_b = pose_a.inverse().unwrap() * pose_b;
        let expected = brute(&a.posed(&Pose64::IDENTITY), &b.posed(&a_from_b));
        let query = PairBvtt::in_f64(a.bvh(), b.bvh(), &a_from_b).unwrap();
        assert_eq!(sorted(&query), expected, "round {round}");
        let swapped = PairBvtt::in_f64(b.bvh(), a.bvh(), &a_from_b.inverse().unwrap()).unwrap();
        let expected = brute(&b.posed(&Pose64::IDENTITY), &a.posed(&a_from_b.inverse().unwrap()));
        assert_eq!(sorted(&swapped), expected, "round {round}");
        hits += expected.len();
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the last test runs the same code")]
fn self_queries_in_f64_as_every_two_triangles() {
    let mut rng = seeded(32);
    let mut hits = 0;
    for round in 0..120 {
        let far = [0.0, 5e6, 1e12][round % 3];
        let (positions, triangles) = soup(&mut rng, 70, 1.0, [far; 3]);
        let owned = Owned::new(positions, triangles, true);
        for rule in [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours] {
            let mut expected = Vec::new();
            for j in 0..owned.triangles.len() as u32 {
                for i in 0..j {
                    if intersects_in_mesh(owned.mesh(), i, j, rule) {
                        expected.push(TrianglePair { a: i, b: j });
                    }
                }
            }
            expected.sort_unstable();
            let query = SelfBvtt::new(owned.bvh()).with_adjacency(rule);
            assert_eq!(sorted(&query), expected, "round {round}");
            hits += expected.len();
        }
    }
    assert!(hits > 20_000, "{hits}");
}

/// In the identity pose both contracts say the same of what f32 holds, by whatever way it comes.
#[test]
fn what_f32_holds_has_the_same_pairs_in_f64() {
    let mut rng = seeded(33);
    let (rounds, size) = if cfg!(miri) { (1, 12) } else { (60, 80) };
    for _ in 0..rounds {
        let mut soup = || {
            let (positions, triangles) = soup(&mut rng, size, 1.0, [0.0; 3]);
            (
                positions.iter().map(|p| p.map(|x| f64::from(x as f32))).collect::<Vec<_>>(),
                triangles,
            )
        };
        let ((p, t), (q, u)) = (soup(), soup());
        let [a, b] = [(&p, &t), (&q, &u)].map(|(p, t)| Owned::new(p.clone(), t.clone(), false));
        let [c, d] = [(&p, &t), (&q, &u)].map(|(p, t)| Owned::new(p.clone(), t.clone(), true));
        let expected = sorted(&PairBvtt::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap());
        assert!(!expected.is_empty());
        let widened = Mesh::new_unchecked(&a.shadow, &a.triangles).widened();
        let widened = Bvh::new_unchecked(widened, &a.nodes, &a.order);
        for query in [
            PairBvtt::in_f64(a.bvh(), b.bvh(), &Pose64::IDENTITY),
            PairBvtt::new(c.bvh(), b.bvh(), Pose::IDENTITY),
            PairBvtt::new(a.bvh(), d.bvh(), Pose::IDENTITY),
            PairBvtt::in_f64(c.bvh(), d.bvh(), &Pose64::IDENTITY),
            PairBvtt::new(widened, d.bvh(), Pose::IDENTITY),
        ] {
            assert_eq!(sorted(&query.unwrap()), expected);
        }
        let expected = sorted(&SelfBvtt::new(a.bvh()));
        assert_eq!(sorted(&SelfBvtt::new(c.bvh())), expected);
        assert_eq!(sorted(&SelfBvtt::new(widened)), expected);
    }
}

/// Triangles so small beside their mesh that a shadow knows few of their digits, or none.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long; another test runs the same code")]
fn small_triangles_of_large_meshes() {
    let mut rng = seeded(34);
    let mut hits = 0;
    for round in 0..400 {
        let detail = [1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9][round % 6];
        let place = [1.0, 0.7, -0.9];
        let mesh = |rng: &mut _| {
            let (mut positions, mut triangles) = soup(rng, 40, detail, place);
            let first = positions.len() as u32;
            positions.extend([[-1.0; 3], [-1.0, 1.0, 1.0], [-1.0, -1.0, 0.0]]);
            triangles.push([first, first + 1, first + 2]);
            Owned::new(positions, triangles, true)
        };
        let (a, b) = (mesh(&mut rng), mesh(&mut rng));
        let jitter = place.map(|x| x + detail * rng.random_range(-0.5..0.5));
        let a_from_b = Pose64::from_translation(jitter)
            * pose(&mut rng, 0.0)
            * Pose64::from_translation(place.map(|x| -x));
        let expected = brute(&a.posed(&Pose64::IDENTITY), &b.posed(&a_from_b));
        let query = PairBvtt::in_f64(a.bvh(), b.bvh(), &a_from_b).unwrap();
        assert_eq!(sorted(&query), expected, "round {round}");
        hits += expected.len();
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
#[cfg(feature = "within")]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn within_a_distance_in_f64_as_every_two_triangles() {
    let mut rng = seeded(35);
    let (mut hits, mut own_hits) = (0, 0);
    for round in 0..12 {
        let far = [0.0, 5e6, 1e12][round % 3];
        let mut mesh = || {
            let (positions, triangles) = soup(&mut rng, 30, 1.0, [far; 3]);
            Owned::new(positions, triangles, true)
        };
        let (a, b) = (mesh(), mesh());
        let turned = pose(&mut rng, 1.0);
        for distance in [1e-3, 0.1, 0.5] {
            let [of_a, of_b] = [a.posed(&Pose64::IDENTITY), b.posed(&turned)];
            let near = |p: &_, q: &_| crate::triangle::within_in_f64(p, q, distance);
            let mut expected = Vec::new();
            for (i, p) in (0..).zip(&of_a) {
                let found = (0..).zip(&of_b).filter(|(_, q)| near(p, q));
                expected.extend(found.map(|(j, _)| TrianglePair { a: i, b: j }));
            }
            let query = PairBvtt::in_f64(a.bvh(), b.bvh(), &turned).unwrap();
            assert_eq!(
                sorted(&query.within(crate::Distance::new(distance).unwrap())),
                expected,
                "{round} {distance}"
            );
            hits += expected.len();

            expected.clear();
            for j in 0..a.triangles.len() as u32 {
                for i in 0..j {
                    let [s, t] = [i, j].map(|t| a.triangles[t as usize]);
                    let [p, q] = [i, j].map(|t| a.mesh().triangle_f64(t));
                    let is_hit = if s.iter().any(|vertex| t.contains(vertex)) {
                        intersects_in_mesh(a.mesh(), i, j, Adjacency::SharedIndexRule)
                    } else {
                        near(&p, &q)
                    };
                    expected.extend(is_hit.then_some(TrianglePair { a: i, b: j }));
                }
            }
            expected.sort_unstable();
            let query = SelfBvtt::new(a.bvh()).within(crate::Distance::new(distance).unwrap());
            assert_eq!(sorted(&query), expected, "{round} {distance}");
            own_hits += expected.len();
        }
    }
    assert!(hits > 1_000 && own_hits > 1_000, "{hits} {own_hits}");
}

/// Triangles that their shadows know little of, in a mesh so small that squares of its error underflow.
#[test]
#[cfg(feature = "within")]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn near_triangles_of_tiny_meshes_in_f64() {
    let mut rng = seeded(36);
    let mut answers = [0; 2];
    for _ in 0..300 {
        let mut points = vec![[-1e-18; 3], [1e-18; 3], [1e-18, -1e-18, 0.0]];
        let gap = 1e-21 * rng.random_range(0.5..1.5);
        for z in [0.0, gap] {
            let at = |x: f64, y: f64| [0.9e-18 + x * 1e-21, 0.9e-18 + y * 1e-21, 0.9e-18 + z];
            points.extend([at(0.0, 0.0), at(rng.random(), 0.0), at(0.0, rng.random())]);
        }
        let own = Owned::new(points, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]], true);
        let distance = (gap * rng.random_range(0.999..1.001)) as f32;
        let [p, q] = [1, 2].map(|t| own.mesh().triangle_f64(t));
        let truth = crate::triangle::within_in_f64(&p, &q, distance);
        let query = SelfBvtt::new(own.bvh()).within(crate::Distance::new(distance).unwrap());
        let found = sorted(&query).contains(&TrianglePair { a: 1, b: 2 });
        assert_eq!(found, truth, "{gap:e} {distance:e}");
        answers[usize::from(truth)] += 1;
    }
    assert!(answers.iter().all(|&count| count > 50), "{answers:?}");
}

/// Poses that are the identity in f32, and are not in f64: far from the origin, shadows are off by what boxes are padded by.
#[test]
#[cfg(feature = "within")]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn near_pairs_in_poses_close_to_the_identity() {
    let mut rng = seeded(37);
    let mut hits = 0;
    for round in 0..200 {
        let (far, stretch) = (1e12, 1.0 + rng.random_range(-2.9e-8..2.9e-8));
        let (p, t) = soup(&mut rng, 20, 5.0, [far; 3]);
        let (q, u) = soup(&mut rng, 20, 5.0, [0.0; 3]);
        let (a, b) = (Owned::new(p, t, true), Owned::new(q, u, round % 2 == 0));
        let mut pose_a = Pose64::from_translation([-far * stretch; 3]);
        (0..3).for_each(|k| pose_a.rows[k][k] = stretch);
        let (pose_b, distance) = (pose(&mut rng, 0.0), 10f32.powi(rng.random_range(-5..1)));
        let (of_a, of_b) = (a.posed(&pose_a), b.posed(&pose_b));
        let mut expected = Vec::new();
        for (i, p) in (0..).zip(&of_a) {
            let near = |q: &_| crate::triangle::within_in_f64(p, q, distance);
            let found = (0..).zip(&of_b).filter(|(_, q)| near(q));
            expected.extend(found.map(|(j, _)| TrianglePair { a: i, b: j }));
        }
        let query = PairBvtt::in_world(
            PosedBvh::in_f64(a.bvh(), &pose_a).unwrap(),
            PosedBvh::in_f64(b.bvh(), &pose_b).unwrap(),
        );
        let query = query.within(crate::Distance::new(distance).unwrap());
        assert_eq!(sorted(&query), expected, "{round} {distance:e}");
        hits += expected.len();
    }
    assert!(hits > 1_000, "{hits}");
}

/// Walls that face each other, whose boxes are as far apart as they are: positions in f64 far from the origin are posed to where
/// their shadow is not, and a pose may be the identity in f32 and not in f64.
#[test]
#[cfg(feature = "within")]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn near_walls_far_from_the_origin_in_f64() {
    let mut rng = seeded(38);
    let wall = |x: f64, near: f64| [[x, near, near], [x, near + 1.0, near], [x, near, near + 1.0]];
    let mut answers = [0; 2];
    for _ in 0..200 {
        let far = 1e12;
        let (pose_a, x) = loop {
            let stretch = 1.0 + rng.random_range(-2.9e-8..2.9e-8);
            let mut pose_a = Pose64::from_translation([-far * stretch; 3]);
            (0..3).for_each(|k| pose_a.rows[k][k] = stretch);
            let x = far + rng.random_range(-4.0..4.0);
            let middle = (far - 10.0) * 0.5 + x * 0.5;
            let [posed, zero] = [x, middle].map(|x| pose_a.apply([x, far, far])[0]);
            if ((posed - zero) - (x - middle)).abs() > 1e-4 {
                break (pose_a, x);
            }
        };
        let points = [wall(far - 10.0, far), wall(x, far)].concat();
        let a = Owned::new(points, vec![[0, 1, 2], [3, 4, 5]], true);
        let [posed, _, _] = pose_a.apply([x, far, far]);
        let gap = rng.random_range(1e-3..2e-3);
        let b = Owned::new(wall(posed + gap, 0.0).to_vec(), vec![[0, 1, 2]], true);
        let distance = (gap + rng.random_range(-5e-5..5e-5)) as f32;
        let of_b = b.posed(&Pose64::IDENTITY);
        let truth = crate::triangle::within_in_f64(&a.posed(&pose_a)[1], &of_b[0], distance);
        let query = PairBvtt::in_world(
            PosedBvh::in_f64(a.bvh(), &pose_a).unwrap(),
            PosedBvh::in_f64(b.bvh(), &Pose64::IDENTITY).unwrap(),
        );
        let query = query.within(crate::Distance::new(distance).unwrap());
        assert_eq!(query.count(), u64::from(truth), "{gap:e} {distance:e}");
        answers[usize::from(truth)] += 1;
    }
    assert!(answers.iter().all(|&count| count > 50), "{answers:?}");
}

#[cfg(feature = "within")]
#[test]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn distances_in_f64_as_every_two_triangles() {
    let mut rng = seeded(34);
    let mut apart = 0;
    for round in 0..60 {
        let far = [0.0, 1.0, 5e6, 1e12][round % 4];
        let size = [1.0, 1e-3, 1e4][round % 3];
        let mesh = |rng: &mut _, is_f64| {
            let centre = [0; 3].map(|_| far * RngExt::random_range(rng, -1.0..1.0));
            let (positions, triangles) = soup(rng, 12, size, centre);
            (Owned::new(positions, triangles, is_f64), centre)
        };
        let ((a, of_a), (b, of_b)) = (mesh(&mut rng, true), mesh(&mut rng, round % 5 != 0));
        let (pose_a, mut pose_b) = (pose(&mut rng, far), pose(&mut rng, 0.0));
        let (place_a, place_b) = (pose_a.apply(of_a), pose_b.apply(of_b));
        for k in 0..3 {
            let by = [0.5, 2.5, 40.0][round % 3];
            pose_b.rows[k][3] += place_a[k] - place_b[k] + size * by * rng.random_range(-1.0..1.0);
        }
        let world = |pose: &Pose64, bvh| PosedBvh::in_f64(bvh, pose).unwrap();
        let query = PairBvtt::in_world(world(&pose_a, a.bvh()), world(&pose_b, b.bvh()));
        let counts = [&a, &b].map(|own| own.triangles.len());
        let gap = super::distance::check(&query, counts, &mut rng);
        apart += u32::from(gap.interval[0] > 0.0);
    }
    assert!((15..60).contains(&apart), "{apart}");
}

/// Squares of lengths that underflow prove nothing.
#[cfg(feature = "within")]
#[test]
#[cfg_attr(miri, ignore = "takes miri too long")]
fn the_smallest_distances_in_f64() {
    let p = |exponent: i32| f64::from_bits(((1023 + exponent) as u64) << 52);
    let a = vec![[0.0; 3], [0.0, 0.0, p(-537)], [p(-530), 0.0, 0.0]];
    let b = vec![[0.0, p(-535), p(-536)], [0.0, 0.0, p(-537) + p(-538)], [0.0, p(-530), p(-536)]];
    let [a, b] = [a, b].map(|positions| Owned::new(positions, vec![[0, 1, 2]], true));
    let query = PairBvtt::in_f64(a.bvh(), b.bvh(), &Pose64::IDENTITY).unwrap();
    let gap = query.distance(None, None).unwrap();
    assert!(gap.interval[1] > 0.0 && gap.interval[1] < 1e-12, "{gap:?}");
    assert!(query.distance(Some(crate::Distance::new(1.0).unwrap()), None).is_some());
}
