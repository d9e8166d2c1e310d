//! Relations of solids that are sets of cells, which tell the truth.

extern crate std;

use super::*;
use crate::bvh::{BuildOptions, BvhStorage, morton, node_bound};
use crate::bvtt::PosedBvh;
use crate::{Bvh, Mesh, MeshError, Node, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{ChaCha8Rng, RngExt, seeded, seq::SliceRandom};
use pfront_testkit::solids::{Truth, is_inside, map, mapped, pair, truth};
use std::vec;

mod surface;

/// How many pairs a test asks about: `PFRONT_RELATION_PAIRS` of them, or few.
fn rounds(few: usize) -> usize {
    if cfg!(miri) { 3 } else { asked("PFRONT_RELATION_PAIRS").unwrap_or(few) }
}

fn asked(variable: &str) -> Option<usize> {
    std::env::var(variable).ok()?.parse().ok()
}

/// Random numbers, others for each `PFRONT_RELATION_PART`, so that several runs share many pairs.
fn numbers(seed: u64) -> ChaCha8Rng {
    seeded(seed + 1_000 * asked("PFRONT_RELATION_PART").unwrap_or(0) as u64)
}

/// Calls `then` with the BVH of a mesh.
fn with_bvh<R>(mesh: Mesh<'_>, then: impl FnOnce(Bvh<'_>) -> R) -> R {
    let n = mesh.triangles().len();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    then(morton(mesh, &BuildOptions::default(), storage, &mut vec![0; 2 * n]).unwrap())
}

/// Calls `then` with the solid of a mesh.
fn with_solid<R>(mesh: Mesh<'_>, then: impl FnOnce(Result<Solid<'_>, NotSolid>) -> R) -> R {
    let n = mesh.triangles().len();
    let mut words = vec![0; solid_bound(mesh.vertex_count(), n)];
    let mut scratch = vec![0; solid_scratch_bound(mesh.vertex_count(), n)];
    with_bvh(mesh, |bvh| then(Solid::new(bvh, &mut words, &mut scratch)))
}

fn mesh(data: &MeshData) -> Mesh<'_> {
    Mesh::new(&data.positions, &data.triangles).unwrap()
}

/// The relation of two meshes, pairs taken in pages by several workers.
fn between(a: &MeshData, b: &MeshData, pose: Pose) -> Between {
    with_solid(mesh(a), |a| {
        with_solid(mesh(b), |b| {
            let query = RelationQuery::new(&a.unwrap(), &b.unwrap(), pose).unwrap();
            let mut lines = vec![0; seen_bound(query.patches())];
            let found = query.relation(&mut lines).unwrap();
            assert_eq!(by_workers(&query).relation, found.relation);
            found
        })
    })
}

/// The same by two workers who see every other pair, and stop at nothing.
fn by_workers(query: &RelationQuery<'_>) -> Between {
    let words = seen_bound(query.patches());
    let (mut own, mut others) = (vec![0; words], vec![0; words]);
    let mut seen = [&mut own, &mut others].map(|lines| Seen::new(query, lines).unwrap());
    let (mut turn, mut cursor) = (0, crate::bvtt::Query::start(query.pairs()));
    let _ = crate::bvtt::Query::visit(query.pairs(), &mut cursor, |pair| {
        turn = 1 - turn;
        let _ = query.add(&mut seen[turn], pair);
        core::ops::ControlFlow::Continue(())
    });
    let [mut seen, other] = seen;
    seen.join(&other);
    query.conclude(seen)
}

/// A pair of solids as meshes, and the truth about them.
fn lattice_pair(rng: &mut ChaCha8Rng) -> ([MeshData; 2], Truth) {
    let solids = pair(rng);
    let (rows, _) = map(rng);
    let is_flipped = rng.random_range(0..4) == 0;
    let meshes = solids.each_ref().map(|solid| {
        let is_soup = rng.random_range(0..4) == 0;
        let mut mesh = solid.mesh(is_soup, rng).map(|p| mapped(&rows, p));
        if is_flipped {
            let flip = |t: &mut [u32; 3]| {
                if rng.random_range(0..3) == 0 {
                    t.swap(1, 2);
                }
            };
            mesh.triangles.iter_mut().for_each(flip);
        }
        mesh.triangles.shuffle(rng);
        mesh.triangles.iter_mut().for_each(|t| t.rotate_left(rng.random_range(0..3)));
        mesh
    });
    let [a, b] = solids.each_ref().map(|solid| solid.cells());
    (meshes, truth(&a, &b))
}

