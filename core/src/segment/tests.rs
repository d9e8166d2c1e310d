//! Segments against fractions: another method, which knows no BVH either.

extern crate std;

use super::*;
use crate::bvh::{BuildOptions, BvhStorage, morton, node_bound};
use crate::{Bvh, Mesh, Node, Pose};
use pfront_testkit::oracle::first_parameter;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded};
use pfront_testkit::solids::{map, mapped, pair};
use std::vec;
use std::vec::Vec;

type Lattice = [i64; 3];

fn with_bvh<R>(mesh: Mesh<'_>, then: impl FnOnce(Bvh<'_>) -> R) -> R {
    let n = mesh.triangles().len();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    then(morton(mesh, &BuildOptions::default(), storage, &mut vec![0; 2 * n]).unwrap())
}

/// Triangles with integer corners below 2^9: those of a lattice solid in an affine map, or of a soup, a third of them without area.
fn corners(rng: &mut ChaCha8Rng, is_soup: bool) -> Vec<[Lattice; 3]> {
    let mut triangles = Vec::new();
    if is_soup {
        for _ in 0..rng.random_range(0..40) {
            let mut t = [[0; 3]; 3].map(|p| p.map(|_: i64| rng.random_range(-3..=3)));
            match rng.random_range(0..6) {
                0 => t[2] = t[1],
                1 => t[2] = [0, 1, 2].map(|k| 2 * t[1][k] - t[0][k]),
                _ => {}
            }
            triangles.push(t);
        }
    } else {
        let (solid, (rows, _)) = (pair(rng)[0].mesh(true, rng), map(rng));
        for t in &solid.triangles {
            // Doubled, so that the middles of cells are points too.
            let at = |v: u32| mapped(&rows, solid.positions[v as usize]).map(|x| 2 * x as i64);
            triangles.push(t.map(at));
        }
    }
    triangles
}

/// Ends near the triangles: corners, middles of two corners, other points, or the same twice.
fn ends(rng: &mut ChaCha8Rng, triangles: &[[Lattice; 3]]) -> [Lattice; 2] {
    let mut end = || {
        let any = |rng: &mut ChaCha8Rng| match triangles {
            [] => [0; 3],
            _ => triangles[rng.random_range(0..triangles.len())][rng.random_range(0..3)],
        };
        let (p, q) = (any(rng), any(rng));
        match rng.random_range(0..4) {
            0 => p,
            1 => [0, 1, 2].map(|k| (p[k] + q[k]) / 2),
            2 => [0, 1, 2].map(|k| 2 * p[k] - q[k]),
            _ => [0, 1, 2].map(|k| p[k] + rng.random_range(-2..=2)),
        }
    };
    let [p, q] = [end(), end()];
    if rng.random_range(0..10) == 0 { [p, p] } else { [p, q] }
}

fn compare(p: (i128, i128), q: (i128, i128)) -> Ordering {
    (p.0 * q.1).cmp(&(q.0 * p.1))
}

