//! Many bodies: scenes, random courses, bodies that come and go, and poses at the ends of the range.

use crate::common::gpu;
use crate::world::{Part, World};
use pfront_core::bvtt::TrianglePair;
use pfront_core::{MeshError, Pose};
use pfront_gpu::{Arithmetic, Budget, Error, Gpu, SceneQuery, Settings};
use pfront_scenes::{Kind, Scene};
use pfront_testkit::families::Family;
use pfront_testkit::rng::{ChaCha8Rng, Rng, seeded};
use pfront_testkit::shapes::{Soup, family, pose_rows, sheet, sphere};

fn query() -> SceneQuery {
    SceneQuery::new(gpu()).unwrap()
}

/// Anywhere in a cube of the given size, half the time turned.
fn somewhere(size: f32, rng: &mut ChaCha8Rng) -> Pose {
    let mut pose = Pose::new(if rng.next_u32().is_multiple_of(2) {
        Pose::IDENTITY.rows
    } else {
        pose_rows(0.0, rng)
    });
    for row in &mut pose.rows {
        row[3] = size * (rng.next_u32() as f32 / u32::MAX as f32 - 0.5);
    }
    pose
}

#[test]
fn a_train_of_gears() {
    let scene = Scene::by_name("epicyclic", Some(1)).unwrap();
    assert_eq!(scene.kind(), Kind::Many);
    let parts: Vec<_> =
        scene.meshes.iter().map(|mesh| Part::new(&mesh.positions, &mesh.triangles, 4)).collect();
    let (mut world, mut poses, mut found) = (World::new(query()), Vec::new(), 0);
    for frame in (0..scene.frames()).step_by(scene.frames() / 3) {
        scene.poses(frame, &mut poses);
        for (index, (&mesh, &rows)) in scene.objects.iter().zip(&poses).enumerate() {
            match frame {
                0 => _ = world.add(&parts[mesh], Pose::new(rows)),
                _ => world.set_pose(index, Pose::new(rows)),
            }
        }
        found += world.check();
    }
    assert!(found > 0);
}

#[test]
fn bodies_that_move_jump_rest_come_and_go() {
    let mut rng = seeded(31);
    let parts = [
        Part::of(&sphere(10)),
        Part::new(&sphere(4).positions, &sphere(4).triangles, 1),
        Part::of(&sheet(5, |x, y| 0.3 * x * y)),
        Part::of(&sheet(1, |_, _| 0.0)),
        Part::of(&Soup::default()),
    ];
    let mut world = World::new(query());
    for i in 0..36 {
        world.add(&parts[i % parts.len()], somewhere(8.0, &mut rng));
    }
    let mut found = world.check();
    for frame in 0..12 {
        match frame % 4 {
            // Nobody moves.
            0 => {}
            // One in three goes somewhere else.
            1 => (0..world.bodies.len())
                .step_by(3)
                .for_each(|i| world.set_pose(i, somewhere(8.0, &mut rng))),
            // All drift.
            2 => {
                for i in 0..world.bodies.len() {
                    let mut pose = world.query.body(world.bodies[i].0).unwrap().pose();
                    pose.rows[frame % 3][3] += 0.1;
                    world.set_pose(i, pose);
                }
            }
            _ => {
                world.remove(frame);
                world.remove(0);
                world.add(&parts[frame % parts.len()], somewhere(2.0, &mut rng));
            }
        }
        found += world.check();
    }
    assert!(found > 1_000, "{found}");
}

#[test]
fn nobody_somebody_and_somebody_who_is_nothing() {
    let [none, one] = [Soup::default(), sheet(1, |_, _| 0.0)].map(|soup| Part::of(&soup));
    let mut world = World::new(query());
    assert!(world.query.is_empty());
    assert_eq!(world.check(), 0);
    world.add(&none, Pose::IDENTITY);
    world.add(&none, Pose::IDENTITY);
    assert_eq!(world.check(), 0);
    let id = world.add(&one, Pose::IDENTITY);
    assert_eq!((world.check(), world.query.bytes()), (0, 0));
    world.add(&one, Pose::from_translation([0.5, 0.0, 0.0]));
    assert!(world.check() > 0);
    assert!(world.query.bytes() > 0);

    let mut broken = Pose::IDENTITY;
    broken.rows[2][1] = f32::NAN;
    assert!(matches!(world.query.set_pose(id, broken), Err(Error::Pose(_))));
    assert!(matches!(world.query.add(one.shape.clone(), broken), Err(Error::Pose(_))));
    assert!(world.check() > 0);
    (0..4).for_each(|_| world.remove(0));
    assert_eq!(world.check(), 0);
}

