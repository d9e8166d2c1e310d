//! Two meshes: scenes, soups of every hard family, every setting, and the verbs.

use crate::common::{Both, gpu, gpu_with, sorted, truth};
use pfront_core::{Pose, bvtt};
use pfront_gpu::{
    Arithmetic, Budget, Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuSettings, GpuVerb, wgpu,
};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::scenes::{Kind, Scene};
use pfront_testkit::shapes::{bumpy, family, pose_rows, posed, sheet, sphere, tangle};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Checks every verb and returns how many pairs meet.
fn check(query: &mut GpuQuery, a: &Both, b: &Both, a_from_b: &Pose) -> usize {
    let truth = truth(a, b, a_from_b);
    assert_eq!(query.all(&GpuQuestion::pair(&a.model, &b.model, a_from_b)).unwrap(), truth);
    assert_eq!(
        query.count(&GpuQuestion::pair(&a.model, &b.model, a_from_b)).unwrap(),
        truth.len() as u64
    );
    let any = query.any(&GpuQuestion::pair(&a.model, &b.model, a_from_b)).unwrap();
    assert!(any.map_or(truth.is_empty(), |pair| truth.binary_search(&pair).is_ok()));
    truth.len()
}

fn both(soup: &MeshData) -> Both {
    Both::new(&soup.positions, &soup.triangles, 4)
}

#[test]
fn scenes_of_two_bodies() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    for name in ["worm-gear", "torus-knots", "spheres", "course"] {
        let scene = Scene::by_name(name, Some(8_000)).unwrap();
        assert_eq!(scene.kind(), Kind::Pair);
        let [a, b] = [0, 1].map(|object| {
            let mesh = &scene.meshes[scene.objects[object]];
            Both::new(&mesh.positions, &mesh.triangles, 4)
        });
        let mut poses = Vec::new();
        let found: usize = (0..scene.frames())
            .step_by(scene.frames() / 12)
            .map(|frame| {
                scene.poses(frame, &mut poses);
                check(&mut query, &a, &b, &Pose::new(poses[1]))
            })
            .sum();
        assert!(found > 0, "{name}");
    }
}

#[test]
fn soups_of_every_family() {
    let mut rng = seeded(11);
    let mut query = GpuQuery::new(gpu()).unwrap();
    for (f, leaf_size) in Family::ALL.into_iter().zip([1, 4, 8].into_iter().cycle()) {
        let [a, b] = [0; 2].map(|_| {
            let soup = family(f, 60, &mut rng);
            Both::new(&soup.positions, &soup.triangles, leaf_size)
        });
        check(&mut query, &a, &b, &Pose::IDENTITY);
        if !matches!(f, Family::Huge | Family::RawBits) {
            check(&mut query, &a, &b, &Pose::new(pose_rows(0.1, &mut rng)));
        }
    }
}

#[test]
fn a_mesh_that_a_pose_brings_into_range_is_taken() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let diagonal = |k: f32| Pose::new([[k, 0.0, 0.0, 0.0], [0.0, k, 0.0, 0.0], [0.0, 0.0, k, 0.0]]);
    let scaled = |by: f32| both(&sphere(12).map(|p| p.map(|x| x * by)));
    assert!(check(&mut query, &scaled(1e35), &scaled(1e38), &diagonal(1e-3)) > 0);
    for size in [2e38, f32::MAX] {
        let refused =
            query.all(&GpuQuestion::pair(&scaled(1.0).model, &scaled(size).model, &diagonal(1e-3)));
        assert!(matches!(refused, Err(GpuError::Coordinate { axis: 0 })), "{size:e}");
    }
    let error = query
        .all(&GpuQuestion::pair(&scaled(1.0).model, &scaled(1.6e38).model, &diagonal(0.5)))
        .unwrap_err();
    let (text, source) = (error.to_string(), std::error::Error::source(&error));
    assert!(
        text.contains("beyond") && !source.is_some_and(|s| text.contains(&s.to_string())),
        "{text}"
    );
}

