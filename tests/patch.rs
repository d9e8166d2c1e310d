//! Self-collision of small sheets against brute force with the exact oracle: where patch certificates answer.

use pfront::pfront_core::Bvh;
use pfront::pfront_core::bvtt::{Query, SelfBvtt};
use pfront::{Model, SelfQuery, TrianglePair};
use pfront_testkit::oracle::{self_hit, self_pairs};
use pfront_testkit::rng::{ChaCha8Rng, Rng, RngExt, seeded, seq::SliceRandom};
use pfront_testkit::shapes::bumpy;
use std::ops::ControlFlow;

/// The vertices of a sheet of so many quads, flat, rolled up, wound or folded, then disturbed. The last is where the one in
/// the middle of the first row is.
fn bent([width, height]: [u32; 2], rng: &mut impl Rng) -> Vec<[f64; 3]> {
    let kind = rng.random_range(0..5);
    let noise = [0.0, 0.1, 0.4][rng.random_range(0..3)];
    let whole = rng.random_bool(0.4);
    let (turned, turns) = (rng.random_range(0..3), rng.random_range(0.5..1.3));
    let mut points = Vec::new();
    for y in 0..=height {
        for x in 0..=width {
            let [u, v] = [x, y].map(f64::from);
            let along = u / f64::from(width);
            let angle = turns * std::f64::consts::TAU * along;
            let mut p = match kind {
                0 => [u, v, 0.0],
                // A roll, and a ring in one plane, whose ends meet or overlap.
                1 => [2.0 * angle.cos(), v, 2.0 * angle.sin()],
                2 => [(2.0 + v) * angle.cos(), (2.0 + v) * angle.sin(), 0.0],
                // A winding staircase.
                3 => [(2.0 + v) * angle.cos(), (2.0 + v) * angle.sin(), along],
                // A fold.
                _ => [(u - 0.5 * f64::from(width)).abs(), v, 0.1 * along],
            };
            for x in &mut p {
                *x += noise * rng.random_range(-1.0..1.0);
                // On a coarse lattice, much is level, in line and in one plane.
                *x = if whole { (*x * 2.0).round() } else { *x };
            }
            p.rotate_left(turned);
            points.push(p);
        }
    }
    points.push(points[width as usize / 2]);
    points
}

/// Positions in f32.
fn rounded(points: Vec<[f64; 3]>) -> Vec<[f32; 3]> {
    points.into_iter().map(|p| p.map(|x| x as f32)).collect()
}

/// The vertices of a sheet in one plane, whose last column lies on the edges of the first.
fn ring([width, height]: [u32; 2], rng: &mut impl Rng) -> Vec<[f64; 3]> {
    let start = rng.random_range(0.0..std::f64::consts::TAU);
    let (shift, turned) = (rng.random_range(-0.9..0.9), rng.random_range(0..3));
    let mut points = Vec::new();
    for y in 0..=height {
        for x in 0..=width {
            let along = f64::from(x) / f64::from(width);
            let (sin, cos) = (start + std::f64::consts::TAU * along).sin_cos();
            let radius = 2.0 + f64::from(y) + shift * along;
            let mut p = [radius * cos, radius * sin, 0.0];
            p.rotate_left(turned);
            points.push(p);
        }
    }
    points.push(points[width as usize / 2]);
    points
}

/// The triangles of a sheet, in any order, a few of them turned over, missing or there twice; some sheets have a slit.
fn sheet([width, height]: [u32; 2], rng: &mut impl Rng) -> Vec<[u32; 3]> {
    let faults = if rng.random_bool(0.7) { 0.0 } else { 0.05 };
    let has_slit = rng.random_bool(0.3);
    let mut triangles = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let corner = |i: u32, j: u32| (y + j) * (width + 1) + x + i;
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let halves = [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]];
            for mut t in halves[rng.random_range(0..2)] {
                if has_slit && x >= width / 2 {
                    let last = (width + 1) * (height + 1);
                    t = t.map(|vertex| if vertex == width / 2 { last } else { vertex });
                }
                t.rotate_left(rng.random_range(0..3));
                if rng.random_bool(faults) {
                    t.swap(0, 1);
                }
                let times = if rng.random_bool(faults) { rng.random_range(0..3) } else { 1 };
                triangles.extend(std::iter::repeat_n(t, times));
            }
        }
    }
    triangles.shuffle(rng);
    triangles
}

#[test]
fn sheets_of_every_kind() {
    let mut rng = seeded(10);
    let (mut certified, mut patches, mut met) = (0, 0, 0);
    for round in 0..1_000 {
        let size = [rng.random_range(2..10), rng.random_range(1..5)];
        let triangles = sheet(size, &mut rng);
        let mut model = Model::new(rounded(bent(size, &mut rng)), triangles.clone()).unwrap();
        let mut query = SelfQuery::new();
        for time in 0..6 {
            if time % 3 == 0 {
                // Patches are found after some refits.
                let rest = model.mesh().positions().unwrap().to_vec();
                let mut moved = rest.clone();
                for last in (0..10).map(|i| 0.01 * (i % 2) as f32) {
                    moved[0][0] = rest[0][0] + last;
                    model.set_positions(&moved).unwrap();
                }
            }
            let truth = self_pairs(model.mesh().positions().unwrap(), &triangles);
            let truth: Vec<_> = truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect();
            assert_eq!(query.all(&model).unwrap(), truth, "round {round}: {model:?}");
            let of_model = model.patches();
            certified +=
                (0..of_model.count()).filter(|&patch| of_model.is_certified(patch)).count();
            patches += of_model.count();
            met += truth.len();
            // All vertices move, and then one.
            let mut moved = rounded(bent(size, &mut rng));
            if time % 3 == 1 {
                moved.clone_from_slice(model.mesh().positions().unwrap());
                let vertex = rng.random_range(0..moved.len());
                moved[vertex][rng.random_range(0..3)] += rng.random_range(-2.0..2.0);
            }
            model.set_positions(&moved).unwrap();
        }
    }
    let counts = [certified, patches as usize - certified, met];
    assert!(counts.iter().all(|&count| count > 1_000), "{counts:?}");
}

