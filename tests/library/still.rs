//! Scenes most of which stands still give the answers of scenes that were never asked before.

use pfront::executor::Backend;
use pfront::{Aabb, AnyPose, Body, BodyId, BodyOptions, Model, Pose, SceneHit, SceneQuery};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::scenes::icosphere;
use std::sync::Arc;

const BODIES: usize = 80;

fn somewhere(rng: &mut impl Rng) -> Pose {
    Pose::from_translation([0; 3].map(|_| rng.random_range(-3.0..3.0)))
}

/// A scene of the same bodies, which knows nothing yet.
fn anew(scene: &SceneQuery) -> SceneQuery {
    let mut fresh = SceneQuery::new();
    for body in scene.bodies() {
        fresh.add(body.model().clone(), body.pose()).unwrap();
    }
    fresh
}

/// Hits by the places of their bodies.
fn by_place(scene: &SceneQuery, hits: &[SceneHit]) -> Vec<([usize; 2], [u32; 2])> {
    let ids: Vec<_> = scene.bodies().map(Body::id).collect();
    let place = |id| ids.binary_search(&id).unwrap();
    hits.iter().map(|hit| (hit.bodies.map(place), [hit.pair.a, hit.pair.b])).collect()
}

fn run(mut scene: SceneQuery, seed: u64) {
    let mut rng = seeded(seed);
    let ball = icosphere(20);
    let model = Arc::new(Model::new(ball.positions.clone(), ball.triangles.clone()).unwrap());
    for _ in 0..BODIES {
        scene.add(model.clone(), somewhere(&mut rng)).unwrap();
    }
    let (mut met, mut in_boxes) = (0, 0);
    for frame in 0..60 {
        let ids: Vec<_> = scene.bodies().map(Body::id).collect();
        let mut any = || ids[rng.random_range(0..ids.len())];
        let some = [any(), any(), any(), any()];
        // Few, some twice, or none at all.
        for &id in &some[..frame % 5] {
            // A body that was removed before is refused.
            let _ = match rng.random_range(0..12) {
                0 => scene.remove(id).map(|_| ()),
                1 => scene.add(model.clone(), somewhere(&mut rng)).map(|_| ()),
                // The pose that it has.
                2 => scene.body(id).map(Body::pose).and_then(|pose| scene.set_pose(id, pose)),
                3 => {
                    let scale = rng.random_range(0.7..1.5f32);
                    let scaled: Vec<_> =
                        ball.positions.iter().map(|p| p.map(|x| x * scale)).collect();
                    scene.set_positions(id, &scaled)
                }
                _ => scene.set_pose(id, somewhere(&mut rng)),
            };
        }
        let mut fresh = anew(&scene);
        let expected = fresh.all().unwrap().to_vec();
        let expected = by_place(&fresh, &expected);
        met += expected.len();
        // Sometimes only one of these is asked, and answers of earlier frames are what there is.
        if frame % 3 != 1 {
            assert_eq!(scene.count().unwrap(), expected.len() as u64, "frame {frame}");
            assert_eq!(scene.any().unwrap().is_some(), !expected.is_empty());
        }
        if frame % 4 != 2 {
            let found = scene.all().unwrap().to_vec();
            assert_eq!(by_place(&scene, &found), expected, "frame {frame}");
        }
        if frame % 4 == 3 {
            let (hits, contacts): (Vec<_>, Vec<_>) =
                scene.contacts().unwrap().iter().copied().unzip();
            assert_eq!(by_place(&scene, &hits), expected, "frame {frame}");
            assert!(fresh.contacts().unwrap().iter().map(|(_, c)| *c).eq(contacts));
        }
        let corner = [0; 3].map(|_| rng.random_range(-4.0..4.0f32));
        let aabb = Aabb { min: corner, max: corner.map(|x| x + frame as f32 * 0.1) };
        let lies_in = |body: &&Body| body.aabb().is_some_and(|own| own.overlaps(&aabb));
        let expected_in: Vec<_> = scene.bodies().filter(lies_in).map(Body::id).collect();
        in_boxes += expected_in.len();
        assert_eq!(scene.bodies_in(aabb).unwrap(), expected_in, "frame {frame}");
        let mut visited = Vec::new();
        let _ = scene.visit(|hit| {
            visited.push(hit);
            std::ops::ControlFlow::Continue(())
        });
        visited.sort_unstable();
        assert_eq!(by_place(&scene, &visited), expected, "frame {frame}");
    }
    assert!(met > 1_000 && in_boxes > 100, "{in_boxes}");
}

