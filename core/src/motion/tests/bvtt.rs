//! Moving meshes against every pair of their triangles.

extern crate std;

use super::rounds;
#[cfg(feature = "within")]
use crate::Distance;
use crate::bvh::{BuildOptions, BvhStorage, Refit, morton, node_bound, refit};
use crate::bvtt::{NodePair, PairBvtt, PosedBvh, SelfBvtt, TrianglePair, Work};
use crate::motion::common_time::first_overlap;
#[cfg(feature = "within")]
use crate::motion::impact::impact_within;
use crate::motion::{Impact, MotionError, MovingBvh, MovingBvtt, impact_in_mesh};
use crate::triangle::{Adjacency, intersects_in_mesh};
use crate::{Aabb, Bvh, Mesh, Node, Pose, Pose64};
use core::ops::ControlFlow;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use std::vec::Vec;

type Hit = (TrianglePair, Impact);

/// A mesh of `n` triangles, some of which share vertices, and the nodes of its BVH.
struct Soup {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Soup {
    fn new(rng: &mut ChaCha8Rng, n: usize, size: f32) -> Self {
        let vertices = n * 2;
        let positions = (0..vertices)
            .map(|v| {
                // Neighbours in the list are near each other.
                let at = (v as f32 / vertices as f32) * 2.0 - 1.0;
                [0, 1, 2].map(|k| at * [1.0, 0.3, 0.2][k] + rng.random_range(-size..size))
            })
            .collect();
        let triangles = (0..n as u32)
            .map(|t| [0, 1, 2].map(|_| (2 * t + rng.random_range(0..4)) % vertices as u32))
            .collect();
        Self::of(rng, positions, triangles)
    }

    /// A sheet of `n` by `n` squares, all of whose triangles look to the same side, more or less flat.
    fn sheet(rng: &mut ChaCha8Rng, n: u32, size: f32) -> Self {
        let row = n + 1;
        let positions = (0..row * row)
            .map(|v| {
                [(v % row) as f32, (v / row) as f32, 0.0].map(|x| x + rng.random_range(-size..size))
            })
            .collect();
        let triangles = (0..n * n)
            .flat_map(|square| {
                let v = square / n * row + square % n;
                [[v, v + 1, v + row], [v + 1, v + row + 1, v + row]]
            })
            .collect();
        Self::of(rng, positions, triangles)
    }

    fn of(rng: &mut ChaCha8Rng, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        let n = triangles.len();
        let mut soup = Self { positions, triangles, nodes: Vec::new(), order: Vec::new() };
        let (mut nodes, mut order) = (std::vec![Node::EMPTY; node_bound(n)], std::vec![0; n]);
        let options = BuildOptions { leaf_size: rng.random_range(1..=8), ..Default::default() };
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let used =
            morton(soup.mesh(), &options, storage, &mut std::vec![0; 2 * n]).unwrap().nodes().len();
        nodes.truncate(used);
        (soup.nodes, soup.order) = (nodes, order);
        soup
    }

    fn mesh(&self) -> Mesh<'_> {
        Mesh::new(&self.positions, &self.triangles).unwrap()
    }

    fn bvh(&self) -> Bvh<'_> {
        Bvh::new_unchecked(self.mesh(), &self.nodes, &self.order)
    }

    /// The same triangles elsewhere, with nodes that are refitted.
    fn moved(&self, mut change: impl FnMut([f32; 3]) -> [f32; 3]) -> Self {
        let mut moved = Self {
            positions: self.positions.iter().map(|&p| change(p)).collect(),
            triangles: self.triangles.clone(),
            nodes: self.nodes.clone(),
            order: self.order.clone(),
        };
        let Self { positions, triangles, nodes, order } = &mut moved;
        refit(Mesh::new(positions, triangles).unwrap(), nodes, order, Refit::default()).unwrap();
        moved
    }
}

/// A leaf of one triangle.
fn leaf(corners: &[[f32; 3]; 3]) -> Node {
    let Aabb { min, max } = Aabb::of(corners);
    Node { min, first: 0, max, count: 1 }
}

