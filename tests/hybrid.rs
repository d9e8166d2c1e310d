//! Threads of the CPU and a GPU on one front find what one core finds, whatever share either gets.

#![cfg(all(feature = "threads", feature = "gpu"))]
#![expect(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::core::bvtt::{self, NodePair, Query};
use pfront::gpu::{self, Budget, Deforming, Gpu, Pending};
use pfront::threads::{Schedule, Settings, Traversal};
use pfront::{Model, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_scenes::Scene;

const SHARES: [f64; 5] = [0.0, 0.1, 0.5, 0.9, 1.0];

fn gpu() -> Gpu {
    Gpu::new().unwrap_or_else(|error| panic!("{error}"))
}

/// Each p twice: with a budget in which everything fits, and with one in which next to nothing does.
fn askers(gpu: &Gpu) -> Vec<(Traversal, gpu::Settings)> {
    let least = gpu::Settings { budget: Budget::LEAST, ..gpu.settings() };
    let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
    let least = [1, 2, 7].map(|p| (Traversal::new(p).with_settings(settings), least));
    [1, 2, 7].map(|p| (Traversal::new(p), gpu.settings())).into_iter().chain(least).collect()
}

/// A frame on both, of which `record` records what lies below the GPU's nodes.
fn on_both<'q>(
    gpu: &Gpu,
    traversal: &mut Traversal,
    query: &(impl Query + Sync),
    share: f64,
    record: impl FnOnce(&mut gpu::wgpu::CommandEncoder, &[NodePair]) -> Result<Pending<'q>, gpu::Error>
    + Send,
) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    let start = |below: &[NodePair]| {
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let pending = record(&mut encoder, below).unwrap();
        gpu.queue().submit([encoder.finish()]);
        pending
    };
    let pending = traversal.all_beside(query, share, start, &mut pairs);
    let found = pending.read().unwrap();
    assert!(pairs.is_sorted() && found.is_sorted());
    pairs.extend_from_slice(found);
    pairs.sort();
    pairs
}

#[test]
fn two_models_that_move_and_jump() {
    let (gpu, scene) = (gpu(), Scene::by_name("torus-knots", Some(5_000)).unwrap());
    let [a, b] = [0, 1].map(|i| {
        let mesh = &scene.meshes[scene.objects[i]];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap()
    });
    let [on_a, on_b] = [&a, &b].map(|model| gpu::Model::new(&gpu, model.bvh()).unwrap());
    let (mut one, mut poses) = (PairQuery::new(), Vec::new());
    let far = Pose::from_translation([99.0, 0.0, 0.0]);
    for (mut traversal, settings) in askers(&gpu) {
        let mut query = gpu::PairQuery::with_settings(&gpu, settings).unwrap();
        let mut met = 0;
        for (i, frame) in [60, 61, 62, 63, 10, 11, 61].into_iter().enumerate() {
            scene.poses(frame, &mut poses);
            for pose in [Pose::new(poses[1]), far] {
                for share in [SHARES[i % 5], SHARES[(i + 2) % 5]] {
                    let core = bvtt::PairQuery::new(a.bvh(), b.bvh(), pose).unwrap();
                    let found = on_both(&gpu, &mut traversal, &core, share, |encoder, below| {
                        query.record_below(encoder, &on_a, &on_b, &pose, below)
                    });
                    assert!(found == one.all(&a, &b, &pose).unwrap(), "{share}, frame {frame}");
                    met += found.len();
                }
            }
        }
        assert!(met > 0);
    }
}

#[test]
fn a_model_that_deforms() {
    let (gpu, scene) = (gpu(), Scene::by_name("sheet", Some(5_000)).unwrap());
    let (mut one, mut positions) = (SelfQuery::new(), Vec::new());
    let mut at = |frame: usize| {
        scene.positions(frame, &mut positions);
        positions.clone()
    };
    let mut sheet = Model::new(at(100), scene.meshes[0].triangles.clone()).unwrap();
    let mut moving = Deforming::new(&gpu, sheet.bvh()).unwrap();
    let mut order = sheet.bvh().order().to_vec();
    for (mut traversal, settings) in askers(&gpu) {
        let mut query = gpu::SelfQuery::with_settings(&gpu, settings).unwrap();
        let mut met = 0;
        for (frame, share) in [100, 101, 102, 130, 103].into_iter().zip(SHARES) {
            let moved = at(frame);
            sheet.set_positions(&moved).unwrap();
            moving.set_positions(&moved).unwrap();
            // A tree that has been rebuilt has other nodes than the device's.
            if sheet.bvh().order() != order {
                moving = Deforming::new(&gpu, sheet.bvh()).unwrap();
                order = sheet.bvh().order().to_vec();
            }
            for share in [share, 0.5] {
                let core = bvtt::SelfQuery::new(sheet.bvh()).with_fans(sheet.fans());
                let found = on_both(&gpu, &mut traversal, &core, share, |encoder, below| {
                    query.record_below(encoder, &moving, below)
                });
                assert!(found == one.all(&sheet), "{share}, frame {frame}");
                met += found.len();
            }
        }
        assert!(met > 0);
    }
}

#[test]
fn models_of_nothing() {
    let gpu = gpu();
    let empty = Model::new(vec![], vec![]).unwrap();
    let scene = Scene::by_name("spheres", Some(500)).unwrap();
    let mesh = &scene.meshes[0];
    let ball = Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
    let [on_empty, on_ball] =
        [&empty, &ball].map(|model| gpu::Model::new(&gpu, model.bvh()).unwrap());
    let mut query = gpu::PairQuery::new(&gpu).unwrap();
    let mut traversal = Traversal::new(2);
    for (a, b, on_a, on_b) in [
        (&empty, &empty, &on_empty, &on_empty),
        (&ball, &empty, &on_ball, &on_empty),
        (&empty, &ball, &on_empty, &on_ball),
    ] {
        for share in SHARES {
            let core = bvtt::PairQuery::new(a.bvh(), b.bvh(), Pose::IDENTITY).unwrap();
            let found = on_both(&gpu, &mut traversal, &core, share, |encoder, below| {
                query.record_below(encoder, on_a, on_b, &Pose::IDENTITY, below)
            });
            assert_eq!(found, []);
        }
    }
}
