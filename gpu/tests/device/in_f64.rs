//! Two meshes in f64: what the device is sure of by their shadows, and what it leaves open, are the whole answer together.

use crate::common::{gpu, gpu_with, sorted};
use pfront_core::bvh::{self, BuildOptions, BvhStorage, node_bound};
use pfront_core::bvtt::{PairBvtt, TrianglePair};
use pfront_core::{Bvh, Mesh, Node, Pose, Pose64};
use pfront_gpu::{Arithmetic, Budget, Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuVerb};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::shapes::{bumpy, family, pose_rows, sheet, sphere};

/// A place that f32 knows to half a metre.
pub(crate) const FAR: [f64; 3] = [500_000.1, 5_000_000.2, 300.3];

pub(crate) struct Exact {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    shadow: Vec<[f32; 3]>,
    origin: [f64; 3],
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Exact {
    /// A mesh around a place, each coordinate off by some units in its last place.
    pub(crate) fn new(soup: &MeshData, place: [f64; 3], rng: &mut impl Rng) -> Self {
        let position = |p: &[f32; 3]| {
            [0, 1, 2].map(|k| {
                let x = place[k] + f64::from(p[k]);
                x * (1.0 + f64::from(rng.random_range(-2..3)) * f64::EPSILON)
            })
        };
        let positions: Vec<_> = soup.positions.iter().map(position).collect();
        let (triangles, n) = (soup.triangles.clone(), soup.triangles.len());
        let mut shadow = vec![[0.0; 3]; positions.len()];
        let mesh = Mesh::from_f64(&positions, &triangles, &mut shadow).unwrap();
        let origin = mesh.origin();
        let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let options = BuildOptions { leaf_size: 4, ..BuildOptions::default() };
        let used = bvh::sah(mesh, &options, storage, &mut vec![Node::EMPTY; n]).unwrap();
        let used = used.nodes().len();
        nodes.truncate(used);
        Self { positions, triangles, shadow, origin, nodes, order }
    }

    pub(crate) fn bvh(&self) -> Bvh<'_> {
        let Self { positions, shadow, origin, triangles, nodes, order } = self;
        let mesh = Mesh::from_f64_unchecked(positions, shadow, *origin, triangles);
        Bvh::new_unchecked(mesh, nodes, order)
    }
}

/// Asks with every verb; returns how many pairs meet, and how many the device left open.
fn check(gpu: &Gpu, query: &mut GpuQuery, a: &Exact, b: &Exact, a_from_b: &Pose64) -> [usize; 2] {
    let core = PairBvtt::in_f64(a.bvh(), b.bvh(), a_from_b).unwrap();
    let truth = sorted(&core);
    let [of_a, of_b] = [a, b].map(|mesh| GpuModel::new(gpu, mesh.bvh()).unwrap());
    let question = GpuQuestion::shadows(&of_a, &of_b, &core.shadows().unwrap());
    let meet = |query: &GpuQuery| -> Vec<TrianglePair> {
        query.open().iter().copied().filter(|&pair| core.intersects(pair)).collect()
    };
    let mut pairs = query.all(&question).unwrap().to_vec();
    pairs.extend(meet(query));
    pairs.sort_unstable();
    assert_eq!(pairs, truth);
    let open = query.open().len();
    let count = query.count(&question).unwrap() as usize;
    assert_eq!(count + meet(query).len(), truth.len());
    let any = query.any(&question).unwrap().or_else(|| meet(query).first().copied());
    assert!(any.map_or(truth.is_empty(), |pair| truth.binary_search(&pair).is_ok()));
    [truth.len(), open]
}

/// A pose around a place, by rows of one around the origin.
pub(crate) fn around(place: [f64; 3], rows: [[f32; 4]; 3]) -> Pose64 {
    let back = Pose64::from_translation(place.map(|x| -x));
    Pose64::from_translation(place) * Pose64::from(Pose::new(rows)) * back
}

#[test]
fn soups_of_every_family() {
    let (mut rng, mut query) = (seeded(31), GpuQuery::new(gpu()).unwrap());
    let mut sums = [0, 0];
    for f in Family::ALL {
        if matches!(f, Family::Huge | Family::RawBits) {
            // Beyond 2^125.
            continue;
        }
        for place in [[0.0; 3], FAR] {
            let [a, b] = [0; 2].map(|_| Exact::new(&family(f, 100, &mut rng), place, &mut rng));
            let rows = pose_rows(0.1, &mut rng);
            let pose = if place == FAR { Pose64::IDENTITY } else { around(place, rows) };
            let found = check(gpu(), &mut query, &a, &b, &pose);
            (0..2).for_each(|i| sums[i] += found[i]);
        }
    }
    assert!(sums[0] > 1000 && sums[1] > 1000, "{sums:?}");
}