fn at_rest(soup: &Soup) -> PosedBvh<'_> {
    PosedBvh::new(soup.bvh(), &Pose::IDENTITY).unwrap()
}

/// All verbs give what `every` pair gives.
fn check<const SELF: bool>(query: &MovingBvtt<'_, SELF>, every: &[Hit]) {
    let mut found = Vec::new();
    let _ = query.visit(|pair, impact| {
        found.push((pair, impact));
        ControlFlow::Continue(())
    });
    found.sort_by_key(|hit| hit.0);
    assert_eq!(found, every);
    let proven = every.iter().filter(|hit| hit.1.is_proven()).count();
    assert_eq!(query.count(), [proven as u64, every.len() as u64]);
    let any = query.any();
    assert!(any.map_or(every.is_empty(), |hit| every.contains(&hit)));
    assert_eq!(any.is_some_and(|hit| hit.1.is_proven()), proven > 0);
    let first = every.iter().min_by(|p, q| (p.1.from, p.0).partial_cmp(&(q.1.from, q.0)).unwrap());
    assert_eq!(query.first_impact().as_ref(), first);
    // From any cut of the tree.
    let (mut front, mut next) = (Vec::from_iter(query.root()), Vec::<NodePair>::new());
    for _ in 0..3 {
        for n in front.drain(..) {
            if query.children(n, &mut |child, _| next.push(child)) == 0 {
                next.push(n);
            }
        }
        std::mem::swap(&mut front, &mut next);
    }
    let (mut parts, mut best, mut work) = (Vec::new(), None, Work::default());
    for n in front {
        let limit = best.map_or(f64::INFINITY, |(_, impact): Hit| impact.from);
        let found = query.first_impact_below(n, &mut Work::default(), limit);
        let key = |(pair, impact): &Hit| (impact.from, *pair);
        best = best.into_iter().chain(found).min_by(|p, q| key(p).partial_cmp(&key(q)).unwrap());
        let _ = query.visit_below(n, &mut work, |pair, impact| {
            parts.push((pair, impact));
            ControlFlow::Continue(())
        });
    }
    // With a budget, and then from what that has left: all, and the first.
    let (mut within_budget, mut left) =
        (Vec::new(), Vec::from_iter(query.root().map(|n| (n, 0.0))));
    while let Some((n, from)) = left.pop() {
        let (mut visited, mut add) = (Work::default(), |pair, impact: Impact| {
            assert!(from <= impact.from);
            within_budget.push((pair, impact));
            ControlFlow::Continue(f64::INFINITY)
        });
        let leave = &mut |n, from| left.push((n, from));
        let _ = query.visit_with_budget(n, &mut visited, 9, f64::INFINITY, &mut add, leave);
    }
    let (mut early, mut left) = (Vec::<Hit>::new(), Vec::from_iter(query.root()));
    while let Some(n) = left.pop() {
        let limit = early.last().map_or(f64::INFINITY, |(_, impact)| impact.from);
        let mut add = |pair, impact: Impact| {
            let is_first =
                early.last().is_none_or(|first| (impact.from, pair) < (first.1.from, first.0));
            if is_first {
                early.push((pair, impact));
            }
            ControlFlow::Continue(early.last().map_or(impact, |first| first.1).from)
        };
        let leave = &mut |n, _| left.push(n);
        let _ = query.visit_with_budget(n, &mut Work::default(), 9, limit, &mut add, leave);
    }
    assert_eq!(early.last(), first);
    within_budget.sort_by_key(|hit| hit.0);
    assert_eq!(within_budget, every);
    parts.sort_by_key(|hit| hit.0);
    assert_eq!(parts, every);
    assert_eq!(best.as_ref(), first);
    let overlap = query.first_overlap();
    assert!(first.is_none_or(|(_, impact)| overlap.is_some_and(|time| time <= impact.from)));
}

