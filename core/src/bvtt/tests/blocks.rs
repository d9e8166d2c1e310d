//! Blocks against the same tests triangle by triangle, in the widest vectors, in portable ones and with one lane.

use super::super::PosedBvh;
use super::super::block::BlockCache;
use super::super::cull::PairSets;
use super::super::trees::Shared;
use crate::exact::difference;
use crate::exact::orientation::sides;
use crate::one_ring::{OneRing, OneRings, history_bound, link_scratch_bound};
use crate::simd::{LANES, Portable, Simd, Task, widest};
use crate::triangle::{Adjacency, intersects, intersects_in_mesh};
use crate::{Aabb, Bvh, Mesh, Node, Triangle};
use glam::Vec3A;
use pfront_testkit::rng::{RngExt, seeded};

const VERTICES: usize = 9;

/// Two leaves of a mesh against each other.
struct Two<'m> {
    mesh: Mesh<'m>,
    leaves: [&'m [u32]; 2],
    rings: &'m [OneRing],
    /// How far differences of coordinates may be off in `apart`.
    error: Option<Vec3A>,
}

/// The pairs found: by boxes, with the shared-index rule and without it.
#[derive(Debug, PartialEq)]
struct Found {
    boxes: u64,
    in_mesh: PairSets,
    apart: PairSets,
}

impl Task for Two<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self) -> Found {
        let Self { mesh, leaves, rings, error } = self;
        let nodes = leaves.map(|triangles| {
            let boxes = triangles.iter().map(|t| Aabb::of(&mesh.shadow_triangle(*t)));
            let Aabb { min, max } = boxes.fold(Aabb::EMPTY, |x, y| x.union(&y));
            [Node { min, first: 0, max, count: triangles.len() as u32 }]
        });
        let [first, second] = [0, 1].map(|side: usize| PosedBvh {
            bvh: Bvh::new_unchecked(mesh, &nodes[side], leaves[side]),
            pose_f64: None,
            pose: None,
        });
        let mut caches = [BlockCache::new(), BlockCache::new()];
        let [a, b] = &mut caches;
        let shared = Shared { none_is_hit: false, rings };
        let a = a.get::<S, true>(0, &first, shared);
        let b = b.get::<S, true>(0, &second, shared);
        Found {
            boxes: a.cull::<S, true>(b, u64::MAX, true, None).open,
            in_mesh: a.cull::<S, true>(b, u64::MAX, false, None),
            apart: a.cull::<S, false>(b, u64::MAX, false, error),
        }
    }
}

/// Small whole coordinates, mostly, on which planes and corners coincide.
fn random_mesh(next: &mut impl FnMut(u32) -> u32) -> ([[f32; 3]; VERTICES], [[u32; 3]; 2 * LANES]) {
    let scale = [1.0, 1.0, 0.1, 1e-12, 1e-36, 1e11, 1e13, 3e35][next(8) as usize];
    let offset = [0.0, 0.0, 1e3, 3e7][next(4) as usize] * f32::min(scale, 1e20);
    // On grids on which f32 makes no error, at their limits and beyond.
    let cells = [4, 4, 128, 1_000][next(4) as usize];
    let mut positions = [[0.0; 3]; VERTICES];
    for x in positions.as_flattened_mut() {
        let nudge = [0.0, 0.0, 1e-7, 1e-3][next(4) as usize] * next(3) as f32;
        *x = (next(cells) as f32 + nudge) * scale + offset;
    }
    let mut triangles = [[0; 3]; 2 * LANES];
    for t in &mut triangles {
        // Neighbours of a ring, mostly.
        let i = next(VERTICES as u32 - 1);
        *t = [0, i + 1, (i + 1) % (VERTICES as u32 - 1) + 1];
        if next(4) == 0 {
            *t = [next(VERTICES as u32), next(VERTICES as u32), next(VERTICES as u32)];
        }
    }
    (positions, triangles)
}

