//! Models and poses in f64, by every query and executor on a CPU, against every two triangles.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::executor::Backend;
use pfront::pfront_core::triangle::{Accuracy, Adjacency, intersects_f64, intersects_in_mesh};
use pfront::{
    AnyPose, Batch, Executor, Model, PairQuery, Pose, Pose64, SceneQuery, SelfQuery, TrianglePair,
};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::sheet;
use std::sync::Arc;

/// Where on earth: f32 knows such coordinates to half a metre.
const FAR: [f64; 3] = [500_000.1, 5_000_000.2, 300.3];

/// A wavy sheet of a metre there, with noise below what f32 holds.
fn sheet_in_f64(steps: u32, height: f64, seed: u64) -> Model {
    let flat = sheet(steps, |_, _| 0.0);
    let mut rng = seeded(seed);
    let wave = |x: f64, y: f64| 0.02 * ((9.0 * x).sin() + (7.0 * y).cos());
    let positions = flat.positions.iter().map(|p| {
        let [x, y, _] = p.map(f64::from);
        let noise = rng.random_range(-1e-9..1e-9);
        [FAR[0] + x, FAR[1] + y, FAR[2] + height + wave(x, y) + noise]
    });
    Model::from_f64(positions.collect(), flat.triangles.clone()).unwrap()
}

/// The corners of each triangle, posed by the formula of the contract.
fn posed(model: &Model, pose: &Pose64) -> Vec<[[f64; 3]; 3]> {
    let mesh = model.mesh();
    let position = |v: &u32| match mesh.positions_f64() {
        Some(positions) => positions[*v as usize],
        None => mesh.positions()[*v as usize].map(f64::from),
    };
    mesh.triangles().iter().map(|t| t.each_ref().map(|v| pose.apply(position(v)))).collect()
}

fn brute(a: &Model, pose_a: &Pose64, b: &Model, pose_b: &Pose64) -> Vec<TrianglePair> {
    let (of_a, of_b) = (posed(a, pose_a), posed(b, pose_b));
    let mut pairs = Vec::new();
    for (i, p) in (0..).zip(&of_a) {
        for (j, q) in (0..).zip(&of_b) {
            if intersects_f64(p, q).unwrap() {
                pairs.push(TrianglePair { a: i, b: j });
            }
        }
    }
    pairs
}

fn executors() -> Vec<Executor> {
    vec![Executor::sequential(), Executor::threads(3), Executor::auto()]
}

#[test]
fn pairs_by_every_executor() {
    let (a, b) = (sheet_in_f64(12, 0.0, 1), sheet_in_f64(11, 0.0, 2));
    let turn = Pose64::from_rotation_translation([0.0, 0.0, 0.000_3, 1.0], [0.0; 3]);
    let poses = [
        AnyPose::F32(Pose::IDENTITY),
        AnyPose::F64(Pose64::from_translation([0.0, 0.0, -1e-4])),
        AnyPose::F64(Pose64::from_translation([1e-9, 1e-3, 1e-4])),
        AnyPose::F64(
            Pose64::from_translation(FAR) * turn * Pose64::from_translation(FAR.map(|x| -x)),
        ),
    ];
    let in_f64 = |pose: &AnyPose| match pose {
        AnyPose::F32(pose) => Pose64::from(*pose),
        AnyPose::F64(pose) => *pose,
    };
    let (a, b) = (Arc::new(a), Arc::new(b));
    for executor in executors() {
        let (mut query, mut batch, mut lists) =
            (PairQuery::new().on(&executor), Batch::new(), Vec::new());
        for pose in &poses {
            let expected = brute(&a, &Pose64::IDENTITY, &b, &in_f64(pose));
            assert!(!expected.is_empty());
            assert_eq!(query.all(&a, &b, pose).unwrap(), expected);
            assert_eq!(query.count(&a, &b, pose).unwrap(), expected.len() as u64);
            assert!(expected.contains(&query.any(&a, &b, pose).unwrap().unwrap()));
            let contacts = query.contacts(&a, &b, pose).unwrap();
            assert_eq!(contacts.iter().map(|c| c.0).collect::<Vec<_>>(), expected);
            batch.pair(&a, &b, pose).unwrap();
            lists.push(expected);
        }
        let found = batch.all(&executor).unwrap().read().unwrap();
        (0..lists.len()).for_each(|i| assert_eq!(found[i], lists[i]));
    }
}