#[test]
fn coplanar_touching_and_stretched() {
    let mut rng = seeded(12);
    let mut query = GpuQuery::new(gpu()).unwrap();
    let flat = sheet(24, |_, _| 0.0);
    let wavy = bumpy(20);
    let (flat, wavy, ball) = (both(&flat), both(&wavy), both(&sphere(24)));
    for t in [[0.0; 3], [0.1, 0.05, 0.0], [0.0, 0.0, 1e-45], [2.0, 0.0, 0.0]] {
        assert!(check(&mut query, &flat, &flat, &Pose::from_translation(t)) > 0 || t[2] > 0.0);
    }
    for x in [2.0f32, 2.0f32.next_up(), 2.0f32.next_down()] {
        check(&mut query, &ball, &ball, &Pose::from_translation([x, 0.0, 0.0]));
    }
    for _ in 0..6 {
        check(&mut query, &flat, &wavy, &Pose::new(pose_rows(0.2, &mut rng)));
        check(&mut query, &ball, &ball, &Pose::new(pose_rows(1.0, &mut rng)));
    }
    for scale in [1e-38f32, 1e-30, 1e-3, 1e3, 1e20, 1e36] {
        let lattice = tangle(60, 120, 3, &mut rng);
        let tiny = lattice.clone().map(|p| p.map(|x| x * f32::from_bits(1)));
        let stretch = Pose::new(pose_rows(0.0, &mut rng).map(|r| r.map(|x| x * scale)));
        for soup in [lattice, tiny] {
            let placed =
                MeshData { positions: posed(&soup.positions, &stretch.rows), ..soup.clone() };
            check(&mut query, &both(&placed), &both(&soup), &stretch);
        }
    }
}

#[test]
fn nothing_and_nearly_nothing() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let (none, one) = (both(&MeshData::default()), both(&sheet(1, |_, _| 0.0)));
    assert_eq!(check(&mut query, &none, &none, &Pose::IDENTITY), 0);
    assert_eq!(check(&mut query, &one, &none, &Pose::IDENTITY), 0);
    assert_eq!(check(&mut query, &one, &one, &Pose::IDENTITY), 4);
    let mut nan = Pose::IDENTITY;
    nan.rows[0][0] = f32::NAN;
    assert!(matches!(
        query.all(&GpuQuestion::pair(&one.model, &one.model, &nan)),
        Err(GpuError::Pose(_))
    ));
}

/// Meshes of which f32 left few pairs open are asked about without `decide`, until a pose leaves many.
#[test]
fn few_open_pairs_are_left_to_the_cpu() {
    let (flat, waves) =
        (both(&sheet(24, |_, _| 0.0)), both(&sheet(24, |x, y| 0.3 * (x * y).sin())));
    let tilted = Pose::from_rotation_translation([0.6, 0.0, 0.0, 0.8], [0.1, 0.2, 0.3]);
    for budget in [Budget::LEAST, Budget { bytes: 16 << 20 }] {
        let settings = GpuSettings { budget, ..gpu().settings() };
        let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
        let mut ask = |other: &Both, pose: &Pose| {
            let question = GpuQuestion::pair(&flat.model, &other.model, pose);
            let truth = truth(&flat, other, pose);
            assert_eq!(query.all(&question).unwrap(), truth, "{budget:?}");
            assert_eq!(query.count(&question).unwrap(), truth.len() as u64, "{budget:?}");
            query.report()
        };
        assert!(ask(&waves, &tilted).triangle_pairs > 0);
        let report = ask(&waves, &tilted);
        assert!(report.on_cpu == report.open && report.open <= 64, "{report:?}");
        // Nearly all pairs are coplanar, and more than the least lists for the CPU hold.
        ask(&flat, &tilted);
        let report = ask(&flat, &Pose::IDENTITY);
        assert!(report.open > 500 && report.on_cpu == 0, "{report:?}");
        ask(&flat, &tilted);
        ask(&waves, &tilted);
    }
}