#[test]
fn side_by_side_as_one_by_one() {
    let mut rng = seeded(11);
    let mut next = move |below: u32| rng.random_range(0..below);
    let (mut by_planes, mut by_certificates, mut kept, mut hits, mut apart, mut on_grid) =
        (0, 0, 0, 0, 0, 0);
    for round in 0..if cfg!(miri) { 4 } else { 20_000 } {
        let (positions, triangles) = random_mesh(&mut next);
        let mut history = [0; history_bound(VERTICES)];
        let mut scratch = [0; link_scratch_bound(VERTICES, 2 * LANES)];
        let mesh =
            Mesh::new(&positions, &triangles[..next(2 * LANES as u32) as usize + 1]).unwrap();
        let triangles = mesh.triangles();
        let mut rings = OneRings::new(VERTICES, triangles, &mut history, &mut scratch).unwrap();
        let certified = rings.certify(mesh, None);
        let n = mesh.triangles().len() as u32;
        let ids: [u32; 2 * LANES] = core::array::from_fn(|i| i as u32 % n);
        let leaves = [&ids[..next(8) as usize + 1], &ids[8..][..next(8) as usize + 1]];
        let rings = if round % 3 == 0 { &[] } else { certified.of_mesh(mesh) };
        let two = || Two { mesh, leaves, rings, error: None };
        let found = widest(two());
        assert_eq!(found, two().run::<Portable>());
        // One lane alone leaves what planes do not separate to the exact test.
        let single = two().run::<f32>();
        assert_eq!(single.boxes, found.boxes);
        for (one, many) in [(single.in_mesh, found.in_mesh), (single.apart, found.apart)] {
            assert_eq!([one.overlapping, one.hits], [many.overlapping, 0]);
            assert_eq!(one.open & (many.hits | many.open), many.hits | many.open);
        }
        for (j, &tb) in leaves[1].iter().enumerate() {
            for (i, &ta) in leaves[0].iter().enumerate() {
                let is = |pairs: u64| pairs >> (LANES * j + i) & 1 != 0;
                let [a, b] = [ta, tb].map(|t| mesh.shadow_triangle(t));
                assert_eq!(is(found.boxes), Aabb::of(&a).overlaps(&Aabb::of(&b)));
                assert_eq!([found.in_mesh.overlapping, found.apart.overlapping], [found.boxes; 2]);
                if !is(found.boxes) {
                    continue;
                }
                let meet = intersects(&a, &b);
                assert!(is(found.apart.open) || is(found.apart.hits) == meet);
                hits += u32::from(is(found.apart.hits));
                let is_known = !is(found.apart.open);
                apart += u32::from(is(single.apart.open) && is_known && !meet);
                // No error bound certifies that a determinant is zero.
                let has_zero = sides(a.each_ref(), b.each_ref()).contains(&0);
                on_grid += u32::from(is(found.apart.hits) && has_zero);
                let separated = clearly_separated(&a, &b, &[]) || clearly_separated(&b, &a, &[]);
                assert!(!is(found.apart.open) || !separated);
                if ta == tb {
                    continue;
                }
                let collide = intersects_in_mesh(mesh, ta, tb, Adjacency::SharedIndexRule);
                let is_known = !is(found.in_mesh.open);
                assert!(!is_known || is(found.in_mesh.hits) == collide, "{ta} and {tb}");
                let [t, u] = [ta, tb].map(|t| mesh.triangles()[t as usize]);
                let shared = t.iter().any(|v| u.contains(v));
                let certificate = t.iter().any(|v| {
                    u.contains(v) && rings.get(*v as usize).is_some_and(|r| r.is_certified())
                });
                let separated = clearly_separated(&a, &b, &u.map(|v| t.contains(&v)))
                    || clearly_separated(&b, &a, &t.map(|v| u.contains(&v)));
                assert!(!is(found.in_mesh.open) || !certificate && !separated);
                assert!(!is(found.in_mesh.open) || !shared || is(found.in_mesh.may_share_vertex));
                by_planes += u32::from(shared && separated && !certificate);
                by_certificates += u32::from(certificate && !separated);
                kept += u32::from(is(found.in_mesh.open) && shared && !collide);
            }
        }
    }
    // The few rounds under miri need not have all of them.
    let least = if cfg!(miri) { 0 } else { 500 };
    let counts = [by_planes, by_certificates, kept, hits, apart, on_grid];
    assert!(counts.iter().all(|count| *count >= least), "{counts:?}");
}

/// Whether the plane of `a` has all corners of `b` that are not shared on one side, too far away for rounding to matter.
fn clearly_separated(a: &Triangle, b: &Triangle, shared: &[bool]) -> bool {
    let [u, v] = [1, 2].map(|k| difference(&a[k], &a[0]));
    let (mut low, mut high, mut extent) = (f64::INFINITY, f64::NEG_INFINITY, u.abs().max(v.abs()));
    for (k, p) in b.iter().enumerate() {
        let w = difference(p, &a[0]);
        extent = extent.max(w.abs());
        if !shared.get(k).is_some_and(|is_shared| *is_shared) {
            let height = u.cross(v).dot(w);
            (low, high) = (low.min(height), high.max(height));
        }
    }
    let margin = 1e-5 * extent.element_product() + 1e-29;
    low <= high && (low > margin || high < -margin) && extent.max_element() < 1e12
}

