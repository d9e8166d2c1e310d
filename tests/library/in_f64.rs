//! Models and poses in f64, by every query and executor on a CPU, against every two triangles.

use pfront::executor::Backend;
use pfront::pfront_core::triangle::{Adjacency, intersects_f64, intersects_in_mesh};
use pfront::{
    AnyPose, Batch, Executor, Model, PairQuery, Pose, Pose64, SceneQuery, SelfQuery, TrianglePair,
};
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::icosphere;
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
        None => mesh.positions().unwrap()[*v as usize].map(f64::from),
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
    #[cfg(feature = "gpu")]
    {
        let gpu = pfront::gpu::Gpu::new().unwrap();
        vec![
            Executor::sequential(),
            Executor::threads(3),
            Executor::auto(),
            Executor::gpu(&gpu, gpu.settings()),
        ]
    }
    #[cfg(not(feature = "gpu"))]
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
            // Each verb anew.
            let mut query = PairQuery::new().on(&executor);
            assert_eq!(query.count(&a, &b, pose).unwrap(), expected.len() as u64);
            query.forget();
            assert!(expected.contains(&query.any(&a, &b, pose).unwrap().unwrap()));
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
            let meet = |p: &TrianglePair| intersects_in_mesh(mesh, p.a, p.b, Adjacency::default());
            pairs.filter(meet).collect()
        };
        for executor in executors() {
            assert_eq!(SelfQuery::new().on(&executor).all(&model).unwrap(), expected);
        }
        let vertices = 0..model.mesh().vertex_count() as u32;
        certified += vertices.filter(|v| model.certificates().is_certified(*v)).count();
        found += expected.len();
        let mut moved = model.mesh().positions_f64().unwrap().to_vec();
        // Few, then all, then to another place, in steps below what f32 holds there.
        let (count, far) = if frame % 3 == 0 { (5, 0.0) } else { (moved.len(), 1e4) };
        for p in moved.iter_mut().take(count) {
            *p = p.map(|x| x + rng.random_range(-0.15..0.15) + if frame == 7 { far } else { 0.0 });
        }
        model.set_positions(&moved).unwrap();
    }
    assert!(found > 200 && certified > 200, "{found} {certified}");
    assert!(model.set_positions(&[[0.0; 3]; 3]).is_err());
    let mut rounded = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    assert!(rounded.set_positions(&[[0.0_f64; 3]; 3]).is_err());
}

/// A query that is asked again after its models have moved.
#[test]
fn pairs_of_moving_meshes() {
    let (start, b) = (sheet_in_f64(9, 0.0, 7), sheet_in_f64(8, 0.01, 8));
    let identity = Pose64::IDENTITY;
    for executor in executors() {
        let (mut a, mut query, mut found) = (start.clone(), PairQuery::new().on(&executor), 0);
        for frame in 0..4 {
            let expected = brute(&a, &identity, &b, &identity);
            assert_eq!(query.all(&a, &b, Pose::IDENTITY).unwrap(), expected, "{frame}");
            found += expected.len();
            let moved = a.mesh().positions_f64().unwrap();
            let moved: Vec<_> = moved.iter().map(|&[x, y, z]| [x + 1e-3, y, z + 1e-9]).collect();
            a.set_positions(&moved).unwrap();
        }
        assert!(found > 0);
    }
}

#[test]
fn scenes_of_both_kinds() {
    let (a, b) = (sheet_in_f64(9, 0.0, 5), sheet_in_f64(8, 0.01, 6));
    let flat = sheet(7, |x, y| 0.02 * (5.0 * x + 3.0 * y).sin());
    let c = Model::new(flat.positions.clone(), flat.triangles.clone()).unwrap();
    let to = FAR.map(|x| x as f32);
    let in_f32: [AnyPose; 3] =
        [Pose::IDENTITY, Pose::from_translation([0.0, 0.0, -0.01]), Pose::from_translation(to)]
            .map(AnyPose::from);
    let turn = Pose64::from_rotation_translation([0.0, 0.0, 0.1, 0.99], [0.0; 3]);
    let in_f64 = [
        Pose64::from_translation(FAR) * turn * Pose64::from_translation(FAR.map(|x| -x)),
        Pose64::from_translation([0.1, 1e-9, -0.01]),
        Pose64::from_translation(FAR) * turn,
    ]
    .map(AnyPose::from);
    let models = [a, b, c].map(Arc::new);
    for executor in executors() {
        let mut scene = SceneQuery::new().on(&executor);
        let ids = [0, 1, 2].map(|k| scene.add(models[k].clone(), in_f32[k]).unwrap());
        for (frame, poses) in [in_f32, in_f64, [in_f64[0], in_f32[1], in_f64[2]]].iter().enumerate()
        {
            (0..3).for_each(|k| scene.set_pose(ids[k], poses[k]).unwrap());
            assert_eq!(scene.body(ids[0]).unwrap().pose(), poses[0]);
            if frame == 2 {
                let lowered: Vec<_> = models[0].mesh().positions_f64().unwrap().to_vec();
                let lowered: Vec<_> = lowered.iter().map(|p| [p[0], p[1], p[2] - 1e-3]).collect();
                scene.set_positions(ids[0], &lowered).unwrap();
                assert!(scene.set_positions(ids[0], &[[0.0_f32; 3]; 100]).is_err());
                assert!(scene.set_positions(ids[2], &lowered).is_err());
                assert!(scene.set_positions(ids[0], &lowered[1..]).is_err());
            }
            let hits = scene.all().unwrap().to_vec();
            let contacts = scene.contacts_f64().unwrap();
            assert_eq!(contacts.iter().map(|c| c.0).collect::<Vec<_>>(), hits);
            let models = ids.map(|id| scene.body(id).unwrap().model().clone());
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let [p, q] = [i, j].map(|k: usize| poses[k].to_f64());
                let expected = brute(&models[i], &p, &models[j], &q);
                let own = hits.iter().filter(|hit| hit.bodies == [ids[i], ids[j]]);
                let own: Vec<_> = own.map(|hit| hit.pair).collect();
                assert_eq!(own, expected, "{executor:?} {frame} {i} {j}");
                assert!(expected.len() > 10, "{frame} {i} {j} {}", expected.len());
            }
        }
        let far = Pose64::from_translation([0.0, 1e38, 0.0]);
        assert!(scene.set_pose(ids[0], far).is_err() && scene.add(models[0].clone(), far).is_err());
        assert_eq!(scene.body(ids[0]).unwrap().pose(), in_f64[0]);
    }
}

