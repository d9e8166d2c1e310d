//! Self-collision around one vertex, and of small sheets, against brute force with the exact oracle: where certificates
//! answer.

use pfront::{Model, SelfQuery, TrianglePair};
use pfront_testkit::oracle::{self_hit, self_pairs};
use pfront_testkit::rng::{ChaCha8Rng, Rng, RngExt, seeded, seq::SliceRandom};

/// A centre and a rim about it, wound `turns` times, then disturbed.
fn rim(n: usize, turns: f32, rng: &mut impl Rng) -> Vec<[f32; 3]> {
    let (noise, height) = (rng.random_range(0.0..0.6), rng.random_range(0.0..1.0));
    let whole = rng.random_bool(0.5);
    let turned = rng.random_range(0..3);
    let mut points = vec![[0.0; 3]];
    for i in 0..n {
        let angle = turns * std::f32::consts::TAU * i as f32 / n as f32;
        let mut p = [angle.cos(), angle.sin(), height * rng.random_range(-1.0..1.0)];
        for x in &mut p {
            *x += noise * rng.random_range(-1.0..1.0);
            // On a coarse lattice, much is level, in line and in one plane.
            *x = if whole { (*x * 2.0).round() } else { *x };
        }
        p.rotate_left(turned);
        points.push(p);
    }
    points
}

/// The triangles around the centre, in any order and turned any way, some of them turned over.
fn one_ring(n: usize, ring: bool, rng: &mut impl Rng) -> Vec<[u32; 3]> {
    let n = n as u32;
    let over = if rng.random_bool(0.8) { 0.0 } else { 0.2 };
    let mut triangles: Vec<_> = (0..if ring { n } else { n - 1 })
        .map(|i| {
            let mut t = [0, i + 1, (i + 1) % n + 1];
            t.rotate_left(rng.random_range(0..3));
            if rng.random_bool(over) {
                t.swap(0, 1);
            }
            t
        })
        .collect();
    triangles.shuffle(rng);
    triangles
}

#[test]
fn rings_and_rows_of_every_kind() {
    let mut rng = seeded(9);
    let (mut certified, mut met) = (0, 0);
    for round in 0..20_000 {
        let n = rng.random_range(3..12);
        let turns = [1.0, 1.0, 0.5, 0.95, 1.05, 2.0][rng.random_range(0..6)];
        let triangles = one_ring(n, rng.random_bool(0.7), &mut rng);
        let mut model = Model::new(rim(n, turns, &mut rng), triangles.clone()).unwrap();
        let mut query = SelfQuery::new();
        // The second time, vertices have moved.
        for _ in 0..2 {
            let truth = self_pairs(model.mesh().positions().unwrap(), &triangles);
            let truth: Vec<_> = truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect();
            assert_eq!(query.all(&model).unwrap(), truth, "round {round}: {model:?}");
            certified += usize::from(model.certificates().is_certified(0));
            met += truth.len();
            model.set_positions(&rim(n, turns, &mut rng)).unwrap();
        }
    }
    assert!(certified > 3_000 && met > 3_000, "{certified} certified, {met} pairs");
}

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

/// How many vertices are certified, and how many there are.
fn certified(model: &Model) -> [usize; 2] {
    let (certificates, vertices) = (model.certificates(), model.mesh().vertex_count());
    let is_certified = |vertex: &u32| certificates.is_certified(*vertex);
    [(0..vertices as u32).filter(is_certified).count(), vertices]
}

#[test]
fn sheets_of_every_kind() {
    let mut rng = seeded(10);
    let (mut counts, mut met) = ([0; 2], 0);
    for round in 0..1_000 {
        let size = [rng.random_range(2..10), rng.random_range(1..5)];
        let triangles = sheet(size, &mut rng);
        let mut model = Model::new(rounded(bent(size, &mut rng)), triangles.clone()).unwrap();
        let mut query = SelfQuery::new();
        for time in 0..6 {
            let truth = self_pairs(model.mesh().shadow(), &triangles);
            let truth: Vec<_> = truth.iter().map(|&(a, b)| TrianglePair { a, b }).collect();
            assert_eq!(query.all(&model).unwrap(), truth, "round {round}: {model:?}");
            counts = add(counts, certified(&model));
            met += truth.len();
            // All vertices move, and then one.
            let mut moved = rounded(bent(size, &mut rng));
            if time % 3 == 1 {
                moved.clone_from_slice(model.mesh().shadow());
                let vertex = rng.random_range(0..moved.len());
                moved[vertex][rng.random_range(0..3)] += rng.random_range(-2.0..2.0);
            }
            model.set_positions(&moved).unwrap();
        }
    }
    let [certified, vertices] = counts;
    let counts = [certified, vertices - certified, met];
    assert!(counts.iter().all(|&count| count > 1_000), "{counts:?}");
}

/// Noise below what the shadow resolves decides what meets, and which one-rings overlap.
#[test]
fn sheets_in_f64() {
    let mut rng = seeded(11);
    let (mut counts, mut met, mut differs) = ([0; 2], 0, 0);
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
        for _ in 0..7 {
            let hits = |(a, b): &(usize, usize)| self_hit(triangles[*a], triangles[*b], &points);
            let all = (0..triangles.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
            let mut truth: Vec<_> = all.filter(hits).collect();
            truth.sort_unstable();
            let found = query.all(&model).unwrap();
            let found: Vec<_> = found.iter().map(|p| (p.a as usize, p.b as usize)).collect();
            assert_eq!(found, truth, "round {round}: {model:?}");
            counts = add(counts, certified(&model));
            met += truth.len();
            let of_shadow = self_pairs(model.mesh().shadow(), &triangles);
            differs += usize::from(of_shadow.len() != truth.len());
            points = placed(&mut rng);
            model.set_positions(&points).unwrap();
        }
    }
    let [certified, vertices] = counts;
    let counts = [certified, vertices - certified, met, differs];
    assert!(counts.iter().all(|&count| count > 500), "{counts:?}");
}

fn add([a, b]: [usize; 2], [c, d]: [usize; 2]) -> [usize; 2] {
    [a + c, b + d]
}
