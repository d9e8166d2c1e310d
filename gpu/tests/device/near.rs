//! Pairs within a distance: what the device is sure of, and what it leaves open, are the whole answer together.

use crate::common::{Both, gpu, gpu_with, sorted};
use crate::in_f64::{Exact, FAR, around};
use pfront_core::bvtt::{PairBvtt, TrianglePair};
use pfront_core::triangle::within;
use pfront_core::{Distance, Pose};
use pfront_gpu::{Arithmetic, Budget, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuSettings};
use pfront_testkit::families::Family;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::shapes::{bumpy, family, pose_rows, sheet, sphere};

/// Asks with every verb; returns how many pairs there are, and how many the device left open.
fn check(query: &mut GpuQuery, core: &PairBvtt<'_>, question: &GpuQuestion<'_>) -> [usize; 2] {
    let truth = sorted(core);
    let decided = |query: &GpuQuery| -> Vec<TrianglePair> {
        query.open().iter().copied().filter(|&pair| core.intersects(pair)).collect()
    };
    let mut pairs = query.all(question).unwrap().to_vec();
    pairs.extend(decided(query));
    pairs.sort_unstable();
    assert!(pairs == truth, "{:?}", first_difference(&pairs, &truth));
    let open = query.open().len();
    let count = query.count(question).unwrap() as usize;
    assert_eq!(count + decided(query).len(), truth.len());
    let any = query.any(question).unwrap().or_else(|| decided(query).first().copied());
    assert!(any.map_or(truth.is_empty(), |pair| truth.binary_search(&pair).is_ok()));
    [truth.len(), open]
}

/// The pair that is in one of two sorted lists, and whether it is in the first.
fn first_difference(a: &[TrianglePair], b: &[TrianglePair]) -> Option<(TrianglePair, bool)> {
    let only_in = |a: &[TrianglePair], b: &[TrianglePair]| {
        a.iter().copied().find(|pair| b.binary_search(pair).is_err())
    };
    only_in(a, b).map(|pair| (pair, true)).or_else(|| only_in(b, a).map(|pair| (pair, false)))
}

fn check_pair(
    query: &mut GpuQuery,
    [a, b]: [&Both; 2],
    pose: &Pose,
    distance: Distance,
) -> [usize; 2] {
    let core = PairBvtt::new(a.bvh(), b.bvh(), *pose).unwrap().within(distance);
    let question = GpuQuestion::pair(&a.model, &b.model, pose).within(distance).unwrap();
    check(query, &core, &question)
}

/// The least distance of f32 within which two triangles are, and its neighbours.
fn edge_of(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) -> Vec<Distance> {
    let (mut low, mut high) = (0, (f32::MAX / 4.0).to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        let is_within = within(a, b, f32::from_bits(middle));
        (low, high) = if is_within { (low, middle) } else { (middle + 1, high) };
    }
    let around = low.saturating_sub(1)..(low + 2).min((f32::MAX / 4.0).to_bits());
    around.map(|bits| Distance::new(f32::from_bits(bits)).unwrap()).collect()
}

/// Distances at which some pair begins to be within.
fn edges(a: &Both, b: &Both, pose: &Pose, rng: &mut impl Rng) -> Vec<Distance> {
    let mut pick = |both: &Both, pose: &Pose| {
        let bvh = both.bvh();
        let mesh = bvh.mesh();
        let triangle = rng.random_range(0..mesh.triangles().len() as u32);
        mesh.shadow_triangle(triangle).map(|p| pose.apply(p))
    };
    edge_of(&pick(a, &Pose::IDENTITY), &pick(b, pose))
}

#[test]
fn soups_of_every_family_at_the_edge() {
    let mut rng = seeded(41);
    let mut query = GpuQuery::new(gpu()).unwrap();
    let mut sums = [0, 0];
    for f in Family::ALL {
        if matches!(f, Family::Huge | Family::RawBits) {
            // Coordinates beyond what boxes that grow hold.
            continue;
        }
        let [a, b] = [0; 2].map(|_| {
            let soup = family(f, 28, &mut rng);
            Both::new(&soup.positions, &soup.triangles, 4)
        });
        for pose in [Pose::IDENTITY, Pose::new(pose_rows(0.1, &mut rng))] {
            for distance in edges(&a, &b, &pose, &mut rng) {
                let found = check_pair(&mut query, [&a, &b], &pose, distance);
                (0..2).for_each(|i| sums[i] += found[i]);
            }
        }
    }
    assert!(sums[0] > 1000 && sums[1] > 1000, "{sums:?}");
}