/// Corners on planes and as little beside them as a grid allows, on grids that f32 computes on without error and finer ones.
#[test]
#[cfg_attr(miri, ignore = "takes miri too long; the other test runs the same code")]
fn corners_beside_planes_of_a_grid() {
    let mut rng = seeded(12);
    let (mut touching, mut beside, mut open) = (0, 0, 0);
    for _ in 0..50_000 {
        let mut next = |most: i32| rng.random_range(-most..=most);
        let (size, unit) = ([6, 10, 15, 60, 500][(2 + next(2)) as usize], 2f32.powi(20 * next(3)));
        let [a, b, c] = [[0; 3]; 3].map(|p| p.map(|_| next(size)));
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| i64::from(p[k] - a[k])));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        // A point within the triangle, seen from above, and so high that the determinant is as wanted.
        let (wanted, mut tip) = (i64::from(next(2)), None);
        for _ in 0..4 * size {
            let (i, j) = (next(50).abs(), next(50).abs());
            let [x, y] = [0, 1].map(|k| (i64::from(i) * u[k] + i64::from(j) * v[k]) / 100);
            let rest = wanted - n[0] * x - n[1] * y;
            if n[2] != 0 && rest % n[2] == 0 {
                tip = Some([x as i32 + a[0], y as i32 + a[1], (rest / n[2]) as i32 + a[2]]);
            }
        }
        let Some(tip) = tip else { continue };
        let [mut d, e] = [[0; 3]; 2].map(|_| tip.map(|x| x + next(size)));
        if next(1) == 0 {
            // In the plane, beside the triangle.
            d = [0, 1, 2].map(|k| 2 * b[k] - a[k]);
        }
        let positions = [a, b, c, tip, d, e].map(|p| p.map(|x| x as f32 * unit));
        let mesh = Mesh::new(&positions, &[[0, 1, 2], [3, 4, 5]]).unwrap();
        let [a, b] = [0, 1].map(|t| mesh.shadow_triangle(t));
        let found = widest(Two { mesh, leaves: [&[0], &[1]], rings: &[], error: None }).apart;
        let meet = intersects(&a, &b);
        assert!(found.open != 0 || (found.hits != 0) == meet, "{a:?} {b:?}");
        open += found.open;
        if wanted == 0 {
            touching += found.hits;
        } else {
            beside += found.overlapping & !found.open;
        }
    }
    let counts = [touching, beside, open];
    assert!(counts.iter().all(|count| *count >= 500), "{counts:?}");
}

/// Corners that each stand for another one nearby: boxes that are apart by less than the error overlap with one lane as with
/// eight, and no pair is decided otherwise than those other corners are.
#[test]
fn an_error_of_corners_is_allowed_for_in_boxes_and_planes() {
    let mut rng = seeded(13);
    let (mut kept, mut apart, mut hits) = (0, 0, 0);
    for round in 0..if cfg!(miri) { 20 } else { 20_000 } {
        let mut near = |reach: f32| reach * rng.random_range(-1.0..1.0_f32);
        let error = [0; 3].map(|_| near([0.25, 0.01][round % 2]).abs());
        let shadow: [[f32; 3]; 6] = [0; 6].map(|_| [0; 3].map(|_| near(1.0)));
        // A difference is off by both corners, and by the rounding of each.
        let truth = shadow.map(|p| [0, 1, 2].map(|k| p[k] + near(0.499 * error[k])));
        let mesh = Mesh::new(&shadow, &[[0, 1, 2], [3, 4, 5]]).unwrap();
        let error = Some(Vec3A::from_array(error));
        let two = || Two { mesh, leaves: [&[0], &[1]], rings: &[], error };
        let [a, b] = [0, 3].map(|first| [truth[first], truth[first + 1], truth[first + 2]]);
        let (meet, overlap) = (intersects(&a, &b), Aabb::of(&a).overlaps(&Aabb::of(&b)));
        for found in [widest(two()), two().run::<Portable>(), two().run::<f32>()] {
            let PairSets { overlapping, hits: hit, open, .. } = found.apart;
            assert!(overlapping != 0 || !overlap, "{shadow:?} {error:?}");
            assert!(open != 0 || (hit != 0) == meet, "{shadow:?} {error:?}");
            kept += u32::from(overlapping != 0 && found.boxes == 0);
            apart += u32::from(overlapping != 0 && open == 0 && !meet);
            hits += u32::from(hit != 0);
        }
    }
    let counts = [kept, apart, hits];
    assert!(cfg!(miri) || counts.iter().all(|count| *count >= 500), "{counts:?}");
}
