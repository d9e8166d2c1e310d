//! Pairs within a distance: by every query and executor, against the test of every two triangles.

use crate::each_executor;
use pfront::pfront_core::triangle::{Adjacency as Rule, intersects_in_mesh, within};
use pfront::{
    Adjacency, AnyPose, Batch, BodyOptions, Error, Model, PairQuery, Pose, SceneHit, SceneQuery,
    SelfQuery, TrianglePair,
};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::{bumpy, pose_rows, sphere, tangle};
use std::sync::Arc;

const DISTANCES: [f32; 2] = [0.02, 0.4];

const BODIES: usize = 7;

fn model(soup: MeshData) -> Arc<Model> {
    Arc::new(Model::new(soup.positions, soup.triangles).unwrap())
}

fn corners(model: &Model, pose: &Pose, triangle: u32) -> [[f32; 3]; 3] {
    model.mesh().shadow_triangle(triangle).map(|p| pose.apply(p))
}

fn of_two(a: (&Model, &Pose), b: (&Model, &Pose), distance: f32) -> Vec<TrianglePair> {
    let count = |model: &Model| model.mesh().triangles().len() as u32;
    let all =
        (0..count(a.0)).flat_map(|i| (0..count(b.0)).map(move |j| TrianglePair { a: i, b: j }));
    all.filter(|pair| within(&corners(a.0, a.1, pair.a), &corners(b.0, b.1, pair.b), distance))
        .collect()
}

fn of_one(model: &Model, distance: f32) -> Vec<TrianglePair> {
    let mesh = model.mesh();
    let mut all = of_two((model, &Pose::IDENTITY), (model, &Pose::IDENTITY), distance);
    all.retain(|pair| {
        let [a, b] = [pair.a, pair.b].map(|t| mesh.triangles()[t as usize]);
        let is_neighbour = a.iter().any(|vertex| b.contains(vertex));
        let rule = Rule::SharedIndexRule;
        pair.a < pair.b && (!is_neighbour || intersects_in_mesh(mesh, pair.a, pair.b, rule))
    });
    all
}

#[test]
fn pairs_and_selves_on_every_executor() {
    let mut rng = seeded(61);
    let (a, b) = (model(sphere(5)), model(bumpy(5)));
    for executor in each_executor(&[3]) {
        for distance in DISTANCES {
            let mut query = PairQuery::new().within(distance).unwrap().on(&executor);
            let mut own = SelfQuery::new().on(&executor).within(distance).unwrap();
            let mut batch = Batch::new();
            batch.within(distance).unwrap();
            let mut truths = Vec::new();
            for _ in 0..3 {
                let pose = Pose::new(pose_rows(1.5, &mut rng));
                let truth = of_two((&a, &Pose::IDENTITY), (&b, &pose), distance);
                assert_eq!(query.all(&a, &b, pose).unwrap(), truth, "{executor:?} {distance}");
                assert_eq!(query.count(&a, &b, pose).unwrap(), truth.len() as u64);
                assert_eq!(query.any(&a, &b, pose).unwrap().is_some(), !truth.is_empty());
                let touching = PairQuery::new().contacts(&a, &b, pose).unwrap().to_vec();
                assert_eq!(query.contacts(&a, &b, pose).unwrap(), touching);
                batch.pair(&a, &b, pose).unwrap();
                truths.push(truth);
            }
            let truth = of_one(&b, distance);
            assert_eq!(own.all(&b).unwrap(), truth, "{executor:?} {distance}");
            assert_eq!(own.count(&b).unwrap(), truth.len() as u64);
            batch.itself(&b, Adjacency::default());
            truths.push(truth);
            let lists = batch.all(&executor).unwrap().read().unwrap();
            for (list, truth) in lists.iter().zip(&truths) {
                assert_eq!(list, truth, "{executor:?} {distance}");
            }
        }
    }
}

/// Bodies that move, and stay, over some frames.
#[test]
fn scenes_on_every_executor() {
    let mut rng = seeded(62);
    let shapes = [model(sphere(4)), model(bumpy(4)), model(tangle(20, 20, 1, &mut rng))];
    for executor in each_executor(&[3]) {
        for distance in DISTANCES {
            let mut scene = SceneQuery::new().on(&executor);
            scene.within(distance).unwrap();
            let mut place = || Pose::new(pose_rows(4.0, &mut rng));
            let mut bodies = Vec::new();
            for k in 0..BODIES {
                let (shape, pose) = (&shapes[k % 3], place());
                let options = match k {
                    0 => BodyOptions { itself: Some(Adjacency::default()), ..Default::default() },
                    _ => BodyOptions::default(),
                };
                bodies.push((scene.add_with(shape.clone(), pose, options).unwrap(), shape, pose));
            }
            for frame in 0..4 {
                // Pairs of a single body are found by themselves.
                let moving = if frame == 2 { 1 } else { BODIES * (frame % 2) };
                for (body, _, pose) in bodies.iter_mut().take(moving) {
                    *pose = place();
                    scene.set_pose(*body, *pose).unwrap();
                }
                let mut truth = Vec::new();
                for (i, a) in bodies.iter().enumerate() {
                    if i == 0 {
                        let own = of_one(a.1, distance).into_iter();
                        truth.extend(own.map(|pair| SceneHit { bodies: [a.0; 2], pair }));
                    }
                    for b in &bodies[i + 1..] {
                        let pairs = of_two((a.1, &a.2), (b.1, &b.2), distance);
                        let hit = |pair| SceneHit { bodies: [a.0, b.0], pair };
                        truth.extend(pairs.into_iter().map(hit));
                    }
                }
                assert_eq!(scene.all().unwrap(), truth, "{executor:?} {distance} {frame}");
                assert_eq!(scene.count().unwrap(), truth.len() as u64);
            }
        }
    }
}

#[test]
fn what_is_no_distance_is_refused() {
    for distance in [-0.5, f32::NAN, f32::INFINITY] {
        assert!(matches!(PairQuery::new().within(distance), Err(Error::Distance(_))));
        assert!(matches!(SelfQuery::new().within(distance), Err(Error::Distance(_))));
        let mut scene = SceneQuery::new();
        let body = scene.add(model(sphere(2)), Pose::IDENTITY).unwrap();
        assert!(matches!(scene.within(distance), Err(Error::Distance(_))));
        assert!(scene.body(body).is_ok());
        assert!(matches!(Batch::new().within(distance), Err(Error::Distance(_))));
    }
}

/// At 0 the pairs are those that intersect, and they only grow with the distance.
#[test]
fn pairs_grow_with_the_distance() {
    let mut rng = seeded(63);
    let (a, b) = (model(sphere(8)), model(bumpy(8)));
    for _ in 0..5 {
        let pose: AnyPose = Pose::new(pose_rows(1.0, &mut rng)).into();
        let mut before = PairQuery::new().all(&a, &b, pose).unwrap().to_vec();
        let mut distance = 0.0;
        for _ in 0..8 {
            let mut query = PairQuery::new().within(distance).unwrap();
            let pairs = query.all(&a, &b, pose).unwrap().to_vec();
            assert!(before.iter().all(|pair| pairs.binary_search(pair).is_ok()), "{distance}");
            assert!(distance > 0.0 || pairs == before);
            before = pairs;
            distance += rng.random_range(0.0..0.2);
        }
    }
}