/// The device is sure of most pairs of ordinary meshes, of any size.
#[test]
fn few_pairs_are_left_open() {
    let mut rng = seeded(42);
    let mut query = GpuQuery::new(gpu()).unwrap();
    for size in [1.0, 1e-20, 1e20] {
        let [a, b] = [sphere(16), bumpy(16)].map(|soup| {
            let soup = soup.map(|p| p.map(|x| x * size));
            Both::new(&soup.positions, &soup.triangles, 4)
        });
        let mut sums = [0, 0];
        for share in [0.001, 0.03, 0.3] {
            let distance = Distance::new(share * size).unwrap();
            let mut rows = pose_rows(1.2, &mut rng);
            rows.iter_mut().for_each(|row| row[3] *= size);
            let found = check_pair(&mut query, [&a, &b], &Pose::new(rows), distance);
            (0..2).for_each(|i| sums[i] += found[i]);
        }
        assert!(sums[0] > 500 && 10 * sums[1] < sums[0], "{size:e}: {sums:?}");
    }
}

#[test]
fn shadows_too() {
    let mut rng = seeded(43);
    let mut query = GpuQuery::new(gpu()).unwrap();
    let mut sums = [0, 0];
    for place in [[0.0; 3], FAR] {
        let a = Exact::new(&sphere(14), place, &mut rng);
        let b = Exact::new(&bumpy(14), place, &mut rng);
        let [of_a, of_b] = [&a, &b].map(|mesh| GpuModel::new(gpu(), mesh.bvh()).unwrap());
        for distance in [0.001, 0.05, 0.4].map(|d| Distance::new(d).unwrap()) {
            let pose = around(place, pose_rows(1.2, &mut rng));
            let core = PairBvtt::in_f64(a.bvh(), b.bvh(), &pose).unwrap().within(distance);
            let shadows = core.shadows().unwrap();
            let question = GpuQuestion::shadows(&of_a, &of_b, &shadows).within(distance).unwrap();
            let found = check(&mut query, &core, &question);
            (0..2).for_each(|i| sums[i] += found[i]);
        }
    }
    assert!(sums[0] > 500 && 5 * sums[1] < sums[0], "{sums:?}");
}

/// Two sheets exactly as far apart as is asked for, with little memory and every arithmetic.
#[test]
fn flush_gaps() {
    let flat = sheet(7, |_, _| 0.0);
    let [a, b] = [0; 2].map(|_| Both::new(&flat.positions, &flat.triangles, 4));
    let gap = 0.3_f32;
    let pose = Pose::from_translation([0.1, 0.05, gap]);
    for arithmetic in [Arithmetic::Hardware, Arithmetic::Flushing, Arithmetic::Integer] {
        let gpu = gpu_with(arithmetic);
        for budget in [Budget::default(), Budget::LEAST] {
            let settings = GpuSettings { budget, ..gpu.settings() };
            let mut query = GpuQuery::with_settings(gpu, settings).unwrap();
            let mut found = [gap.next_down(), gap].map(|distance| {
                check_pair(&mut query, [&a, &b], &pose, Distance::new(distance).unwrap())[0]
            });
            found[1] -= found[0];
            assert!(found[0] == 0 && found[1] > 100, "{found:?}");
        }
    }
}

#[test]
fn distances_that_are_beyond_a_device_are_refused() {
    let flat = sheet(3, |_, _| 0.0);
    let a = Both::new(&flat.positions, &flat.triangles, 4);
    let most = Distance::new(f32::MAX / 4.0).unwrap();
    let more = Distance::new((f32::MAX / 4.0).next_up()).unwrap();
    let pair = GpuQuestion::pair(&a.model, &a.model, &Pose::IDENTITY);
    assert!(matches!(pair.within(more), Err(GpuError::Distance { .. })));
    assert!(GpuQuestion::itself(&a.model).within(Distance::default()).is_ok());
    assert!(matches!(
        GpuQuestion::itself(&a.model).within(Distance::new(0.1).unwrap()),
        Err(GpuError::Distance { .. })
    ));
    let mut query = GpuQuery::new(gpu()).unwrap();
    let [found, _] = check_pair(&mut query, [&a, &a], &Pose::IDENTITY, most);
    assert_eq!(found, flat.triangles.len().pow(2));
    let huge = flat.map(|p| p.map(|x| x * 1.8e38));
    let huge = Both::new(&huge.positions, &huge.triangles, 4);
    let question = GpuQuestion::pair(&a.model, &huge.model, &Pose::IDENTITY);
    assert!(query.count(&question).is_ok());
    let refused = query.count(&question.within(most).unwrap());
    assert!(matches!(refused, Err(GpuError::Pose(_))), "{refused:?}");
}