#[test]
fn relations_of_lattice_solids_are_those_of_their_cells() {
    let mut rng = numbers(44);
    let mut counts = std::collections::BTreeMap::new();
    for round in 0..rounds(1_500) {
        let ([a, b], truth) = lattice_pair(&mut rng);
        let found = between(&a, &b, Pose::IDENTITY);
        let word = found.relation.map(Relation::as_str);
        assert_eq!((word, found.meets), (Some(truth.word), truth.meets), "{round} {a:?} {b:?}");
        *counts.entry(truth.word).or_insert(0) += 1;
        if round % 3 == 0 {
            let swapped = between(&b, &a, Pose::IDENTITY).relation.map(Relation::swapped);
            assert_eq!(swapped, found.relation, "{round}");
        }
    }
    std::println!("{counts:?}");
    assert!(cfg!(miri) || counts.len() == 6 && counts.values().all(|&n| n > 30), "{counts:?}");
}

/// Where positions are moved without rounding, and where they are rounded: the relation is that of the posed positions.
#[test]
fn posed_solids_are_solids_of_posed_positions() {
    let mut rng = numbers(45);
    let (mut known, mut rounded) = (0, 0);
    for round in 0..rounds(600) {
        let ([a, b], _) = lattice_pair(&mut rng);
        let by = [0; 3].map(|_| rng.random_range(-9..=9) as f32);
        let mut pose = Pose::from_translation(by);
        if round % 2 == 0 {
            let turn = [0; 4].map(|_| rng.random_range(-1.0..1.0_f32));
            let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
            pose = Pose::from_rotation_translation(turn.map(|x| x / length), by);
        }
        let posed = b.clone().map(|p| pose.apply(p));
        let is_solid =
            with_solid(mesh(&posed), |solid| solid.is_ok_and(|s| s.marked_pair().is_none()));
        if !is_solid {
            continue;
        }
        let expected = between(&a, &posed, Pose::IDENTITY);
        assert!(expected.relation.is_some());
        let found = between(&a, &b, pose);
        let is_open = found.relation.is_none() && round % 2 == 0;
        assert!(found.relation == expected.relation || is_open, "{found:?} {expected:?}");
        (known, rounded) = (known + usize::from(!is_open), rounded + usize::from(is_open));
    }
    std::println!("{known} {rounded}");
    assert!(cfg!(miri) || known > 20 * rounded, "{known} {rounded}");
}

#[cfg(feature = "f64")]
#[test]
fn relations_in_f64_are_those_of_the_cells() {
    let mut rng = numbers(46);
    for _ in 0..rounds(400) {
        let ([a, b], truth) = lattice_pair(&mut rng);
        // Coordinates that f32 does not hold.
        let positions = [&a, &b].map(|mesh| {
            let wide = |p: &[f32; 3]| p.map(|x| f64::from(x) + 1_073_741_824.5);
            mesh.positions.iter().map(wide).collect::<vec::Vec<_>>()
        });
        let mut shadows = positions.each_ref().map(|positions| vec![[0.0; 3]; positions.len()]);
        let [own, other] = &mut shadows;
        let own = Mesh::from_f64(&positions[0], &a.triangles, own).unwrap();
        let other = Mesh::from_f64(&positions[1], &b.triangles, other).unwrap();
        with_solid(own, |a| {
            with_solid(other, |b| {
                let query = RelationQuery::new(&a.unwrap(), &b.unwrap(), Pose::IDENTITY).unwrap();
                let found = query.relation(&mut vec![0; seen_bound(query.patches())]).unwrap();
                assert_eq!(found.relation.map(Relation::as_str), Some(truth.word));
                assert_eq!(found.meets, truth.meets);
            });
        });
    }
}