#[test]
fn every_depth_bound_and_budget_gives_the_same_list() {
    let knot = Scene::by_name("torus-knots", Some(6_000)).unwrap();
    let mut poses = Vec::new();
    knot.poses(knot.frames() / 2, &mut poses);
    let [a, b] = [0, 1].map(|i| &knot.meshes[knot.objects[i]]);
    let [a, b] = [a, b].map(|mesh| Both::new(&mesh.positions, &mesh.triangles, 4));
    // Two sheets in one plane: most of their pairs meet, and f32 decides none of them.
    let flat = both(&sheet(40, |_, _| 0.0));
    let scenes = [(&a, &b, Pose::new(poses[1])), (&flat, &flat, Pose::IDENTITY)];
    let truths = scenes.map(|(a, b, pose)| truth(a, b, &pose));
    assert!(truths[0].len() > 500 && truths[1].len() > 30_000);
    for (budget, depth) in [
        (Budget::LEAST, 4),
        (Budget { bytes: 100_000 }, 2),
        (Budget { bytes: 1 << 20 }, 3),
        (Budget { bytes: 16 << 20 }, 1),
    ] {
        let settings = GpuSettings { depth, budget, ..gpu().settings() };
        let (mut query, bytes) = (GpuQuery::with_settings(gpu(), settings).unwrap(), budget.bytes);
        // Coplanar ones in so little memory take thousands of runs.
        let asked = if budget == Budget::LEAST { 1 } else { scenes.len() };
        for ((a, b, pose), truth) in scenes.iter().zip(&truths).take(asked) {
            let found = query.all(&GpuQuestion::pair(&a.model, &b.model, pose)).unwrap();
            assert!(found == truth, "depth {depth}, {bytes} bytes: {} pairs", found.len());
            let report = query.report();
            assert_eq!(report.on_cpu, 0, "these coordinates fit in the integers of the device");
            let one = bytes >= 16 << 20 || (bytes >= 1 << 20 && truth.len() < 10_000);
            assert_eq!(report.runs == 1, one, "{bytes} bytes: {report:?}");
        }
    }
    let too_small = Budget { bytes: Budget::LEAST.bytes - 1 };
    let settings = GpuSettings { budget: too_small, ..gpu().settings() };
    let refused = GpuQuery::with_settings(gpu(), settings).unwrap_err();
    assert_eq!(refused, GpuError::Budget { bytes: 65_535, least: 65_536 });
}

#[test]
fn every_verb_within_the_least_budget() {
    let settings = GpuSettings { budget: Budget::LEAST, ..gpu().settings() };
    let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
    let flat = both(&sheet(20, |_, _| 0.0));
    assert!(check(&mut query, &flat, &flat, &Pose::IDENTITY) > 8_000);
    assert_eq!(check(&mut query, &flat, &flat, &Pose::from_translation([0.0, 0.0, 1.0])), 0);
}

/// An encoder of the caller's.
fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

#[test]
fn a_question_is_recorded_now_and_read_later() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let (ball, mut pairs) = (both(&sphere(16)), Vec::new());
    let pose = Pose::from_translation([0.7, 0.1, 0.2]);
    let question = GpuQuestion::pair(&ball.model, &ball.model, &pose);
    let truth = truth(&ball, &ball, &pose);
    for _ in 0..3 {
        let mut encoder = encoder(gpu());
        query.record(&mut encoder, &question, GpuVerb::All).unwrap();
        gpu().queue().submit([encoder.finish()]);
        assert_eq!(query.read(&mut pairs).unwrap(), truth.len() as u64);
        assert_eq!(pairs, truth);
        // It is read once.
        assert_eq!((query.read(&mut pairs).unwrap(), pairs.len()), (0, 0));
    }
    query.record(&mut encoder(gpu()), &question, GpuVerb::All).unwrap();
    assert_eq!(query.read(&mut pairs).unwrap_err(), GpuError::NotSubmitted);
    assert_eq!(query.all(&question).unwrap(), truth);
    query.submit(&question, GpuVerb::CountEach).unwrap();
    assert_eq!(query.read(&mut pairs).unwrap(), truth.len() as u64);
    query.submit(&question, GpuVerb::AnyEach).unwrap();
    assert!(query.read(&mut pairs).unwrap() > 0 && truth.contains(&pairs[0]));
}