/// Ends of contacts lie where the planes of both triangles are, to what f64 holds there.
#[test]
fn contacts_are_not_rounded_to_f32() {
    let (a, b) = (sheet_in_f64(12, 0.0, 1), sheet_in_f64(11, 0.0, 2));
    let pose = Pose64::from_translation([1e-9, 1e-3, 1e-4]);
    let contacts = PairQuery::new().contacts_f64(&a, &b, pose).unwrap();
    let (of_a, of_b) = (posed(&a, &Pose64::IDENTITY), posed(&b, &pose));
    assert!(contacts.len() > 20);
    for (pair, contact) in contacts {
        for end in contact.segment {
            for t in [of_a[pair.a as usize], of_b[pair.b as usize]] {
                let [u, v, w] =
                    [t[1], t[2], end].map(|p| glam::DVec3::from(p) - glam::DVec3::from(t[0]));
                let distance = u.cross(v).normalize().dot(w).abs();
                assert!(distance < 4e-9, "{distance}");
            }
        }
    }
}

/// The curves in which two closed surfaces cross are closed, to the bit: each end is that of two contacts.
#[test]
fn ends_of_neighbouring_contacts_are_the_same() {
    let ball = icosphere(1280);
    for (place, angle) in [([0.0; 3], 0.3), (FAR, 0.7), (FAR.map(|x| -x), 1.9)] {
        let positions =
            ball.positions.iter().map(|p| [0, 1, 2].map(|k| place[k] + f64::from(p[k])));
        let model = Model::from_f64(positions.collect(), ball.triangles.clone()).unwrap();
        let turn = Pose64::from_rotation_translation(
            [0.1, 0.2, f64::sin(angle), f64::cos(angle)],
            [0.37, 0.21, 0.13],
        );
        let pose =
            Pose64::from_translation(place) * turn * Pose64::from_translation(place.map(|x| -x));
        let contacts = PairQuery::new().contacts_f64(&model, &model, pose).unwrap();
        let mut ends = std::collections::HashMap::new();
        for (_, contact) in &contacts {
            assert!(!contact.is_flat);
            for end in contact.segment {
                *ends.entry(end.map(f64::to_bits)).or_insert(0) += 1;
            }
        }
        assert!(contacts.len() > 100 && ends.values().all(|&count| count == 2), "{ends:?}");
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
    let expected = query.all(&rounded, &rounded, Pose::IDENTITY).unwrap().to_vec();
    assert_eq!(query.all(&exact, &rounded, Pose::IDENTITY).unwrap(), expected);
    let pose = Pose::from_rotation_translation([0.1, 0.2, 0.3, 0.927], [0.01, 0.02, 0.03]);
    let expected = brute(&exact, &Pose64::IDENTITY, &exact, &pose.into());
    assert_eq!(query.all(&exact, &exact, pose).unwrap(), expected);
    assert_eq!(query.plan().unwrap().backend, Backend::Sequential);
}

/// A blob holds the numbers that decide, and deforms as what it was made of.
#[test]
fn blobs_of_models_in_f64() {
    let far = sheet_in_f64(12, 0.0, 3);
    let flat = sheet(7, |x, y| 0.02 * (5.0 * x + 3.0 * y).sin());
    let widened = flat.positions.iter().map(|p| p.map(f64::from)).collect();
    let near = Model::from_f64(widened, flat.triangles.clone()).unwrap();
    for mut model in [far, near] {
        let bytes = model.to_blob().unwrap();
        let mut again = Model::from_blob(&bytes).unwrap();
        assert!(again.is_f64() && again.to_blob().unwrap() == bytes);
        assert_eq!(again.mesh().positions_f64(), model.mesh().positions_f64());
        let pose = Pose64::from_translation([1e-9, 1e-3, 1e-4]);
        let expected = brute(&model, &Pose64::IDENTITY, &again, &pose);
        assert_eq!(PairQuery::new().all(&model, &again, pose).unwrap(), expected);
        let moved: Vec<_> = posed(&model, &pose).concat();
        let moved: Vec<_> = moved.iter().cycle().take(model.mesh().vertex_count()).collect();
        let moved: Vec<[f64; 3]> = moved.into_iter().copied().collect();
        for model in [&mut model, &mut again] {
            model.set_positions(&moved).unwrap();
        }
        let [of_model, of_again] =
            [&model, &again].map(|model| SelfQuery::new().all(model).unwrap().to_vec());
        assert!(!of_model.is_empty() && of_model == of_again);
    }
}