/// The mesh of several.
fn union(meshes: &[MeshData]) -> MeshData {
    pfront_testkit::shapes::union(meshes)
}

fn cube(from: f32, to: f32) -> MeshData {
    let blocks =
        pfront_testkit::solids::Blocks { size: [1; 3], offset: [0; 3], blocks: [[0; 3]].into() };
    blocks.mesh(false, &mut seeded(1)).map(|p| p.map(|x| from + x * (to - from)))
}

fn refused(mesh_data: &MeshData) -> Option<NotSolid> {
    with_solid(mesh(mesh_data), |solid| solid.err())
}

#[test]
fn what_is_no_solid_is_refused_with_its_place() {
    let mut open = cube(0.0, 1.0);
    open.triangles.pop();
    assert!(matches!(refused(&open), Some(NotSolid::OpenEdge { .. })));
    let mut flat = cube(0.0, 1.0);
    flat.triangles.truncate(1);
    let [p, q, r] = flat.triangles[0];
    flat.triangles.push([q, p, r]);
    let pair = crate::bvtt::TrianglePair { a: 0, b: 1 };
    assert_eq!(refused(&flat), Some(NotSolid::MeetsItself { pair }));
    assert_eq!(refused(&MeshData::default()), Some(NotSolid::NoVolume));
    assert_eq!(refused(&cube(0.0, 1.0)), None);
}

/// Bodies of one mesh that cross each other: what hangs on where they do is undetermined, and nothing else.
#[test]
fn what_hangs_on_marked_triangles_is_undetermined() {
    // Two cubes that cross, with a third apart from both.
    let tangled = union(&[cube(0.0, 2.0), cube(1.0, 3.0), cube(10.0, 12.0)]);
    let relation = |b: &MeshData| between(&tangled, b, Pose::IDENTITY);
    let of = |low, high| relation(&cube(low, high)).relation;
    assert_eq!(of(20.0, 21.0), Some(Relation::Apart));
    assert_eq!(of(11.0, 13.0), Some(Relation::Crossing), "with the third");
    assert_eq!(of(2.5, 4.0), Some(Relation::Crossing), "by a triangle that meets no other");
    let hung = relation(&cube(1.0, 1.5));
    assert!(hung.relation.is_none() && hung.pair.is_some(), "{hung:?}");
    assert_eq!(of(10.5, 11.5), Some(Relation::BInA));
    // Whether all of it is inside needs no more than that none of it is seen outside.
    assert_eq!(of(-1.0, 20.0), Some(Relation::AInB));
}

/// The inner of two nested bodies that face the same way bounds nothing.
#[test]
fn nested_bodies_of_one_mesh_are_one() {
    let nested = union(&[cube(0.0, 4.0), cube(1.0, 3.0)]);
    let found = between(&nested, &cube(0.0, 4.0), Pose::IDENTITY);
    assert_eq!(found.relation, Some(Relation::Equal));
    let through = between(&nested, &cube(2.0, 3.5), Pose::IDENTITY);
    assert_eq!((through.relation, through.meets), (Some(Relation::BInA), true));
    let mut hollow = nested;
    hollow.triangles[12..].iter_mut().for_each(|t| t.swap(0, 1));
    let found = between(&hollow, &cube(1.5, 2.5), Pose::IDENTITY);
    assert_eq!(found.relation, Some(Relation::Apart), "in the cavity");
}

/// The common volume of two meshes.
fn overlap(a: &MeshData, b: &MeshData, pose: Pose) -> Result<[f64; 2], NotSolid> {
    with_solid(mesh(a), |a| {
        with_solid(mesh(b), |b| {
            let query = RelationQuery::new(&a.unwrap(), &b.unwrap(), pose).unwrap();
            overlap_of(&query)
        })
    })
}

fn overlap_of(query: &RelationQuery<'_>) -> Result<[f64; 2], NotSolid> {
    let (mut overlap, mut cursor) = (Overlap::new(query), crate::bvtt::Query::start(query.pairs()));
    let _ = crate::bvtt::Query::visit(query.pairs(), &mut cursor, |pair| {
        overlap.add(pair);
        core::ops::ControlFlow::Continue(())
    });
    overlap.conclude()
}