#[test]
fn answers_are_read_after_their_own_submissions() {
    let own = Gpu::new().unwrap();
    let (ball, mut pairs) = (both(&sphere(6)), Vec::new());
    let model = GpuModel::new(&own, ball.bvh()).unwrap();
    let flat = GpuModel::new(&own, both(&sheet(40, |_, _| 0.0)).bvh()).unwrap();
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    let met = truth(&ball, &ball, &pose);
    let questions = [
        GpuQuestion::pair(&model, &model, &pose),
        GpuQuestion::pair(&flat, &flat, &Pose::IDENTITY),
    ];
    let [mut first, mut later] = [0; 2].map(|_| GpuQuery::new(&own).unwrap());
    let (mut one, mut other) = (encoder(&own), encoder(&own));
    first.record(&mut one, &questions[0], GpuVerb::All).unwrap();
    later.record(&mut other, &questions[1], GpuVerb::All).unwrap();
    own.queue().submit([one.finish()]);
    own.queue().submit([other.finish()]);
    while !later.is_ready().unwrap() {}
    // A queue works in order, and both stay as they are until they are read.
    assert!(first.is_ready().unwrap() && later.is_ready().unwrap());
    first.read(&mut pairs).unwrap();
    assert_eq!(pairs, met);
    assert!(later.read(&mut pairs).unwrap() > 20_000);
    // A question that is ready may still be replaced by another.
    first.submit(&questions[0], GpuVerb::All).unwrap();
    while !first.is_ready().unwrap() {}
    first.submit(&questions[1], GpuVerb::Count).unwrap();
    assert!(first.read(&mut pairs).unwrap() > 20_000);
    first.submit(&questions[0], GpuVerb::All).unwrap();
    first.is_ready().unwrap();
    assert_eq!(first.all(&questions[0]).unwrap(), met);
}

#[test]
fn the_parts_of_a_question_are_those_of_the_next() {
    let settings = GpuSettings { budget: Budget::LEAST, ..gpu().settings() };
    let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
    let flat = both(&sheet(20, |_, _| 0.0));
    let mut runs = |pose: Pose| {
        let found = query.all(&GpuQuestion::pair(&flat.model, &flat.model, &pose)).unwrap();
        assert_eq!(found, truth(&flat, &flat, &pose));
        query.report().runs
    };
    let [first, second] = [0.0, 0.01].map(|x| runs(Pose::from_translation([x, 0.0, 0.0])));
    assert!(second > 1 && second < first, "{first} and {second} runs");
    // Where little is left, parts are joined, until there is one.
    let apart = [0; 5].map(|_| runs(Pose::from_translation([0.0, 0.0, 1.0])));
    assert!(apart[0] > 1 && apart.is_sorted_by(|x, y| x >= y) && apart[4] == 1, "{apart:?}");
    // Within one model there are other node pairs.
    runs(Pose::IDENTITY);
    let within = GpuQuestion::itself(&flat.model);
    let truth = sorted(&bvtt::SelfBvtt::new(flat.bvh()));
    for _ in 0..2 {
        assert_eq!(query.all(&within).unwrap(), truth);
        assert_eq!(query.count(&within).unwrap(), truth.len() as u64);
    }
}

/// The parts that a question was divided into cover the next one as well, in whose pose other boxes overlap.
#[test]
fn parts_serve_questions_in_other_poses() {
    let turn = |angle: f32| {
        Pose::from_rotation_translation([0.0, 0.0, angle.sin(), angle.cos()], [0.0; 3])
    };
    for (budget, rings) in [(Budget::LEAST, 12), (Budget { bytes: 1 << 18 }, 24)] {
        let ball = both(&bumpy(rings));
        let settings = GpuSettings { budget, ..gpu().settings() };
        let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
        for pose in [Pose::IDENTITY, turn(0.05), turn(1.0), Pose::from_translation([0.5, 0.0, 0.1])]
        {
            assert!(check(&mut query, &ball, &ball, &pose) > 0);
        }
        let moved = Pose::from_translation([0.3, 0.2, 0.0]);
        let question = GpuQuestion::pair(&ball.model, &ball.model, &Pose::IDENTITY);
        for pose in [turn(0.5), moved] {
            query.all(&question).unwrap();
            assert!(query.report().runs > 1);
            check(&mut query, &ball, &ball, &pose);
        }
    }
}

