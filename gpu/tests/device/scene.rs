//! Many bodies: scenes, random courses, bodies that come and go, and poses at the ends of the range.

use crate::common::{Both, gpu, gpu_with};
use crate::world::{Scene, part};
use pfront_core::{MeshError, Pose};
use pfront_gpu::{Arithmetic, BodyPair, Budget, Gpu, GpuError, GpuSettings, GpuVerb, World, wgpu};
use pfront_testkit::MeshData;
use pfront_testkit::families::Family;
use pfront_testkit::rng::{ChaCha8Rng, Rng, seeded};
use pfront_testkit::scenes::{self, Kind};
use pfront_testkit::shapes::{family, pose_rows, sheet, sphere};

fn world() -> World {
    World::new(gpu(), gpu().settings()).unwrap()
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
fn bodies_that_circle_through_each_other() {
    let swarm = scenes::Scene::by_name("swarm", Some(10_000)).unwrap();
    assert_eq!(swarm.kind(), Kind::Many);
    let meshes = swarm.meshes.iter();
    let parts: Vec<_> = meshes.map(|mesh| Both::new(&mesh.positions, &mesh.triangles, 4)).collect();
    let bodies = swarm.objects.iter().map(|&mesh| (&parts[mesh], Pose::IDENTITY)).collect();
    let (mut scene, mut poses, mut found) = (Scene::new(world(), bodies), Vec::new(), 0);
    for frame in (0..swarm.frames()).step_by(swarm.frames() / 3) {
        swarm.poses(frame, &mut poses);
        for (number, &rows) in poses.iter().enumerate() {
            scene.set_pose(number, Pose::new(rows)).unwrap();
        }
        found += scene.check();
    }
    assert!(found > 0);
}

#[test]
fn bodies_that_move_jump_rest_come_and_go() {
    let mut rng = seeded(31);
    let small = sphere(4);
    let parts = [
        part(&sphere(10)),
        Both::new(&small.positions, &small.triangles, 1),
        part(&sheet(5, |x, y| 0.3 * x * y)),
        part(&sheet(1, |_, _| 0.0)),
        part(&MeshData::default()),
    ];
    let bodies = (0..36).map(|i| (&parts[i % parts.len()], somewhere(8.0, &mut rng))).collect();
    let mut scene = Scene::new(world(), bodies);
    let mut found = scene.check();
    for frame in 0..12 {
        match frame % 4 {
            // Nothing moves.
            0 => {}
            // One in three goes somewhere else.
            1 => (0..scene.bodies.len())
                .step_by(3)
                .for_each(|i| scene.set_pose(i, somewhere(8.0, &mut rng)).unwrap()),
            // All drift.
            2 => {
                for i in 0..scene.bodies.len() {
                    let mut pose = scene.bodies[i].1;
                    pose.rows[frame % 3][3] += 0.1;
                    scene.set_pose(i, pose).unwrap();
                }
            }
            _ => {
                scene.bodies.remove(frame);
                scene.bodies.remove(0);
                scene.bodies.push((&parts[frame % parts.len()], somewhere(2.0, &mut rng)));
                scene.gather();
            }
        }
        found += scene.check();
    }
    assert!(found > 1_000, "{found}");
}

#[test]
fn no_body_one_body_and_bodies_without_triangles() {
    let [none, one] = [MeshData::default(), sheet(1, |_, _| 0.0)].map(|soup| part(&soup));
    let mut scene = Scene::new(world(), Vec::new());
    assert_eq!((scene.check(), scene.world.bytes()), (0, 0));
    scene.bodies.extend([(&none, Pose::IDENTITY); 2]);
    scene.gather();
    assert_eq!((scene.check(), scene.world.bytes()), (0, 0));
    scene.bodies.push((&one, Pose::IDENTITY));
    scene.gather();
    assert_eq!(scene.check(), 0);
    scene.bodies.push((&one, Pose::from_translation([0.5, 0.0, 0.0])));
    scene.gather();
    assert!(scene.check() > 0 && scene.world.bytes() > 0);

    let mut broken = Pose::IDENTITY;
    broken.rows[2][1] = f32::NAN;
    assert!(matches!(scene.set_pose(3, broken), Err(GpuError::Pose(_))));
    assert!(scene.check() > 0);
    let missing = GpuError::NoBody { body: 4, bodies: 4 };
    assert_eq!(scene.world.set_pose(4, Pose::IDENTITY).unwrap_err(), missing);
    assert_eq!(scene.world.count(&[[0, 1], [3, 4]]).unwrap_err(), missing);
    let missing = GpuError::NoMesh { mesh: 2, meshes: 2 };
    assert_eq!(scene.world.set_positions(2, &[]).unwrap_err(), missing);
    assert_eq!(scene.world.set_bodies(&[(2, Pose::IDENTITY)]).unwrap_err(), missing);
    assert!(matches!(scene.world.set_bodies(&[(1, broken)]), Err(GpuError::Pose(_))));
    assert_eq!(scene.world.read().unwrap_err(), GpuError::NotSubmitted);
    assert!(scene.check() > 0);
    scene.bodies.clear();
    scene.gather();
    assert_eq!(scene.check(), 0);
}

/// Soups in many poses: coordinates that are subnormal, huge, in one plane, in one place.
fn hard_cases(gpu: &Gpu, families: &[Family], seed: u64) {
    let mut rng = seeded(seed);
    let mut world = World::new(gpu, gpu.settings()).unwrap();
    for (number, &f) in families.iter().enumerate() {
        let parts = [0; 2].map(|_| part(&family(f, 28, &mut rng)));
        let bodies = [0, 1, 0].map(|i| (&parts[i], Pose::IDENTITY)).to_vec();
        let mut scene = Scene::new(world, bodies);
        scene.check();
        // Two of four a family: every second one is flushed, or nearly so.
        let scales = [(0.1, 1.0), (0.0, 1e-38), (0.0, 1e-30), (0.1, 1e3)];
        for &(reach, scale) in scales.iter().skip(number % 2).step_by(2) {
            for i in 1..3 {
                let rows = pose_rows(reach, &mut rng).map(|row| row.map(|x| x * scale));
                // It stays where it is if this would take it out of range.
                _ = scene.set_pose(i, Pose::new(rows));
            }
            scene.check();
        }
        world = scene.world;
    }
}

#[test]
fn poses_at_the_ends_of_the_range() {
    hard_cases(gpu(), &Family::ALL, 32);
    let ball = part(&sphere(8));
    for scale in [f32::from_bits(300), f32::MIN_POSITIVE, 1e-20, 1e36] {
        let bodies = [0.0, 0.7, 1.4, 9.0].map(|x| {
            let mut pose = Pose::from_translation([x, 0.1 * x, 0.0]);
            pose.rows.iter_mut().flatten().for_each(|entry| *entry *= scale);
            (&ball, pose)
        });
        let mut scene = Scene::new(world(), bodies.to_vec());
        assert!(scene.check() > 0, "{scale:e}");
    }
}

#[test]
fn whatever_the_adapter_does_to_subnormal_numbers() {
    for arithmetic in [Arithmetic::Flushing, Arithmetic::Integer] {
        let gpu = gpu_with(arithmetic);
        hard_cases(gpu, &[Family::Random, Family::MixedScale, Family::Subnormal], 33);
    }
}

#[test]
fn every_budget_and_depth_gives_the_same_list() {
    let parts = [part(&sphere(8)), part(&sheet(8, |_, _| 0.0))];
    for (bytes, depth) in [(Budget::LEAST.bytes, 1), (1 << 20, 9)] {
        let settings = GpuSettings { depth, budget: Budget { bytes }, ..gpu().settings() };
        let at = |i: usize| Pose::from_translation([0.3 * i as f32, 0.0, 0.0]);
        let bodies = (0..6).map(|i| (&parts[i % 2], at(i))).collect();
        let mut scene = Scene::new(World::new(gpu(), settings).unwrap(), bodies);
        assert!(scene.check() > 1_000);
        let pairs = scene.pairs();
        scene.world.all(&pairs).unwrap();
        assert!(bytes > Budget::LEAST.bytes || scene.world.report().runs > 1);
    }
    // More pairs of bodies than the least front holds.
    let settings = GpuSettings { budget: Budget::LEAST, ..gpu().settings() };
    let one = part(&sheet(1, |_, _| 0.0));
    let at = |i: usize| Pose::from_translation([0.0, 0.0, (i % 2) as f32]);
    let bodies = (0..100).map(|i| (&one, at(i))).collect();
    let mut scene = Scene::new(World::new(gpu(), settings).unwrap(), bodies);
    assert_eq!(scene.check(), 4 * 2 * (50 * 49 / 2));
}

/// A device that binds so little that pairs of bodies are asked in chunks.
#[test]
fn more_pairs_than_a_binding_holds() {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let limits =
        wgpu::Limits { max_storage_buffer_binding_size: 2 << 20, ..wgpu::Limits::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let gpu = Gpu::from_device(device, queue).unwrap();
    let settings = GpuSettings { budget: Budget { bytes: 4 << 20 }, ..gpu.settings() };
    let mut rng = seeded(35);
    let parts = [part(&sphere(3)), part(&sheet(2, |x, y| 0.3 * x * y)), part(&MeshData::default())];
    let bodies = (0..40).map(|i| (&parts[i % 3], somewhere(3.0, &mut rng))).collect();
    let mut scene = Scene::new(World::new(&gpu, settings).unwrap(), bodies);
    assert!(scene.check() > 100);

    // Each pair many times and both ways; what moves after the submission moves too late.
    const TIMES: usize = 18;
    let turned =
        |[a, b]: BodyPair| (0..TIMES).map(move |i| if i % 2 == 0 { [a, b] } else { [b, a] });
    let pairs: Vec<_> = scene.pairs().into_iter().flat_map(turned).collect();
    let counts = scene.world.count_each(&pairs).unwrap().to_vec();
    let each = scene.world.any_each(&pairs).unwrap();
    assert!(each.iter().zip(&counts).all(|(hit, &count)| hit.is_some() == (count != 0)));
    scene.world.submit(&pairs, GpuVerb::CountEach).unwrap();
    for number in 0..40 {
        scene.set_pose(number, somewhere(3.0, &mut rng)).unwrap();
    }
    while !scene.world.is_ready().unwrap() {}
    let read = scene.world.read().unwrap();
    assert_eq!((&read.counts, read.count), (&counts, counts.iter().sum()));
    assert!(counts.chunks(TIMES).all(|same| same.iter().all(|count| *count == same[0])));
}

#[test]
fn bodies_that_deform() {
    let (ball, base) = (part(&sphere(8)), sheet(10, |x, y| 0.2 * x * y));
    let mut cloths = [0; 2].map(|_| part(&base));
    let turned = Pose::new(pose_rows(0.2, &mut seeded(34)));
    let mut world = world();
    for part in [&cloths[0], &cloths[1], &ball] {
        world.add_mesh(part.bvh()).unwrap();
    }
    let places = [turned, Pose::IDENTITY, Pose::IDENTITY, turned];
    let bodies: Vec<_> = [0, 1, 2, 1].into_iter().zip(places).collect();
    world.set_bodies(&bodies).unwrap();
    let mut found = 0;
    for frame in 0..6 {
        let time = frame as f32;
        for (i, cloth) in cloths.iter_mut().enumerate() {
            let wave = |[x, y, z]: [f32; 3]| [x, y, z + 0.3 * (4.0 * x + time + i as f32).sin()];
            let positions: Vec<_> = base.positions.iter().map(|&p| wave(p)).collect();
            cloth.set_positions(&positions);
            world.set_positions(i as u32, &positions).unwrap();
        }
        if frame == 3 {
            // Buffers grow, and what has been written stays.
            world.add_mesh(ball.bvh()).unwrap();
        }
        let parts = [&cloths[0], &cloths[1], &ball, &cloths[1]];
        let mut scene = Scene { world, bodies: parts.into_iter().zip(places).collect() };
        found += scene.check();
        world = scene.world;
    }
    assert!(found > 0);
    let refused = world.set_positions(0, &base.positions[1..]).unwrap_err();
    assert!(matches!(
        refused,
        GpuError::Mesh(MeshError::VertexCount { expected: 121, found: 120 })
    ));
    let nan = vec![[f32::NAN; 3]; 121];
    assert!(matches!(world.set_positions(0, &nan), Err(GpuError::Mesh(_))));
    world.set_positions(1, &vec![[1e30; 3]; 121]).unwrap();
    let hits = world.all(&[[0, 1], [0, 2], [1, 2]]).unwrap();
    assert_eq!(hits.iter().find(|(bodies, _)| bodies.contains(&1)), None);
}

/// More hits than one run surely puts in order: from the second answer on the device orders them, in as few runs as it takes.
#[test]
fn very_many_hits_are_in_order_on_the_device() {
    const SLATS: u32 = 16;
    let triangles: Vec<_> = (0..SLATS).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let slats = |corners: fn(f32) -> [[f32; 3]; 3]| {
        let positions: Vec<_> = (0..SLATS).flat_map(|i| corners(i as f32)).collect();
        Both::new(&positions, &triangles, 8)
    };
    // Each of the first lies across all of the second, which stand upright.
    let a = slats(|i| [[-9.0, i, 0.0], [99.0, i + 0.1, 0.0], [99.0, i + 0.3, 0.0]]);
    let b = slats(|i| [[i + 0.5, -99.0, -1.0], [i + 0.5, 99.0, -1.0], [i + 0.5, 20.0, 5.0]]);
    let mut world = world();
    let meshes = [world.add_mesh(a.bvh()).unwrap(), world.add_mesh(b.bvh()).unwrap()];
    const BODIES: u32 = 1_600;
    let at = |i: u32| Pose::from_translation([0.0, 0.0, 100.0 * (i / 2) as f32]);
    let bodies: Vec<_> = (0..2 * BODIES).map(|i| (meshes[i as usize % 2], at(i))).collect();
    world.set_bodies(&bodies).unwrap();
    let pairs: Vec<BodyPair> = (0..BODIES).map(|i| [2 * i, 2 * i + 1]).collect();
    let hits = u64::from(BODIES * SLATS * SLATS);
    assert!(hits > 400_000);
    for frame in 0..3 {
        let found = world.all(&pairs).unwrap();
        assert_eq!(found.len() as u64, hits);
        assert!(found.is_sorted());
        let report = world.report();
        if frame > 0 {
            assert_eq!((report.sorted_on_host, report.runs), (0, 2), "{frame}");
        }
    }
    // Few again: one run.
    for frame in 0..2 {
        world.all(&pairs[..9]).unwrap();
        assert!(frame == 0 || world.report().runs == 1);
    }
}

/// A mesh takes another tree, which is larger or smaller, while others stay.
#[test]
fn meshes_take_other_trees() {
    let (ball, base) = (part(&sphere(8)), sheet(10, |x, y| 0.2 * x * y));
    let trees =
        [4, 1, 8, 2].map(|leaf_size| Both::new(&base.positions, &base.triangles, leaf_size));
    let larger = part(&sphere(12));
    let mut world = world();
    for part in [&trees[0], &ball] {
        world.add_mesh(part.bvh()).unwrap();
    }
    let places = [Pose::IDENTITY, Pose::new(pose_rows(0.2, &mut seeded(34)))];
    world.set_bodies(&[(0, places[0]), (1, places[1])]).unwrap();
    for (frame, tree) in
        [&trees[1], &trees[2], &trees[3], &larger, &trees[0]].into_iter().enumerate()
    {
        if frame == 2 {
            world.set_positions(1, &sphere(8).positions).unwrap();
        }
        world.set_mesh(0, tree.bvh()).unwrap();
        let parts = [tree, &ball];
        let mut scene = Scene { world, bodies: parts.into_iter().zip(places).collect() };
        assert!(scene.check() > 0, "{frame}");
        world = scene.world;
    }
    assert!(matches!(world.set_mesh(7, ball.bvh()), Err(GpuError::NoMesh { mesh: 7, meshes: 2 })));
}

#[test]
fn passes_are_timed_if_the_device_can_tell() {
    let ball = part(&sphere(8));
    let bodies = [0.0, 0.4].map(|x| (&ball, Pose::from_translation([x, 0.0, 0.0])));
    let mut scene = Scene::new(world().with_timings().unwrap(), bodies.to_vec());
    let passes = |world: &World| -> Vec<&str> {
        world.timings().unwrap().iter().map(|timing| timing.pass).collect()
    };
    assert_eq!(scene.world.count(&[[0, 1]]).unwrap(), scene.check() as u64);
    scene.world.count(&[[0, 1]]).unwrap();
    let counted = passes(&scene.world);
    scene.world.any_each(&[[0, 1]]).unwrap();
    if let ([first, ..], [dive, decide, ..]) = (&counted[..], &passes(&scene.world)[..]) {
        assert_eq!([*first, *dive, *decide], ["expand", "dive", "decide"]);
    }
}