/// All boxes of triangles that overlap at a time, and when first.
#[test]
fn boxes_only_as_every_pair() {
    let mut rng = seeded(64);
    let mut hits = 0;
    for round in 0..rounds().min(200) {
        let start = Soup::new(&mut rng, 1 + round % 50, 0.1);
        let by = [0.0, 0.05, 1.0][rng.random_range(0..3_usize)];
        let end =
            start.moved(|p| p.map(|x| if by > 0.0 { x + rng.random_range(-by..by) } else { x }));
        let query =
            SelfBvtt::moving(MovingBvh::new(at_rest(&start), at_rest(&end)).unwrap()).boxes_only();
        let mut every = Vec::new();
        for a in 0..start.triangles.len() as u32 {
            for b in a + 1..start.triangles.len() as u32 {
                let bounds =
                    |soup: &Soup, triangle| leaf(&soup.mesh().shadow_triangle(triangle)).bounds();
                let [start, end] = [&start, &end].map(|soup| [bounds(soup, a), bounds(soup, b)]);
                let first = first_overlap(&start, &end);
                let impact = first.map(|from| Impact { from, to: f64::INFINITY });
                every.extend(impact.map(|impact| (TrianglePair { a, b }, impact)));
            }
        }
        hits += every.len();
        check(&query, &every);
    }
    assert!(cfg!(miri) || hits > 500, "{hits}");
}

#[test]
fn rigid_bodies_as_every_pair() {
    let mut rng = seeded(60);
    let mut hits = 0;
    for round in 0..rounds().min(400) {
        let soups = [(); 2].map(|()| {
            let n = rng.random_range(1..40);
            Soup::new(&mut rng, n, 0.2)
        });
        let mut pose = || {
            let (sin, cos) = rng.random_range(-0.5..0.5_f64).sin_cos();
            let t = [0; 3].map(|_| rng.random_range(-1.0..1.0));
            Pose64::new([[cos, -sin, 0.0, t[0]], [sin, cos, 0.0, t[1]], [0.0, 0.0, 1.0, t[2]]])
        };
        let [a, b] = soups.each_ref().map(|soup| {
            let [start, end] = [(pose(), 1), (pose(), 2)].map(|(pose, in_f64)| {
                if round & in_f64 != 0 {
                    return PosedBvh::in_f64(soup.bvh(), &pose).unwrap();
                }
                let rows = pose.rows.map(|row| row.map(|x| x as f32));
                PosedBvh::new(soup.bvh(), &Pose::new(rows)).unwrap()
            });
            MovingBvh::new(start, end).unwrap()
        });
        let query = PairBvtt::moving(a, b);
        let mut every = Vec::new();
        for a in 0..soups[0].triangles.len() as u32 {
            for b in 0..soups[1].triangles.len() as u32 {
                let pair = TrianglePair { a, b };
                every.extend(query.impact(pair).map(|impact| (pair, impact)));
            }
        }
        hits += every.len();
        check(&query, &every);
    }
    assert!(cfg!(miri) || hits > 500, "{hits}");
}

/// A small triangle far from the origin of its motion, where f32 rounds by more than it is long, touches a tile at the end, or at the start.
#[test]
fn one_end_in_f64_and_the_other_in_f32() {
    let mut rng = seeded(63);
    let soup = |points: [[f32; 3]; 3]| Soup {
        positions: points.to_vec(),
        triangles: std::vec![[0, 1, 2]],
        nodes: std::vec![leaf(&points)],
        order: std::vec![0],
    };
    let tile = soup([[1000.0, 0.0, 0.0], [1000.01, 0.0, 0.0], [1000.0, 0.01, 0.0]]);
    for round in 0..rounds().min(400) {
        let blade = soup([0; 3].map(|_| [0; 3].map(|_| rng.random_range(-0.002..0.002_f32))));
        let (sin, cos) = rng.random_range(-0.5..0.5_f64).sin_cos();
        let pose = |z: f64| {
            Pose64::new([[1.0, 0.0, 0.0, 1000.003], [0.0, cos, -sin, 0.003], [0.0, sin, cos, z]])
        };
        let height = |p: &[f32; 3]| pose(0.0).apply(p.map(f64::from))[2];
        let lowest = blade.positions.iter().map(height).fold(f64::INFINITY, f64::min);
        let near = PosedBvh::in_f64(blade.bvh(), &pose(-lowest)).unwrap();
        let far = Pose::from_translation([1000.003, 0.003, 1.0]);
        let far = PosedBvh::new(blade.bvh(), &far).unwrap();
        let falling = if round % 2 == 0 { [far, near] } else { [near, far] };
        let rest = MovingBvh::new(at_rest(&tile), at_rest(&tile)).unwrap();
        let query = PairBvtt::moving(rest, MovingBvh::new(falling[0], falling[1]).unwrap());
        let pair = TrianglePair { a: 0, b: 0 };
        let impact = query.impact(pair).expect("they touch");
        check(&query, &[(pair, impact)]);
    }
}