#[test]
fn any_stops_at_a_hit() {
    let settings = GpuSettings { groups: 4, ..gpu().settings() };
    let mut query = GpuQuery::with_settings(gpu(), settings).unwrap();
    let flat = both(&sheet(48, |_, _| 0.0));
    let (here, apart) = (Pose::IDENTITY, Pose::from_translation([0.0, 0.0, 1.0]));
    let count = query.count(&GpuQuestion::pair(&flat.model, &flat.model, &here)).unwrap();
    let all = query.report();
    let any = query.any(&GpuQuestion::pair(&flat.model, &flat.model, &here)).unwrap().unwrap();
    let one = query.report();
    assert!(truth(&flat, &flat, &here).binary_search(&any).is_ok() && count > 40_000);
    assert!(one.leaf_pairs * 8 < all.leaf_pairs, "{one:?} of {all:?}");
    assert!(one.triangle_pairs * 8 < all.triangle_pairs, "{one:?} of {all:?}");
    assert_eq!(query.any(&GpuQuestion::pair(&flat.model, &flat.model, &apart)).unwrap(), None);
}

#[test]
fn a_question_that_was_not_read_leaves_no_trace_in_the_next() {
    let mut query = GpuQuery::new(gpu()).unwrap();
    let (ball, mut pairs) = (both(&sphere(16)), Vec::new());
    let poses = [[0.3, 0.1, 0.2], [0.7, 0.1, 0.2]].map(Pose::from_translation);
    let encoders = poses.map(|pose| {
        let mut encoder = encoder(gpu());
        let question = GpuQuestion::pair(&ball.model, &ball.model, &pose);
        query.record(&mut encoder, &question, GpuVerb::All).unwrap();
        encoder.finish()
    });
    gpu().queue().submit(encoders);
    query.read(&mut pairs).unwrap();
    assert_eq!(pairs, truth(&ball, &ball, &poses[1]));
}

/// Commands that were recorded for the next question serve it only if they suit it.
#[test]
fn any_question_follows_any_other() {
    let mut rng = seeded(14);
    let (ball, wavy, small) = (both(&sphere(20)), both(&bumpy(16)), both(&sphere(6)));
    let pairs = [[&ball, &wavy], [&ball, &small], [&wavy, &wavy]];
    let (mut query, mut found) = (GpuQuery::new(gpu()).unwrap(), Vec::new());
    let mut sums = [0, 0];
    for round in 0..120 {
        // The models and the verb change every few rounds.
        let [a, b] = pairs[round / 9 % 3];
        let verb = [GpuVerb::All, GpuVerb::All, GpuVerb::Any, GpuVerb::Count][round / 7 % 4];
        let reach = [0.1, 3.0, 0.5][round % 3];
        let pose = Pose::new(pose_rows(reach, &mut rng));
        let question = GpuQuestion::pair(&a.model, &b.model, &pose);
        if rng.random_range(0..4) == 0 {
            let mut encoder = encoder(gpu());
            query.record(&mut encoder, &question, verb).unwrap();
            gpu().queue().submit([encoder.finish()]);
        } else {
            query.submit(&question, verb).unwrap();
        }
        if rng.random_range(0..3) == 0 {
            query.is_ready().unwrap();
        }
        if rng.random_range(0..5) == 0 {
            continue;
        }
        let count = query.read(&mut found).unwrap();
        let truth = truth(a, b, &pose);
        match verb {
            GpuVerb::All => assert_eq!(found, truth, "{round}"),
            GpuVerb::Any => assert!(
                found.first().map_or(truth.is_empty(), |pair| truth.binary_search(pair).is_ok()),
                "{round}"
            ),
            _ => assert_eq!(count, truth.len() as u64, "{round}"),
        }
        sums[usize::from(truth.is_empty())] += 1;
    }
    assert!(sums[0] > 20 && sums[1] > 5, "{sums:?}");
}

#[test]
fn integers_pose_to_the_same_bits() {
    let mut rng = seeded(13);
    let gpu = gpu_with(Arithmetic::Integer);
    let mut query = GpuQuery::new(gpu).unwrap();
    for f in [Family::Random, Family::CoplanarRotated, Family::Scaled, Family::Subnormal] {
        let soups = [0; 2].map(|_| both(&family(f, 100, &mut rng)));
        check(&mut query, &soups[0], &soups[1], &Pose::new(pose_rows(0.1, &mut rng)));
    }
    let ball = both(&sphere(24));
    assert!(check(&mut query, &ball, &ball, &Pose::new(pose_rows(1.0, &mut rng))) > 0);
}