#[test]
fn self_collisions_while_deforming() {
    let mut model = sheet_in_f64(12, 0.0, 3);
    let mut rng = seeded(4);
    let (mut found, mut certified) = (0, 0);
    for frame in 0..12 {
        let expected: Vec<_> = {
            let (mesh, n) = (model.mesh(), model.mesh().triangles().len() as u32);
            let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| TrianglePair { a: i, b: j }));
            let meet = |p: &TrianglePair| {
                intersects_in_mesh(mesh, p.a, p.b, Adjacency::default(), Accuracy::Exact)
            };
            pairs.filter(meet).collect()
        };
        for executor in executors() {
            assert_eq!(SelfQuery::new().on(&executor).all(&model).unwrap(), expected);
        }
        let vertices = 0..model.mesh().positions().len() as u32;
        certified += vertices.filter(|v| model.certificates().is_certified(*v)).count();
        found += expected.len();
        let mut moved = model.mesh().positions_f64().unwrap().to_vec();
        // Few, then all, then to another place, in steps below what f32 holds there.
        let (count, far) = if frame % 3 == 0 { (5, 0.0) } else { (moved.len(), 1e4) };
        for p in moved.iter_mut().take(count) {
            *p = p.map(|x| x + rng.random_range(-0.15..0.15) + if frame == 7 { far } else { 0.0 });
        }
        model.set_positions_f64(&moved).unwrap();
    }
    assert!(found > 200 && certified > 200, "{found} {certified}");
    assert!(model.set_positions(&[[0.0; 3]; 3]).is_err());
    let mut rounded = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    assert!(rounded.set_positions_f64(&[[0.0; 3]; 3]).is_err());
}

#[test]
fn scenes_of_both_kinds() {
    let (a, b) = (sheet_in_f64(9, 0.0, 5), sheet_in_f64(8, 0.01, 6));
    let flat = sheet(7, |x, y| 0.02 * (5.0 * x + 3.0 * y).sin());
    let c = Model::new(flat.positions.clone(), flat.triangles.clone()).unwrap();
    let to = FAR.map(|x| x as f32);
    let poses =
        [Pose::IDENTITY, Pose::from_translation([0.0, 0.0, -0.01]), Pose::from_translation(to)];
    let models = [a, b, c].map(Arc::new);
    for executor in executors() {
        let mut scene = SceneQuery::new().on(&executor);
        let ids: Vec<_> =
            models.iter().zip(poses).map(|(m, pose)| scene.add(m.clone(), pose).unwrap()).collect();
        let hits = scene.all().unwrap().to_vec();
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let [p, q] = [i, j].map(|k: usize| Pose64::from(poses[k]));
            let expected = brute(&models[i], &p, &models[j], &q);
            let own = hits.iter().filter(|hit| hit.bodies == [ids[i], ids[j]]);
            assert_eq!(own.map(|hit| hit.pair).collect::<Vec<_>>(), expected, "{i} {j}");
            assert!(expected.len() > 20, "{}", expected.len());
        }
    }
}

/// A model whose coordinates f32 holds takes no memory for others, and is posed in f64 nevertheless.
#[test]
fn what_f32_holds_is_kept_in_f32() {
    let flat = sheet(9, |x, y| 0.1 * (5.0 * x + 3.0 * y).sin());
    let widened = flat.positions.iter().map(|p| p.map(f64::from)).collect();
    let rounded = Model::new(flat.positions.clone(), flat.triangles.clone()).unwrap();
    let exact = Model::from_f64(widened, flat.triangles.clone()).unwrap();
    assert!(exact.is_f64() && exact.bytes() == rounded.bytes());
    let mut query = PairQuery::new();
    let expected = query.all(&rounded, &rounded, &Pose::IDENTITY).unwrap().to_vec();
    assert_eq!(query.all(&exact, &rounded, &Pose::IDENTITY).unwrap(), expected);
    let pose = Pose::from_rotation_translation([0.1, 0.2, 0.3, 0.927], [0.01, 0.02, 0.03]);
    let expected = brute(&exact, &Pose64::IDENTITY, &exact, &pose.into());
    assert_eq!(query.all(&exact, &exact, &pose).unwrap(), expected);
    assert_eq!(query.plan().unwrap().backend, Backend::Sequential);
    assert!(exact.to_blob().is_err());
}