#[test]
fn deforming_meshes_as_every_pair() {
    let mut rng = seeded(61);
    let (mut hits, mut proven) = (0, 0);
    for _ in 0..rounds().min(400) {
        let start = if rng.random_bool(0.5) {
            let n = rng.random_range(1..60);
            Soup::new(&mut rng, n, 0.1)
        } else {
            let (n, size) = (rng.random_range(1..=5), rng.random_range(0.01..0.8));
            Soup::sheet(&mut rng, n, size)
        };
        let n = start.triangles.len();
        let by = [0.0, 0.01, 0.3, 1.0][rng.random_range(0..4_usize)];
        let end =
            start.moved(|p| p.map(|x| if by > 0.0 { x + rng.random_range(-by..by) } else { x }));
        let motion = MovingBvh::new(at_rest(&start), at_rest(&end)).unwrap();
        for adjacency in [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours] {
            let query = SelfBvtt::moving(motion).with_adjacency(adjacency);
            let mut every = Vec::new();
            for a in 0..n as u32 {
                for b in a + 1..n as u32 {
                    let pair = TrianglePair { a, b };
                    every.extend(query.impact(pair).map(|impact| (pair, impact)));
                    let alone = impact_in_mesh(start.mesh(), end.mesh(), a, b, adjacency);
                    if alone.is_some_and(Impact::is_proven) {
                        assert_eq!(
                            every.last().map(|hit| hit.0),
                            Some(pair),
                            "its boxes do not overlap"
                        );
                    }
                    if by == 0.0 {
                        let now = intersects_in_mesh(start.mesh(), a, b, adjacency);
                        assert_eq!(alone, now.then_some(Impact { from: 0.0, to: 0.0 }));
                    }
                }
            }
            (hits, proven) =
                (hits + every.len(), proven + every.iter().filter(|hit| hit.1.is_proven()).count());
            check(&query, &every);
        }
    }
    assert!(cfg!(miri) || hits > 2_000 && proven * 100 > hits * 99, "{proven} of {hits}");
}

/// A motion common to both bodies changes nothing but roundings: none of integers.
#[test]
fn a_common_motion_changes_nothing() {
    let mut rng = seeded(62);
    let soup = Soup::new(&mut rng, 50, 0.2).moved(|p| p.map(|x| (x * 64.0).round()));
    let at = |t: [f32; 3]| PosedBvh::new(soup.bvh(), &Pose::from_translation(t)).unwrap();
    let found = |common: [f32; 3]| {
        let end = |t: [f32; 3]| at([0, 1, 2].map(|k| t[k] + common[k]));
        let a = MovingBvh::new(at([0.0; 3]), end([0.0; 3])).unwrap();
        let b = MovingBvh::new(at([0.0, 90.0, 1.0]), end([3.0, -90.0, 0.0])).unwrap();
        let mut found = Vec::new();
        let _ = PairBvtt::moving(a, b).visit(|pair, impact| {
            found.push((pair, impact));
            ControlFlow::Continue(())
        });
        found.sort_by_key(|hit: &Hit| hit.0);
        found
    };
    let pairs = |hits: &[Hit]| hits.iter().map(|hit| hit.0).collect::<Vec<_>>();
    assert_eq!(pairs(&found([512.0, -1024.0, 7.0])), pairs(&found([0.0; 3])));
    assert!(found([0.0; 3]).len() > 100);
}