#[test]
fn passes_are_timed_if_the_device_can_tell() {
    let mut query = GpuQuery::new(gpu()).unwrap().with_timings().unwrap();
    let ball = both(&sphere(16));
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    assert_eq!(
        query.all(&GpuQuestion::pair(&ball.model, &ball.model, &pose)).unwrap(),
        truth(&ball, &ball, &pose)
    );
    let timings = query.timings().unwrap();
    if gpu().device().features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES) {
        let passes: Vec<_> = timings.iter().map(|timing| timing.pass).collect();
        assert_eq!((passes[0], passes[passes.len() - 1]), ("seed", "order"));
        assert!(timings.iter().any(|timing| !timing.time.is_zero()));
    } else {
        assert!(timings.is_empty());
    }
}

#[test]
fn a_device_of_the_callers_will_do() {
    let own = Gpu::from_device(gpu().device().clone(), gpu().queue().clone()).unwrap();
    let ball = both(&sphere(12));
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    let mut query = GpuQuery::new(&own).unwrap();
    assert_eq!(
        query.all(&GpuQuestion::pair(&ball.model, &ball.model, &pose)).unwrap_err(),
        GpuError::OtherDevice
    );
    let model = GpuModel::new(&own, ball.bvh()).unwrap();
    assert_eq!(
        query.all(&GpuQuestion::pair(&model, &model, &pose)).unwrap(),
        truth(&ball, &ball, &pose)
    );
}

#[test]
fn errors_of_the_caller_stay_with_the_caller() {
    let own = Gpu::new().unwrap();
    let seen = Arc::new(AtomicUsize::new(0));
    let count = seen.clone();
    own.device().on_uncaptured_error(Arc::new(move |_| _ = count.fetch_add(1, Ordering::Relaxed)));
    let ball = both(&sphere(12));
    let model = GpuModel::new(&own, ball.bvh()).unwrap();
    let mut query = GpuQuery::new(&own).unwrap();
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    let _invalid = own.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4,
        usage: wgpu::BufferUsages::empty(),
        mapped_at_creation: false,
    });
    assert_eq!(
        query.all(&GpuQuestion::pair(&model, &model, &pose)).unwrap(),
        truth(&ball, &ball, &pose)
    );
    assert_eq!(seen.load(Ordering::Relaxed), 1);
}

#[test]
fn a_lost_device_is_an_error_and_another_goes_on() {
    let lost = Gpu::new().unwrap();
    let ball = both(&sphere(12));
    let model = GpuModel::new(&lost, ball.bvh()).unwrap();
    let mut query = GpuQuery::new(&lost).unwrap();
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    assert_eq!(
        query.all(&GpuQuestion::pair(&model, &model, &pose)).unwrap(),
        truth(&ball, &ball, &pose)
    );
    lost.device().destroy();
    let error = query.all(&GpuQuestion::pair(&model, &model, &pose)).unwrap_err();
    assert!(matches!(error, GpuError::DeviceLost { .. }), "{error:?}");
    assert!(matches!(GpuModel::new(&lost, ball.bvh()), Err(GpuError::DeviceLost { .. })));
    let next = Gpu::new().unwrap();
    let model = GpuModel::new(&next, ball.bvh()).unwrap();
    let found = GpuQuery::new(&next)
        .unwrap()
        .all(&GpuQuestion::pair(&model, &model, &pose))
        .unwrap()
        .to_vec();
    assert_eq!(found, truth(&ball, &ball, &pose));
}

/// The list of one query is still mapped when another finds that the device is lost.
#[test]
fn a_list_outlives_the_device() {
    let lost = Gpu::new().unwrap();
    let ball = both(&sphere(12));
    let model = GpuModel::new(&lost, ball.bvh()).unwrap();
    let [mut first, mut second] = [0; 2].map(|_| GpuQuery::new(&lost).unwrap());
    let pose = Pose::from_translation([0.3, 0.0, 0.0]);
    let question = GpuQuestion::pair(&model, &model, &pose);
    let shown = first.all(&question).unwrap();
    lost.device().destroy();
    let error = second.all(&question).unwrap_err();
    assert!(matches!(error, GpuError::DeviceLost { .. }), "{error:?}");
    assert_eq!(shown, truth(&ball, &ball, &pose));
    assert!(first.all(&question).is_err());
    drop((first, second));
}