#[test]
fn the_volume_of_lattice_solids_is_that_of_their_cells() {
    let mut rng = numbers(50);
    for round in 0..rounds(2_000) {
        let solids = pair(&mut rng);
        let (rows, scale) = map(&mut rng);
        let is_flipped = rng.random_range(0..8) == 0;
        let [a, b] = solids.each_ref().map(|solid| {
            let is_soup = rng.random_range(0..4) == 0;
            let mut mesh = solid.mesh(is_soup, &mut rng).map(|p| mapped(&rows, p));
            if is_flipped {
                mesh.triangles.iter_mut().filter(|t| t[0] % 3 == 0).for_each(|t| t.swap(1, 2));
            }
            mesh
        });
        let [own, other] = solids.each_ref().map(|solid| solid.cells());
        let truth = (truth(&own, &other).volume * scale as usize) as f64;
        let [low, high] = overlap(&a, &b, Pose::IDENTITY).unwrap();
        assert!(low <= truth && truth <= high, "{round}: {truth} {low} {high}");
        let reach = a.positions.iter().flatten().fold(1.0_f32, |most, x| most.max(x.abs()));
        assert!(high - low < 1e-10 * f64::from(reach).powi(3), "{round}: {truth} {low} {high}");
    }
}

/// In a pose that rounds, mirrors or scales, the interval has a number in common with that of the posed mesh, and is no wider than
/// rounding makes it.
#[test]
fn volumes_of_posed_solids_are_those_of_their_posed_meshes() {
    let mut rng = numbers(53);
    let mut wide = 0;
    for round in 0..rounds(500) {
        let [a, b] = pair(&mut rng).map(|solid| solid.mesh(false, &mut rng));
        let (s, c) = if round % 3 == 0 { (1.0, 0.0) } else { (0.6, 0.8) };
        let flip = if round % 2 == 0 { 1.0 } else { -1.5 };
        let by = [0; 3].map(|_| rng.random_range(-2..=2) as f32 * 0.5);
        let rows = [[c, -s, 0.0, by[0]], [s, c, 0.0, by[1]], [0.0, 0.0, flip, by[2]]];
        let pose = Pose::new(rows);
        let posed = b.clone().map(|p| pose.apply(p));
        // Rounding can make a posed mesh meet itself.
        let Ok(expected) = with_solid(mesh(&posed), |solid| match solid {
            Ok(solid) if solid.marked_pair().is_none() => Ok(()),
            _ => Err(()),
        })
        .map(|()| overlap(&a, &posed, Pose::IDENTITY).unwrap()) else {
            continue;
        };
        let found = overlap(&a, &b, pose).unwrap();
        assert!(
            found[0] <= expected[1] && expected[0] <= found[1],
            "{round} {found:?} {expected:?}"
        );
        assert!(found[1] - found[0] < 10.0, "{round} {found:?}");
        wide += u32::from(found[1] - found[0] > 1e-9);
        #[cfg(feature = "f64")]
        with_solid(mesh(&a), |a| {
            with_solid(mesh(&b), |b| {
                let (a, b) = (a.unwrap(), b.unwrap());
                let query = crate::bvtt::PairBvtt::in_f64(a.bvh(), b.bvh(), &pose.into()).unwrap();
                let found = overlap_of(&RelationQuery::of_pair(query, &a, &b)).unwrap();
                let near = |x: f64, y: f64| (x - y).abs() < 1e-4;
                assert!(found[1] - found[0] < 1e-7, "{round} {found:?}");
                assert!(near(found[0], expected[0]), "{round} {found:?} {expected:?}");
            });
        });
    }
    assert!(wide > 0, "some poses round");
}