#[test]
fn what_is_no_motion_is_refused() {
    let (mut rng, other) = (seeded(63), &mut seeded(64));
    let (soup, mut changed) = (Soup::new(&mut rng, 9, 0.2), Soup::new(other, 9, 0.2));
    let refused = |soup: &Soup, other: &Soup| MovingBvh::new(at_rest(soup), at_rest(other)).err();
    assert_eq!(refused(&soup, &soup), None);
    changed.triangles = soup.triangles.clone();
    changed.triangles[5] = [0, 1, 0];
    assert_eq!(refused(&soup, &changed), Some(MotionError::Triangle { triangle: 5 }));
    changed.triangles = soup.triangles.clone();
    changed.order = soup.order.iter().rev().copied().collect();
    assert!(matches!(refused(&soup, &changed), Some(MotionError::Tree { .. })));
    let fewer = Soup::new(&mut rng, 8, 0.2);
    assert!(matches!(refused(&soup, &fewer), Some(MotionError::Triangle { .. })));
}

/// Pairs within a distance, by every verb, as every pair of triangles has them.
#[cfg(feature = "within")]
#[test]
fn within_a_distance_as_every_pair() {
    let (mut rng, mut hits) = (seeded(65), [0; 2]);
    for round in 0..rounds().min(200) {
        let distance = Distance::new([0.05, 0.3, 1e-3][round % 3]).unwrap();
        let soups = [(); 2].map(|()| {
            let n = rng.random_range(1..30);
            Soup::new(&mut rng, n, 0.2)
        });
        let by = rng.random_range(0.0..0.5_f32);
        let ends = soups.each_ref().map(|soup| {
            soup.moved(|p| p.map(|x| if by > 0.0 { x + rng.random_range(-by..by) } else { x }))
        });
        let far = [[3.0, -2.0, 0.5], [0.0; 3]][round % 2];
        let pose = |t: [f32; 3]| Pose::from_translation([0, 1, 2].map(|k| t[k] + far[k]));
        let [a, b] = [0, 1].map(|k| {
            let at = |bvh, t| match (round >> 1) % 3 {
                0 => PosedBvh::in_f64(bvh, &Pose64::from(pose(t))).unwrap(),
                _ => PosedBvh::new(bvh, &pose(t)).unwrap(),
            };
            let shift = 0.2 * k as f32;
            MovingBvh::new(at(soups[k].bvh(), [shift; 3]), at(ends[k].bvh(), [-shift; 3])).unwrap()
        });
        let query = PairBvtt::moving(a, b).within(distance);
        let (mut every, mut meet) = (Vec::new(), Vec::new());
        for a in 0..soups[0].triangles.len() as u32 {
            for b in 0..soups[1].triangles.len() as u32 {
                let pair = TrianglePair { a, b };
                every.extend(query.impact(pair).map(|impact| (pair, impact)));
                meet.extend(query.within(Distance::default()).impact(pair).map(|_| pair));
                let [p, q] = query.leaves(pair).map(|leaf| leaf.corners);
                let alone = impact_within(&p, &q, distance.get());
                if alone.is_some_and(Impact::is_proven) {
                    assert_eq!(every.last().map(|hit| hit.0), Some(pair), "its boxes are apart");
                }
            }
        }
        hits[0] += every.len();
        assert!(meet.iter().all(|pair| every.iter().any(|hit| hit.0 == *pair)));
        check(&query, &every);
        // One mesh, of which neighbours are decided by their own rule.
        let motion = MovingBvh::new(at_rest(&soups[0]), at_rest(&ends[0])).unwrap();
        let own = SelfBvtt::moving(motion).within(distance);
        let mut every = Vec::new();
        for b in 0..soups[0].triangles.len() as u32 {
            for a in 0..b {
                let pair = TrianglePair { a, b };
                every.extend(own.impact(pair).map(|impact| (pair, impact)));
            }
        }
        every.sort_by_key(|hit| hit.0);
        hits[1] += every.len();
        check(&own, &every);
    }
    assert!(cfg!(miri) || hits.iter().all(|&hits| hits > 1_000), "{hits:?}");
}