/// Noise below what the shadow resolves decides what meets, and which boundaries touch themselves.
#[test]
fn sheets_in_f64() {
    let mut rng = seeded(11);
    let (mut certified, mut patches, mut met, mut differs) = (0, 0, 0, 0);
    for round in 0..300 {
        let size = [rng.random_range(2..10), rng.random_range(1..5)];
        let mut triangles = sheet(size, &mut rng);
        let noise = [0.0, 1e-12, 1e-7, 1e-5, 1e-4][rng.random_range(0..5)];
        let offset = [0.0, 0.1, 1e5][rng.random_range(0..3)];
        // A triangle far away makes the steps of the shadow coarse.
        let corner = rng.random_range(0.0..4e3);
        let far = [[corner, 0.0, 0.0], [0.0, corner, 0.0], [0.0, 0.0, corner]];
        let first = (size[0] + 1) * (size[1] + 1) + 1;
        triangles.push([first, first + 1, first + 2]);
        let placed = |rng: &mut ChaCha8Rng| -> Vec<[f64; 3]> {
            let mut points = if rng.random_bool(0.5) { ring(size, rng) } else { bent(size, rng) };
            for x in points.as_flattened_mut() {
                *x += offset + noise * rng.random_range(-1.0..1.0);
            }
            points.extend(&far);
            points
        };
        let mut points = placed(&mut rng);
        let mut model = Model::from_f64(points.clone(), triangles.clone()).unwrap();
        let mut query = SelfQuery::new();
        for time in 0..16 {
            if time > 8 {
                let hits =
                    |(a, b): &(usize, usize)| self_hit(triangles[*a], triangles[*b], &points);
                let all = (0..triangles.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
                let mut truth: Vec<_> = all.filter(hits).collect();
                truth.sort_unstable();
                let found = query.all(&model).unwrap();
                let found: Vec<_> = found.iter().map(|p| (p.a as usize, p.b as usize)).collect();
                assert_eq!(found, truth, "round {round}: {model:?}");
                let of_model = model.patches();
                certified +=
                    (0..of_model.count()).filter(|&patch| of_model.is_certified(patch)).count();
                patches += of_model.count() as usize;
                met += truth.len();
                let of_shadow = self_pairs(model.mesh().shadow(), &triangles);
                differs += usize::from(of_shadow.len() != truth.len());
            }
            points = placed(&mut rng);
            model.set_positions_f64(&points).unwrap();
        }
    }
    let counts = [certified, patches - certified, met, differs];
    assert!(counts.iter().all(|&count| count > 500), "{counts:?}");
}

/// So many triangles around one vertex, whose tiles are all neighbours, were once compared with each other.
#[test]
fn a_vertex_of_many_triangles() {
    let n = 100_000;
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let rim = (0..n).map(|i| [angle(i).cos() as f32, angle(i).sin() as f32, 0.0]);
    let mut points: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(rim).collect();
    let triangles = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
    let mut model = Model::new(points.clone(), triangles).unwrap();
    for height in 0..10 {
        points[0][2] = 0.1 * height as f32;
        model.set_positions(&points).unwrap();
        assert!(model.patches().count() <= n);
    }
}

#[test]
fn patches_of_a_tree_are_used_for_no_other_and_for_no_boxes() {
    let hills = bumpy(20);
    let mut model = Model::new(hills.positions.clone(), hills.triangles).unwrap();
    for time in 0..10 {
        let raised = hills.positions.iter().map(|&[x, y, z]| [x, y, z + time as f32]);
        model.set_positions(&raised.collect::<Vec<_>>()).unwrap();
    }
    let patches = model.patches();
    assert!((0..patches.count()).any(|patch| patches.is_certified(patch)));
    let query = SelfBvtt::new(model.bvh());
    let boxes = query.boxes_only().count();
    assert!(boxes > 0);
    assert_eq!(query.with_patches(patches).boxes_only().count(), boxes);
    assert_eq!(query.boxes_only().with_patches(patches).count(), boxes);

    let work = |query: &SelfBvtt<'_>| {
        let mut cursor = query.start();
        assert!(query.visit(&mut cursor, |_| ControlFlow::Continue(())).is_continue());
        cursor.work
    };
    assert!(work(&query.with_patches(patches)).triangle_tests < work(&query).triangle_tests);
    // The same mesh in other memory, and another order of its triangles.
    let other = model.clone();
    let order = model.bvh().order().to_vec();
    let nodes = model.bvh().nodes();
    for bvh in [other.bvh(), Bvh::new_unchecked(model.mesh(), nodes, &order)] {
        let query = SelfBvtt::new(bvh);
        assert_eq!(work(&query.with_patches(patches)), work(&query));
    }
}