/// Triangles that meet their own mesh matter to a volume only inside the other solid and on its surface.
#[test]
fn volumes_need_no_triangle_elsewhere() {
    let apart = union(&[cube(0.0, 4.0), cube(10.0, 12.0), cube(11.0, 13.0)]);
    let [low, high] = overlap(&apart, &cube(3.0, 5.0), Pose::IDENTITY).unwrap();
    assert!(low <= 1.0 && 1.0 <= high && high - low < 1e-9, "{low} {high}");
    for at in [9.0, 11.5] {
        let found = overlap(&apart, &cube(at, at + 7.0), Pose::IDENTITY);
        assert!(matches!(found, Err(NotSolid::MeetsItself { .. })), "{found:?}");
    }
    let [low, high] = overlap(&apart, &cube(10.25, 10.5), Pose::IDENTITY).unwrap();
    assert!(low <= 0.015_625 && 0.015_625 <= high && high - low < 1e-9, "{low} {high}");
}

/// A mesh of corners and triangles.
fn made(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> MeshData {
    MeshData { positions: positions.to_vec(), triangles: triangles.to_vec() }
}

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// Where a body inside shares an edge with that around it, triangles that bound nothing have the steps along the edge.
#[test]
fn bodies_that_bound_nothing_add_no_volume() {
    let fin = made(
        &[[0.0; 3], [4.0, 0.0, 0.0], [2.0, 1.0, 2.0], [2.0, 2.0, 1.0]],
        &TETRAHEDRON.map(|[p, q, r]| [p, r, q]),
    );
    // Turned the other way it is a cavity.
    for (fin, truth) in [(fin.clone(), 1.0), (made(&fin.positions, &TETRAHEDRON), 0.875)] {
        let both = union(&[fin, cube(0.0, 4.0)]);
        with_solid(mesh(&both), |solid| assert!(solid.unwrap().marked_pair().is_none()));
        let [low, high] = overlap(&both, &cube(-1.0, 1.0), Pose::IDENTITY).unwrap();
        assert!(low <= truth && truth <= high && high - low < 1e-9, "{low} {high}");
    }
}

/// A triangle from which rounding has taken its area tells nothing.
#[test]
fn a_ray_needs_an_area() {
    let mut b = cube(0.0, 1.0);
    // One corner is cut off by 2^-24.
    let small = 2.0_f32.powi(-24);
    let first = b.triangles[0];
    let at = |k: usize| b.positions[first[k] as usize];
    let towards = |p: [f32; 3], q: [f32; 3]| [0, 1, 2].map(|k| p[k] + (q[k] - p[k]) * small);
    let (near, nearer) = (towards(at(0), at(1)), towards(at(0), at(2)));
    let [v, w] = [b.positions.len() as u32, b.positions.len() as u32 + 1];
    b.positions.extend([near, nearer]);
    let [p, q, r] = first;
    let whole = b.triangles.len();
    b.triangles[0] = [p, v, w];
    b.triangles.extend([[v, q, w], [w, q, r]]);
    // The neighbours at the two edges get the new corners too.
    for triangle in 1..whole {
        for (from, to, new) in [(p, q, v), (r, p, w)] {
            let t = b.triangles[triangle];
            if let Some(k) = (0..3).find(|&k| t[k] == to && t[(k + 1) % 3] == from) {
                let last = t[(k + 2) % 3];
                b.triangles[triangle] = [to, new, last];
                b.triangles.push([new, from, last]);
            }
        }
    }
    let a = made(
        &cube(0.0, 1.0)
            .positions
            .iter()
            .map(|p| [1000.0 + 20.0 * p[0], 20.0 * p[1] - 10.0, 20.0 * p[2] - 10.0])
            .collect::<vec::Vec<_>>(),
        &cube(0.0, 1.0).triangles,
    );
    with_solid(mesh(&b), |solid| assert!(solid.unwrap().marked_pair().is_none()));
    let found = between(&a, &b, Pose::from_translation([1004.0, 5.0, 5.0]));
    assert!(found.relation.is_none() && found.is_rounded, "{found:?}");
}

/// Points at the middles, faces, edges and corners of cells, of one solid and of two in one mesh, which may overlap: united, or, where triangles
/// are flipped, each where the other is not.
#[test]
fn points_of_lattice_solids_are_where_their_cells_are() {
    let (mut rng, mut counts) = (seeded(46), std::collections::BTreeMap::new());
    for round in 0..rounds(400) {
        let solids = pair(&mut rng);
        let cells = solids.each_ref().map(|solid| solid.cells());
        let (rows, _) = map(&mut rng);
        let mut both = solids[0].mesh(false, &mut rng);
        if round % 2 == 0 {
            let (other, first) = (solids[1].mesh(round % 3 == 0, &mut rng), both.positions.len());
            both.positions.extend(other.positions);
            both.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first as u32)));
        }
        if round % 5 == 0 {
            both.triangles.iter_mut().step_by(3).for_each(|t| t.swap(1, 2));
        }
        both.triangles.shuffle(&mut rng);
        let both = both.map(|p| mapped(&rows, p));
        let points = [0; 60].map(|_| [0; 3].map(|_| rng.random_range(-8..=22)));
        let at = points.map(|p| mapped(&rows, p.map(|x| x as f32)).map(|x| x * 0.5));
        let truth = |rule: Rule, doubled| {
            let own = is_inside(&cells[0], doubled)?;
            let other = if round % 2 == 0 { is_inside(&cells[1], doubled)? } else { false };
            Some(if rule == Rule::NonZero { own || other } else { own != other })
        };
        let mut check = |posed: PosedBvh<'_>, by: [f64; 3]| {
            let mesh = posed.bvh.mesh();
            let words = 2 * mesh.vertex_count() + 6 * mesh.triangles().len();
            let rule = Rule::of(mesh, &mut vec![0; words]).unwrap();
            for (doubled, at) in points.iter().zip(at) {
                let moved = [0, 1, 2].map(|k| f64::from(at[k]) + by[k]);
                let expected = match truth(rule, *doubled) {
                    None => Location::Surface,
                    Some(true) => Location::Inside,
                    Some(false) => Location::Outside,
                };
                let found = rule.inside(&posed, moved).unwrap();
                assert_eq!(found, expected, "{round} {rule:?} {doubled:?} {both:?}");
                *counts.entry(std::format!("{rule:?} {found:?}")).or_insert(0) += 1;
            }
        };
        with_bvh(mesh(&both), |bvh| {
            check(PosedBvh::new_unchecked(bvh, &Pose::IDENTITY), [0.0; 3]);
            let by = [0; 3].map(|_| rng.random_range(-99..=99) as f32);
            check(PosedBvh::new(bvh, &Pose::from_translation(by)).unwrap(), by.map(f64::from));
            with_solid(mesh(&both), |solid| {
                let Ok(solid) = solid else { return };
                for (doubled, at) in points.iter().zip(at) {
                    let found = solid.inside(at).unwrap();
                    assert_eq!(found == Location::Surface, truth(solid.rule(), *doubled).is_none());
                }
            });
        });
        #[cfg(feature = "f64")]
        {
            let by = [0; 3].map(|_| f64::from(rng.random_range(-3..=3)) * 2f64.powi(41));
            let far = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) + by[k]);
            let positions: vec::Vec<_> = both.positions.iter().map(far).collect();
            let mut shadow = vec![[0.0; 3]; positions.len()];
            let mesh = Mesh::from_f64(&positions, &both.triangles, &mut shadow).unwrap();
            with_bvh(mesh, |bvh| {
                check(PosedBvh::new_unchecked(bvh, &Pose::IDENTITY), by);
                let back = crate::Pose64::from_translation(by.map(|x| -x));
                check(PosedBvh::in_f64(bvh, &back).unwrap(), [0.0; 3]);
            });
        }
    }
    std::println!("{counts:?}");
    assert!(cfg!(miri) || counts.len() == 6 && counts.values().all(|&n| n > 300), "{counts:?}");
}

#[test]
fn points_that_are_none_are_refused() {
    let data = pair(&mut seeded(1))[0].mesh(false, &mut seeded(2));
    with_solid(mesh(&data), |solid| {
        let solid = solid.unwrap();
        for x in [f32::NAN, f32::INFINITY] {
            assert_eq!(solid.inside([0.0, x, 0.0]), Err(MeshError::NonFinite { vertex: 0 }));
        }
        assert_eq!(solid.inside([0.0, 0.0, -1e38]), Err(MeshError::Range { vertex: 0 }));
        assert_eq!(solid.inside([99, 99, 99]), Ok(Location::Outside));
    });
}