#[test]
fn kept_answers_are_those_of_a_new_scene() {
    (0..4).for_each(|seed| run(SceneQuery::new(), seed));
}

#[cfg(feature = "threads")]
#[test]
fn likewise_on_threads() {
    (4..8).for_each(|seed| run(SceneQuery::new().on(&pfront::Executor::threads(3)), seed));
}

type Set = Box<dyn Fn(&mut SceneQuery, BodyId) -> Result<(), pfront::Error>>;

/// A body that is set to what it is already does not change, so that nothing is asked again.
#[test]
fn what_is_there_already_changes_nothing() {
    let ball = icosphere(80);
    let in_f64 = |scale: f64| {
        let positions = ball.positions.iter().map(|p| p.map(|x| f64::from(x) * scale));
        Model::from_f64(positions.collect(), ball.triangles.clone()).unwrap()
    };
    let in_f32 = Arc::new(Model::new(ball.positions.clone(), ball.triangles.clone()).unwrap());
    let mut scene = SceneQuery::new();
    // The models in f32 are shared; f32 holds the positions of one in f64.
    let mut add = |model: &Arc<Model>| scene.add(model.clone(), Pose::IDENTITY).unwrap();
    let two = [add(&in_f32), add(&in_f32)];
    let three = [1.1, 1.0, 1.0].map(|scale| add(&Arc::new(in_f64(scale))));
    let all = [&two[..], &three[..]].concat();
    scene.ignore(all[0], all[1], true).unwrap();
    assert!(!scene.contacts().unwrap().is_empty());
    let set: Vec<Set> = vec![
        Box::new(|scene, id| scene.set_pose(id, Pose::IDENTITY)),
        Box::new(|scene, id| {
            let model = scene.body(id)?.model().clone();
            scene.set_model(id, model)
        }),
        Box::new(|scene, id| {
            let model = Model::clone(scene.body(id)?.model());
            scene.set_model(id, model)
        }),
        Box::new(|scene, id| scene.set_options(id, BodyOptions::default())),
        Box::new(|scene, id| {
            let model = scene.body(id)?.model().clone();
            let mesh = model.mesh();
            match (mesh.positions_f64(), model.is_f64()) {
                (Some(positions), _) => scene.set_positions(id, positions),
                (None, false) => scene.set_positions(id, mesh.shadow()),
                (None, true) => {
                    let widened = mesh.shadow().iter().map(|p| p.map(f64::from));
                    scene.set_positions(id, &widened.collect::<Vec<_>>())
                }
            }
        }),
        Box::new(|scene, id| {
            scene.set_options(id, BodyOptions { user_data: 7, ..BodyOptions::default() })
        }),
    ];
    for set in set {
        for &id in &all {
            set(&mut scene, id).unwrap();
            scene.contacts().unwrap();
            assert_eq!(scene.plan().unwrap().backend, Backend::Cached);
        }
    }
    scene.ignore(all[1], all[0], true).unwrap();
    scene.ignore(all[2], all[3], false).unwrap();
    scene.contacts().unwrap();
    assert_eq!(scene.plan().unwrap().backend, Backend::Cached);
    // A model that is shared is not copied for it.
    let model = |id| Arc::as_ptr(scene.body(id).unwrap().model());
    assert_ne!(model(all[0]), Arc::as_ptr(&in_f32), "of the clone above");
    let before = model(all[0]);
    let (kept, positions) = (scene.body(all[0]).unwrap().model().clone(), &ball.positions);
    scene.set_positions(all[0], positions).unwrap();
    assert_eq!(Arc::as_ptr(scene.body(all[0]).unwrap().model()), before);
    drop(kept);
    // A zero of the other sign is another number, in positions and in poses.
    scene.set_pose(all[0], Pose::from_translation([-0.0, 0.0, 0.0])).unwrap();
    scene.contacts().unwrap();
    assert_ne!(scene.plan().unwrap().backend, Backend::Cached);
    let bits = |pose: AnyPose| pose.to_f64().rows[0][3].to_bits();
    assert_eq!(bits(scene.body(all[0]).unwrap().pose()), (-0.0_f64).to_bits());
    // Positions that cannot be set are refused as before.
    assert!(scene.set_positions(all[2], &ball.positions).is_err());
    assert!(scene.set_positions::<f64>(all[0], &[]).is_err());
    // Its own positions without the first or the last are too few.
    let own = scene.body(all[0]).unwrap().model().mesh().shadow().to_vec();
    assert!(scene.set_positions(all[0], &own[1..]).is_err());
    assert!(scene.set_positions(all[0], &own[..own.len() - 1]).is_err());
}
