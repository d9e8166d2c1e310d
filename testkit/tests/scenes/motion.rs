//! Motion: gears stay in mesh, the sheet folds onto itself, courses are random.

use pfront_testkit::scenes::{Kind, Scene, icosphere};

use crate::oracle::{in_world, self_touching, touching};
use pfront_testkit::MeshData;

fn scene(name: &str, size: usize) -> Scene {
    Scene::by_name(name, Some(size)).expect("a named scene")
}

/// The objects in `frame`.
fn world(scene: &Scene, frame: usize) -> Vec<MeshData> {
    let mut poses = Vec::new();
    scene.poses(frame, &mut poses);
    let objects = scene.objects.iter().zip(&poses);
    objects.map(|(&mesh, pose)| in_world(&scene.meshes[mesh], pose)).collect()
}

#[test]
fn worm_and_wheel_touch_in_every_frame() {
    let scene = scene("worm-gear", 16_000);
    assert_eq!(scene.kind(), Kind::Pair);
    // Twenty frames turn the wheel by one tooth; odd ones in between, then the far end.
    for frame in [0, 3, 7, 11, 13, 18, 63, 119] {
        let bodies = world(&scene, frame);
        let touching = touching(&bodies[0], &bodies[1]);
        assert!((100..3_000).contains(&touching), "frame {frame}: {touching} pairs");
    }
}

#[test]
fn exactly_the_meshing_gears_of_the_train_touch() {
    let scene = scene("epicyclic", 0);
    assert_eq!(scene.kind(), Kind::Many);
    // The first object and the number of planets of each stage; sun, planets, ring follow.
    let stages = [(0, 3), (5, 4), (11, 4)];
    let meshing: Vec<(usize, usize)> = stages
        .iter()
        .flat_map(|&(sun, n)| (1..=n).flat_map(move |k| [(sun, sun + k), (sun + k, sun + n + 1)]))
        .collect();
    for frame in [0, 5, 37, 74, 119] {
        let gears = world(&scene, frame);
        for a in 0..gears.len() {
            for b in a + 1..gears.len() {
                let touching = touching(&gears[a], &gears[b]);
                assert_eq!(touching > 0, meshing.contains(&(a, b)), "frame {frame}: {a} and {b}");
                assert!(touching < 1_000, "frame {frame}: {touching} pairs of {a} and {b}");
            }
        }
    }
}

#[test]
fn the_sheet_folds_until_it_crosses_itself_in_places() {
    let scene = scene("sheet", 20_000);
    assert_eq!(scene.kind(), Kind::SelfMesh);
    let mut positions = Vec::new();
    let mut touching = |frame| {
        scene.positions(frame, &mut positions);
        self_touching(&positions, &scene.meshes[0].triangles)
    };
    assert_eq!(touching(0), 0);
    for frame in [40, 60, 90, 119] {
        let found = touching(frame);
        assert!((500..10_000).contains(&found), "frame {frame}: {found} pairs");
    }
}

#[test]
fn passing_bodies_meet_and_part() {
    for name in ["torus-knots", "spheres"] {
        let scene = scene(name, 4_000);
        let met = |frame| {
            let bodies = world(&scene, frame);
            touching(&bodies[0], &bodies[1])
        };
        assert!(met(60) > 100, "{name}");
        assert!(met(60) > 3 * met(0).max(met(119)), "{name}");
    }
}

#[test]
fn courses_are_random_and_repeatable() {
    let course = |seed| Scene::course(icosphere(300), icosphere(800), 200, seed);
    let (scene, mut poses, mut again, mut hits) = (course(7), Vec::new(), Vec::new(), 0);
    for frame in 0..scene.frames() {
        scene.poses(frame, &mut poses);
        course(7).poses(frame, &mut again);
        assert_eq!(poses, again);
        course(8).poses(frame, &mut again);
        assert_ne!(poses, again);
        let bodies = world(&scene, frame);
        hits += usize::from(touching(&bodies[0], &bodies[1]) > 0);
    }
    assert!((100..=200).contains(&hits), "{hits} of 200 poses touch");
}