/// Soups in many poses: coordinates that are subnormal, huge, in one plane, in one place.
fn hard_cases(gpu: &Gpu, families: &[Family], seed: u64) {
    let mut rng = seeded(seed);
    let mut query = SceneQuery::new(gpu).unwrap();
    for &f in families {
        let parts = [0; 2].map(|_| Part::of(&family(f, 60, &mut rng)));
        let mut world = World::new(query);
        for part in [&parts[0], &parts[1], &parts[0]] {
            world.add(part, Pose::IDENTITY);
        }
        world.check();
        for (reach, scale) in [(0.1, 1.0), (0.0, 1e-38), (0.0, 1e-30), (0.1, 1e3)] {
            for i in 1..3 {
                let rows = pose_rows(reach, &mut rng).map(|row| row.map(|x| x * scale));
                // Stays where it is if this would take it out of range.
                _ = world.query.set_pose(world.bodies[i].0, Pose::new(rows));
            }
            world.check();
        }
        (0..3).for_each(|_| world.remove(0));
        query = world.query;
    }
}

#[test]
fn poses_at_the_ends_of_the_range() {
    hard_cases(gpu(), &Family::ALL, 32);
    let ball = Part::of(&sphere(8));
    for scale in [f32::from_bits(300), f32::MIN_POSITIVE, 1e-20, 1e36] {
        let mut world = World::new(query());
        for x in [0.0, 0.7, 1.4, 9.0] {
            let mut pose = Pose::from_translation([x, 0.1 * x, 0.0]);
            pose.rows.iter_mut().flatten().for_each(|entry| *entry *= scale);
            world.add(&ball, pose);
        }
        assert!(world.check() > 0, "{scale:e}");
    }
}

#[test]
fn whatever_the_adapter_does_to_subnormal_numbers() {
    for arithmetic in [Arithmetic::Flushing, Arithmetic::Integer] {
        let gpu = gpu().with_arithmetic(arithmetic).unwrap();
        hard_cases(&gpu, &[Family::Random, Family::MixedScale, Family::Subnormal], 33);
    }
}

#[test]
fn every_budget_and_depth_gives_the_same_list() {
    let parts = [Part::of(&sphere(8)), Part::of(&sheet(8, |_, _| 0.0))];
    for bytes in [Budget::LEAST.bytes, 1 << 20] {
        for depth in [1, 9] {
            let settings = Settings { depth, budget: Budget { bytes }, ..gpu().settings() };
            let mut world = World::new(SceneQuery::with_settings(gpu(), settings).unwrap());
            for i in 0..6 {
                world.add(&parts[i % 2], Pose::from_translation([0.3 * i as f32, 0.0, 0.0]));
            }
            world.check();
            assert!(world.query.all().unwrap().len() > 1_000);
            assert!(bytes > Budget::LEAST.bytes || world.query.report().runs > 1);
        }
    }
    // More pairs of bodies than the least front holds.
    let settings = Settings { budget: Budget::LEAST, ..gpu().settings() };
    let mut world = World::new(SceneQuery::with_settings(gpu(), settings).unwrap());
    let one = Part::of(&sheet(1, |_, _| 0.0));
    for i in 0..100 {
        world.add(&one, Pose::from_translation([0.0, 0.0, (i % 2) as f32]));
    }
    assert_eq!(world.check(), 4 * 2 * (50 * 49 / 2));
}