/// The device is sure of most pairs of ordinary meshes, wherever they are.
#[test]
fn few_pairs_are_left_open() {
    let (mut rng, mut query) = (seeded(32), GpuQuery::new(gpu()).unwrap());
    let (ball, wavy) = (sphere(24), bumpy(20));
    let mut sums = [0, 0];
    for place in [[0.0; 3], FAR, FAR.map(|x| -1e3 * x)] {
        let a = Exact::new(&ball, place, &mut rng);
        let b = Exact::new(&wavy, place, &mut rng);
        for _ in 0..6 {
            let pose = around(place, pose_rows(0.5, &mut rng));
            let found = check(gpu(), &mut query, &a, &b, &pose);
            (0..2).for_each(|i| sums[i] += found[i]);
        }
    }
    assert!(sums[0] > 500 && 5 * sums[1] < sums[0], "{sums:?}");
}

#[test]
fn flush_surfaces_with_little_memory_and_every_arithmetic() {
    let mut rng = seeded(33);
    let flat = sheet(5, |_, _| 0.0);
    let (a, b) = (Exact::new(&flat, FAR, &mut rng), Exact::new(&flat, FAR, &mut rng));
    for arithmetic in [Arithmetic::Hardware, Arithmetic::Flushing, Arithmetic::Integer] {
        let gpu = gpu_with(arithmetic);
        let shifts = [[0.1, 0.05, 0.0], [0.0; 3], [0.0, 0.0, 1e-9], [2.0, 0.0, 0.0]];
        for (budget, shifts) in [(Budget::default(), &shifts[..]), (Budget::LEAST, &shifts[..1])] {
            let settings = pfront_gpu::GpuSettings { budget, ..gpu.settings() };
            let mut query = GpuQuery::with_settings(gpu, settings).unwrap();
            for &t in shifts {
                let pose = Pose64::from_translation(t);
                let [found, open] = check(gpu, &mut query, &a, &b, &pose);
                assert!(open >= found.min(1), "{t:?} {found} {open}");
            }
        }
    }
}

/// A mesh in f32 against one in f64, and in a pose in f64.
#[test]
fn kinds_mix() {
    let (mut rng, mut query) = (seeded(34), GpuQuery::new(gpu()).unwrap());
    let (ball, flat) = (sphere(16), sheet(9, |x, y| 0.1 * (5.0 * x + 3.0 * y).sin()));
    let exact = Exact::new(&ball, [0.0; 3], &mut rng);
    let rounded = crate::common::Both::new(&flat.positions, &flat.triangles, 4);
    let of_exact = GpuModel::new(gpu(), exact.bvh()).unwrap();
    for round in 0..4 {
        let pose = Pose64::from(Pose::new(pose_rows(0.5, &mut rng)));
        let pose = if round == 0 { Pose64::IDENTITY } else { pose };
        let pairs = [
            (PairBvtt::in_f64(exact.bvh(), rounded.bvh(), &pose), [&of_exact, &rounded.model]),
            (PairBvtt::in_f64(rounded.bvh(), rounded.bvh(), &pose), [&rounded.model; 2]),
        ];
        for (core, [a, b]) in pairs {
            let core = core.unwrap();
            let shadows = core.shadows().unwrap();
            let mut found = query.all(&GpuQuestion::shadows(a, b, &shadows)).unwrap().to_vec();
            found.extend(query.open().iter().filter(|pair| core.intersects(**pair)));
            found.sort_unstable();
            assert_eq!(found, sorted(&core));
            assert!(!found.is_empty());
        }
    }
    // Shadows that no query makes.
    let core = PairBvtt::in_f64(exact.bvh(), rounded.bvh(), &Pose64::IDENTITY).unwrap();
    let good = core.shadows().unwrap();
    let mut wrong = [good; 5];
    wrong[0].poses[0].rows[1][2] = f32::NAN;
    wrong[1].poses[1].rows[0][3] = f32::MAX;
    wrong[2].padding[1][0] = -1e-9;
    wrong[3].padding[0][2] = f32::NAN;
    wrong[4].error[1] = f32::INFINITY;
    for shadows in wrong {
        let question = GpuQuestion::shadows(&of_exact, &rounded.model, &shadows);
        assert_eq!(query.submit(&question, GpuVerb::All), Err(GpuError::Shadows));
    }
    // Other questions about a shadow would be answered about something else.
    let pair = GpuQuestion::pair(&of_exact, &rounded.model, &Pose::IDENTITY);
    for question in [pair, GpuQuestion::itself(&of_exact)] {
        assert!(matches!(query.submit(&question, GpuVerb::All), Err(GpuError::InF64)));
    }
}