/// Compares what is found in some posed meshes with the fractions of their triangles.
fn check(segment: Segment, meshes: &[PosedBvh<'_>], truth: &[Vec<Option<(i128, i128)>>]) -> usize {
    let mut hits = 0;
    for (posed, truth) in meshes.iter().zip(truth) {
        let mut found = Vec::new();
        let _ = segment.visit(posed, |hit| {
            found.push(hit);
            ControlFlow::Continue(())
        });
        found.sort_unstable_by_key(|hit| hit.triangle);
        let expected = (0..).zip(truth).filter_map(|(triangle, at)| Some((triangle, (*at)?)));
        assert!(found.iter().map(|hit| hit.triangle).eq(expected.clone().map(|(t, _)| t)));
        for (hit, (_, (over, under))) in found.iter().zip(expected) {
            assert!((hit.at - over as f64 / under as f64).abs() < 1e-14, "{hit:?} {over} {under}");
        }
        hits += found.len();
    }
    let all = truth.iter().enumerate().flat_map(|(mesh, truth)| {
        let of_mesh = move |(triangle, at): (u32, &Option<_>)| Some((mesh, triangle, (*at)?));
        (0..).zip(truth).filter_map(of_mesh)
    });
    let expected = all.min_by(|p, q| compare(p.2, q.2)).map(|(mesh, triangle, _)| (mesh, triangle));
    let found = segment.first(meshes.iter().copied());
    assert_eq!(found.map(|(mesh, hit)| (mesh, hit.triangle)), expected, "{segment:?}");
    hits
}

#[test]
fn segments_meet_what_fractions_say_in_every_precision() {
    let (mut rng, mut hits) = (seeded(47), 0);
    for round in 0..if cfg!(miri) { 4 } else { 600 } {
        let soups = [round % 2 == 0, round % 3 == 0];
        let triangles = soups.map(|is_soup| corners(&mut rng, is_soup));
        // The second mesh is turned and moved, without rounding.
        let (rows, _) = loop {
            let (rows, scale) = map(&mut rng);
            if scale == 1 {
                break (rows, scale);
            }
        };
        let by = [0; 3].map(|_| rng.random_range(-5..=5));
        let posed = |p: Lattice| {
            [0, 1, 2].map(|i| (0..3).map(|k| i64::from(rows[i][k]) * p[k]).sum::<i64>() + by[i])
        };
        let in_world = [triangles[0].clone(), triangles[1].iter().map(|t| t.map(posed)).collect()];
        let pose = Pose::new([0, 1, 2].map(|i| {
            let [x, y, z] = rows[i].map(|x| x as f32);
            [x, y, z, by[i] as f32]
        }));
        let segments: Vec<_> = (0..20)
            .map(|_| {
                let of = rng.random_range(0..2);
                ends(&mut rng, &in_world[of])
            })
            .collect();
        let truth = |ends: [Lattice; 2]| {
            in_world.each_ref().map(|of| of.iter().map(|t| first_parameter(ends, t)).collect())
        };
        let indices = triangles.each_ref().map(|of| {
            (0..of.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect::<Vec<_>>()
        });
        let lattice = triangles.each_ref().map(|of| of.as_flattened());
        let positions =
            lattice.map(|of| of.iter().map(|p| p.map(|x| x as f32)).collect::<Vec<_>>());
        let [a, b] = [0, 1].map(|i| Mesh::new(&positions[i], &indices[i]).unwrap());
        with_bvh(a, |a| {
            with_bvh(b, |b| {
                let sides = [PosedBvh::new(a, &Pose::IDENTITY), PosedBvh::new(b, &pose)];
                let sides = sides.map(Result::unwrap);
                for &ends in &segments {
                    let [from, to] = ends.map(|p| p.map(|x| x as f32));
                    hits += check(Segment::new(from, to).unwrap(), &sides, &truth(ends));
                }
            });
        });
        #[cfg(feature = "f64")]
        {
            // Far away, where f32 holds none of it, and posed back by half the way.
            let far = [0; 3].map(|_| i64::from(rng.random_range(-2..=2)) << 42);
            let to_f64 = |p: Lattice, times: i64| [0, 1, 2].map(|k| (p[k] + times * far[k]) as f64);
            let positions = lattice.map(|of| of.iter().map(|&p| to_f64(p, 1)).collect::<Vec<_>>());
            let mut shadows = positions.each_ref().map(|of| vec![[0.0; 3]; of.len()]);
            let [shadow_a, shadow_b] = &mut shadows;
            let a = Mesh::from_f64(&positions[0], &indices[0], shadow_a).unwrap();
            let b = Mesh::from_f64(&positions[1], &indices[1], shadow_b).unwrap();
            let turned = [0, 1, 2].map(|i| (0..3).map(|k| i64::from(rows[i][k]) * far[k]).sum());
            let mut back = crate::Pose64::from(pose);
            for i in 0..3 {
                let turned: i64 = turned[i];
                back.rows[i][3] = (by[i] + 2 * far[i] - turned) as f64;
            }
            with_bvh(a, |a| {
                with_bvh(b, |b| {
                    let forth = crate::Pose64::from_translation(far.map(|x| x as f64));
                    let sides = [PosedBvh::in_f64(a, &forth), PosedBvh::in_f64(b, &back)];
                    let sides = sides.map(Result::unwrap);
                    for &ends in &segments {
                        let [from, to] = ends.map(|p| to_f64(p, 2));
                        hits += check(Segment::new(from, to).unwrap(), &sides, &truth(ends));
                    }
                });
            });
        }
    }
    std::println!("{hits} hits");
    assert!(cfg!(miri) || hits > 40_000, "{hits}");
}

/// Two planes that a long segment passes so close to one another that f64 holds both parameters as one number.
#[test]
fn the_first_of_two_is_found_where_f64_sees_one() {
    let near = f32::from_bits(1);
    let wall = |x: f32| [[x, -1.0, -1.0], [x, 3.0, -1.0], [x, -1.0, 3.0]];
    for [first, second] in [[0.0, near], [near, 0.0]] {
        let positions = [wall(first), wall(second), wall(0.5)];
        let mesh = Mesh::new(positions.as_flattened(), &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap();
        with_bvh(mesh, |bvh| {
            let posed = PosedBvh::new(bvh, &Pose::IDENTITY).unwrap();
            for from in [-1.0_f32, 1.0] {
                let segment = Segment::new([from, 0.0, 0.0], [-from, 0.0, 0.0]).unwrap();
                let (_, hit) = segment.first([posed]).unwrap();
                let expected = if from < 0.0 { u32::from(first > second) } else { 2 };
                assert_eq!(hit.triangle, expected);
                // The same triangle in a second mesh is not before it.
                assert_eq!(segment.first([posed; 2]), Some((0, hit)));
            }
            let back = Segment::new([0.25, 0.0, 0.0], [-1.0, 0.0, 0.0]).unwrap();
            let (_, hit) = back.first([posed]).unwrap();
            assert_eq!(hit.triangle, u32::from(second > first));
        });
    }
}

#[test]
fn segments_that_are_none_are_refused() {
    for (x, error) in [
        (f64::NAN, MeshError::NonFinite { vertex: 1 }),
        (f64::NEG_INFINITY, MeshError::NonFinite { vertex: 1 }),
        (1e38, MeshError::Range { vertex: 1 }),
    ] {
        assert_eq!(Segment::new([0.0; 3], [0.0, x, 0.0]), Err(error));
    }
    assert_eq!(Segment::new([0; 3], [1.0; 3]).unwrap().points(), [[0.0; 3], [1.0; 3]]);
}

/// Boxes pass over no triangle, however large or small coordinates are and whatever a pose rounds: segments through points near
/// triangles, against each triangle.
#[test]
fn boxes_pass_over_no_triangle() {
    let (mut rng, mut hits) = (seeded(50), 0);
    for round in 0..if cfg!(miri) { 2 } else { 400 } {
        let scale = [1.0, 1e-44, 1e-30, 1e30, 1e7][round % 5];
        let far = [0.0, 3.0, 1e4][round % 3] * scale;
        let mut near = |size: f32| [0; 3].map(|_| far + size * scale * rng.random_range(-1.0..1.0));
        let mut positions = Vec::new();
        for _ in 0..60 {
            let middle = near(1.0);
            positions.extend([0; 3].map(|_| {
                let offset = near(0.2);
                [0, 1, 2].map(|k| middle[k] + (offset[k] - far))
            }));
        }
        let indices: Vec<_> = (0..60).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let turned = Pose::new([
            [0.6, -0.8, 0.0, far],
            [0.48, 0.36, 0.8, -far],
            [-0.64, -0.48, 0.6, 0.5 * far],
        ]);
        with_bvh(Mesh::new(&positions, &indices).unwrap(), |bvh| {
            let mut sides = vec![PosedBvh::new(bvh, &Pose::IDENTITY).unwrap()];
            sides.push(PosedBvh::new(bvh, &turned).unwrap());
            #[cfg(feature = "f64")]
            sides.push(PosedBvh::in_f64(bvh, &turned.into()).unwrap());
            for posed in &sides {
                for _ in 0..40 {
                    // Points of two triangles: corners, middles of edges, and others.
                    let mut point = || {
                        let [a, b, c] = posed.corners(rng.random_range(0..60));
                        let weights = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.3, 0.3, 0.4]];
                        let [u, v, w] = weights[rng.random_range(0..3)];
                        [0, 1, 2].map(|k| u * a[k] + v * b[k] + w * c[k])
                    };
                    let (p, mut q) = (point(), point());
                    if rng.random_range(0..4) == 0 {
                        q = [0, 1, 2].map(|k| p[k] + 1e3 * (q[k] - p[k]));
                    }
                    let segment = Segment::new(p, q).unwrap();
                    let meets = |t: &u32| intersects_in_f64(&posed.corners(*t), &[p, q, q]);
                    let truth: Vec<_> = (0..60).filter(meets).collect();
                    let mut found = Vec::new();
                    let _ = segment.visit(posed, |hit| {
                        found.push((hit.triangle, hit.at));
                        ControlFlow::Continue(())
                    });
                    found.sort_unstable_by_key(|hit| hit.0);
                    assert!(found.iter().map(|hit| hit.0).eq(truth.iter().copied()), "{segment:?}");
                    let least = found.iter().map(|hit| hit.1).fold(f64::INFINITY, f64::min);
                    let first = segment.first([*posed]);
                    assert_eq!(first.is_some(), !found.is_empty());
                    assert!(first.is_none_or(|(_, hit)| hit.at <= least + CLOSE), "{segment:?}");
                    hits += found.len();
                }
            }
        });
    }
    std::println!("{hits} hits");
    assert!(cfg!(miri) || hits > 40_000, "{hits}");
}