#[test]
fn bodies_that_deform() {
    let (ball, base) = (Part::of(&sphere(8)), sheet(10, |x, y| 0.2 * x * y));
    let mut cloths = [0; 2].map(|_| Part::of(&base));
    let mut query = query();
    let turned = Pose::new(pose_rows(0.2, &mut seeded(34)));
    let own =
        [turned, Pose::IDENTITY].map(|pose| query.add(cloths[0].shape.clone(), pose).unwrap());
    let mut found = 0;
    for frame in 0..6 {
        let time = frame as f32;
        // Both begin with one shape; at last one comes after vertices have moved.
        for (i, cloth) in cloths.iter_mut().enumerate() {
            let wave = |[x, y, z]: [f32; 3]| [x, y, z + 0.3 * (4.0 * x + time + i as f32).sin()];
            let positions: Vec<_> = base.positions.iter().map(|&p| wave(p)).collect();
            cloth.both.set_positions(&positions);
            query.set_positions(own[i], &positions).unwrap();
            assert_eq!(query.body(own[i]).unwrap().shape().mesh().positions(), positions);
        }
        let mut world = World { query, bodies: own.into_iter().zip(&cloths).collect() };
        if frame >= 3 {
            let id = match frame {
                3 => world.query.add(ball.shape.clone(), Pose::IDENTITY).unwrap(),
                _ => world.query.bodies().last().unwrap().id(),
            };
            world.bodies.push((id, &ball));
        }
        found += world.check();
        query = world.query;
    }
    assert!(found > 0);
    assert_eq!(ball.shape.mesh().positions(), sphere(8).positions);

    let refused = query.set_positions(own[0], &base.positions[1..]).unwrap_err();
    assert!(matches!(refused, Error::Mesh(MeshError::VertexCount { expected: 121, found: 120 })));
    let huge = vec![[f32::MAX; 3]; 121];
    assert!(matches!(query.set_positions(own[0], &huge), Err(Error::Pose(_))));
    query.set_positions(own[1], &huge).unwrap();
    assert_eq!(query.all().unwrap().iter().find(|hit| hit.bodies.contains(&own[1])), None);
}

#[test]
fn a_frame_is_recorded_now_and_read_later() {
    let ball = Part::of(&sphere(10));
    let mut world = World::new(query());
    for x in [0.0, 0.6, 1.2, 30.0] {
        world.add(&ball, Pose::from_translation([x, 0.0, 0.1]));
    }
    for frame in 0..3 {
        world.set_pose(3, Pose::from_translation([0.3 * frame as f32, 0.2, 0.0]));
        let truth = world.truth();
        let mut encoder = gpu().device().create_command_encoder(&Default::default());
        let pending = world.query.record(&mut encoder).unwrap();
        gpu().queue().submit([encoder.finish()]);
        assert!(pending.read().unwrap() == truth);
    }
    // What was never submitted has moved nobody.
    world.set_pose(3, Pose::from_translation([0.0, 0.9, 0.0]));
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    let pending = world.query.record(&mut encoder).unwrap();
    assert_eq!(pending.read().unwrap_err(), Error::NotSubmitted);
    assert!(world.check() > 0);
    for i in 0..4 {
        world.set_pose(i, Pose::from_translation([9.0 * i as f32, 0.0, 0.0]));
    }
    let mut encoder = gpu().device().create_command_encoder(&Default::default());
    assert_eq!(world.query.record(&mut encoder).unwrap().read().unwrap(), []);
}

#[test]
fn passes_are_timed_if_the_device_can_tell() {
    let ball = Part::of(&sphere(8));
    let mut world = World::new(query().with_timings().unwrap());
    world.add(&ball, Pose::IDENTITY);
    let other = world.add(&ball, Pose::from_translation([0.4, 0.0, 0.0]));
    assert!(world.query.count().unwrap() > 0);
    let passes = |query: &SceneQuery| -> Vec<&str> {
        query.timings().unwrap().iter().map(|timing| timing.pass).collect()
    };
    let first = passes(&world.query);
    world.query.count().unwrap();
    let second = passes(&world.query);
    world.query.set_pose(other, Pose::from_translation([0.5, 0.0, 0.0])).unwrap();
    world.query.count().unwrap();
    assert_eq!(passes(&world.query), first);
    if let [pose, refit, ..] = first[..] {
        assert_eq!((pose, refit), ("pose", "refit"));
        // Nobody had moved.
        assert!(first.ends_with(&second) && second[0] == "expand");
    }
    let pair: TrianglePair = world.query.any().unwrap().unwrap().pair;
    assert!(pair.a < 10_000 && pair.b < 10_000);
}
