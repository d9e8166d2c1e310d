//! Scenes most of which stands still give the answers of scenes that were never asked before.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::{Body, Model, Pose, SceneHit, SceneQuery};
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
    let mut met = 0;
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
        let mut visited = Vec::new();
        let _ = scene.visit(|hit| {
            visited.push(hit);
            std::ops::ControlFlow::Continue(())
        });
        visited.sort_unstable();
        assert_eq!(by_place(&scene, &visited), expected, "frame {frame}");
    }
    assert!(met > 1_000);
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

#[test]
fn another_accuracy_forgets() {
    // Two triangles in one plane, each beyond the longest edge of the other: no filter knows.
    let half = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let model = Arc::new(Model::new(half, vec![[0, 1, 2]]).unwrap());
    let mut scene = SceneQuery::new();
    scene.add(model.clone(), Pose::IDENTITY).unwrap();
    let half_turn = [[-1.0, 0.0, 0.0, 1.1], [0.0, -1.0, 0.0, 1.1], [0.0, 0.0, 1.0, 0.0]];
    scene.add(model, Pose::new(half_turn)).unwrap();
    assert!(scene.all().unwrap().is_empty());
    let mut scene = scene.with_accuracy(pfront::Accuracy::Conservative);
    assert_eq!(scene.all().unwrap().len(), 1);
    assert_eq!(scene.with_accuracy(pfront::Accuracy::Exact).count().unwrap(), 0);
}
