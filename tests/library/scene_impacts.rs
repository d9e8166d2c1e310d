//! Impacts of the bodies of a scene of which some move, against every pair of bodies as two motions; on any number of threads the same.

use pfront::{
    Adjacency, AnyPose, BodyId, BodyOptions, Error, Executor, Groups, Impact, Model, Motion,
    PairQuery, Pose, Pose64, SceneHit, SceneQuery, SelfQuery, TrianglePair,
};
use pfront_testkit::rng::{ChaCha8Rng, Rng, RngExt, seeded};
use pfront_testkit::shapes::{pose_rows, sheet, sphere, tangle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

type Found = Vec<(SceneHit, Impact)>;

pub(crate) fn executors() -> Vec<Executor> {
    let sequential = Executor::sequential();
    let flagged = sequential.clone().with_cancel(Arc::new(AtomicBool::new(false)));
    #[cfg(feature = "threads")]
    return [sequential, flagged].into_iter().chain([1, 2, 3, 7].map(Executor::threads)).collect();
    #[cfg(not(feature = "threads"))]
    vec![sequential, flagged]
}

fn models(rng: &mut ChaCha8Rng) -> Vec<Arc<Model>> {
    let soups = [sphere(6), sheet(8, |u, v| 0.3 * (5.0 * u).sin() * v), tangle(20, 15, 2, rng)];
    let in_f32 = soups
        .iter()
        .map(|soup| Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap());
    let in_f64 = soups.iter().map(|soup| {
        let positions = soup.positions.iter().map(|p| p.map(|x| f64::from(x) / 3.0));
        Model::from_f64(positions.collect(), soup.triangles.clone()).unwrap()
    });
    // One without triangles.
    let empty = Model::new(vec![[0.0; 3]], Vec::new()).unwrap();
    in_f32.chain(in_f64).chain([empty]).map(Arc::new).collect()
}

fn pose(rng: &mut ChaCha8Rng) -> AnyPose {
    let rows = pose_rows(4.0, rng);
    match rng.random_range(0..4) {
        0 => Pose64::new(rows.map(|row| row.map(|x| f64::from(x) * 1.1))).into(),
        _ => Pose::new(rows).into(),
    }
}

fn options(rng: &mut impl Rng) -> BodyOptions {
    let mut bits = || 1 << rng.random_range(0..3) | 1 << rng.random_range(0..3);
    let groups = Groups { memberships: bits(), filter: bits() };
    let itself = rng.random_bool(0.2).then_some(Adjacency::SharedIndexRule);
    BodyOptions { groups, itself, ..BodyOptions::default() }
}

/// A scene of some bodies, of which some have gone and some pairs are ignored, and where those go that move.
fn random(rng: &mut ChaCha8Rng, models: &[Arc<Model>]) -> (SceneQuery, Vec<(BodyId, AnyPose)>) {
    let mut scene = SceneQuery::new();
    let mut ids = Vec::new();
    for _ in 0..rng.random_range(2..9) {
        let model = models[rng.random_range(0..models.len())].clone();
        ids.push(scene.add_with(model, pose(rng), options(rng)).unwrap());
    }
    for _ in 0..2 {
        let [a, b] = [0; 2].map(|_| ids[rng.random_range(0..ids.len())]);
        scene.ignore(a, b, true).unwrap();
    }
    let gone = ids.remove(rng.random_range(0..ids.len()));
    scene.remove(gone).unwrap();
    let mut ends = Vec::new();
    for id in ids.into_iter().rev() {
        match rng.random_range(0..4) {
            0 => {}
            1 => ends.push((id, scene.body(id).unwrap().pose())),
            _ => ends.push((id, pose(rng))),
        }
    }
    (scene, ends)
}

/// Every pair of bodies, as two motions, within a distance.
fn every(scene: &SceneQuery, ends: &[(BodyId, AnyPose)], within: f32) -> Found {
    let mut found = Vec::new();
    let end = |id| ends.iter().find(|end| end.0 == id).map(|end| end.1);
    let ignored: Vec<_> = scene.ignored().collect();
    let bodies: Vec<_> = scene.bodies().collect();
    for (i, a) in bodies.iter().enumerate() {
        if let Some(adjacency) = a.options().itself {
            let mut query = SelfQuery::new().with_adjacency(adjacency).within(within).unwrap();
            let hit = |&pair: &TrianglePair| SceneHit { bodies: [a.id(); 2], pair };
            let all = query.all(a.model()).unwrap().iter().map(hit);
            found.extend(all.map(|hit| (hit, Impact { from: 0.0, to: 0.0 })));
        }
        for b in &bodies[i + 1..] {
            let two = [a.id(), b.id()];
            if !a.options().groups.meet(&b.options().groups) || ignored.contains(&two) {
                continue;
            }
            let [p, q] = [a, b].map(|body| {
                let end = end(body.id()).unwrap_or(body.pose());
                Motion::new(body.model(), body.pose(), end).unwrap()
            });
            let impacts = PairQuery::new().within(within).unwrap().impacts(&p, &q).unwrap();
            found.extend(
                impacts.into_iter().map(|(pair, impact)| (SceneHit { bodies: two, pair }, impact)),
            );
        }
    }
    found.sort_by_key(|hit| hit.0);
    found
}

fn first(found: &Found) -> Option<(SceneHit, Impact)> {
    let key = |(hit, impact): &(SceneHit, Impact)| (impact.from, *hit);
    found.iter().copied().min_by(|p, q| key(p).partial_cmp(&key(q)).unwrap())
}

#[test]
fn impacts_are_those_of_every_pair_of_bodies() {
    let mut rng = seeded(470);
    let (models, executors) = (models(&mut rng), executors());
    let (mut at_start, mut on_the_way, mut own) = (0, 0, 0);
    for round in 0..60 {
        let (mut scene, ends) = random(&mut rng, &models);
        let within = if round % 5 == 0 { 0.1 } else { 0.0 };
        scene.within(within).unwrap();
        let expected = every(&scene, &ends, within);
        at_start += expected.iter().filter(|hit| hit.1.from == 0.0).count();
        on_the_way += expected.iter().filter(|hit| hit.1.from > 0.0).count();
        own += expected.iter().filter(|(hit, _)| hit.bodies[0] == hit.bodies[1]).count();
        if round % 3 == 0 {
            // Then hits of bodies that rest are known.
            scene.update().unwrap();
        }
        let hits = scene.hits().to_vec();
        for executor in &executors {
            let mut scene = scene.clone().on(executor);
            assert!(scene.impacts(&ends).unwrap() == expected, "{round} {executor:?}");
            let proven = expected.iter().filter(|hit| hit.1.is_proven()).count();
            let counts = [proven as u64, expected.len() as u64];
            assert_eq!(scene.count_impacts(&ends).unwrap(), counts, "{round} {executor:?}");
            let any = scene.any_impact(&ends).unwrap();
            assert!(any.map_or(expected.is_empty(), |hit| expected.contains(&hit)));
            assert_eq!(any.is_some_and(|hit| hit.1.is_proven()), proven > 0);
            assert_eq!(
                scene.first_impact(&ends).unwrap(),
                first(&expected),
                "{round} {executor:?}"
            );
            assert_eq!(scene.hits(), hits, "the scene is as it was");
        }
    }
    assert!(at_start > 200 && on_the_way > 1_000 && own > 20, "{at_start} {on_the_way} {own}");
}

#[test]
fn many_bodies_in_one_place_and_one_that_flies_through() {
    let mut rng = seeded(471);
    let models = models(&mut rng);
    let mut scene = SceneQuery::new();
    for i in 0..60 {
        let at = [0.5 * (i % 8) as f32, 0.5 * (i / 8) as f32, 0.0];
        scene.add(models[i % 2].clone(), Pose::from_translation(at)).unwrap();
    }
    let ends: Vec<_> = scene.bodies().step_by(3).map(|body| (body.id(), pose(&mut rng))).collect();
    let expected = every(&scene, &ends, 0.0);
    assert!(expected.len() > 1_000, "{}", expected.len());
    for executor in executors() {
        let mut scene = scene.clone().on(&executor);
        assert!(scene.impacts(&ends).unwrap() == expected, "{executor:?}");
        assert_eq!(scene.first_impact(&ends).unwrap(), first(&expected), "{executor:?}");
    }
}

#[test]
fn who_goes_nowhere_meets_what_he_intersects() {
    let mut rng = seeded(472);
    let models = models(&mut rng);
    let mut hits = 0;
    for _ in 0..30 {
        let (scene, _) = random(&mut rng, &models);
        let ends: Vec<_> = scene.bodies().map(|body| (body.id(), body.pose())).collect();
        let all = scene.clone().all().unwrap().to_vec();
        hits += all.len();
        for ends in [&ends[..], &[]] {
            let impacts = scene.clone().impacts(ends).unwrap();
            assert!(impacts.iter().map(|hit| hit.0).eq(all.iter().copied()));
            assert!(impacts.iter().all(|(_, impact)| [impact.from, impact.to] == [0.0; 2]));
            let first = scene.clone().first_impact(ends).unwrap();
            assert_eq!(first.map(|hit| hit.0), all.first().copied());
        }
    }
    assert!(hits > 100, "{hits}");
}

/// A box as a mesh.
fn block(half: [f32; 3]) -> Arc<Model> {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -half[k] } else { half[k] });
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Arc::new(Model::new((0..8).map(corner).collect(), triangles.collect()).unwrap())
}

/// 900 m/s, in steps of a sixtieth of a second: 15 m, and walls of a millimetre.
#[test]
fn a_bullet_does_not_tunnel() {
    let (wall, bullet) = (block([0.0005, 2.0, 2.0]), block([0.01, 0.004, 0.004]));
    let at = |x: f32| Pose::from_translation([x, 0.1, -0.2]);
    for executor in executors() {
        let mut scene = SceneQuery::new().on(&executor);
        let walls = [13.0, 5.0, 31.0, 9.0].map(|x| scene.add(wall.clone(), at(x)).unwrap());
        let shot = scene.add(bullet.clone(), at(0.0)).unwrap();
        let mut met = Vec::new();
        for step in 0..4 {
            let end = at(15.0 * (step + 1) as f32);
            assert_eq!(scene.count().unwrap(), 0, "no frame shows it in a wall");
            let impacts = scene.impacts(&[(shot, end)]).unwrap();
            let first = scene.first_impact(&[(shot, end)]).unwrap();
            assert_eq!(first, self::first(&impacts));
            assert!(impacts.iter().all(|(_, impact)| impact.is_proven()));
            let mut walls: Vec<_> = impacts.iter().map(|(hit, _)| hit.bodies[0]).collect();
            walls.dedup();
            met.push((walls, first.map(|(hit, impact)| (hit.bodies[0], impact.from))));
            scene.set_pose(shot, end).unwrap();
        }
        let [far, near, last, middle] = walls;
        assert_eq!(met[0].0, [far, near, middle]);
        let (wall, from) = met[0].1.unwrap();
        // The tip is 10 mm ahead, and the wall half a millimetre thicker to its side.
        assert!(wall == near && (from - (5.0 - 0.0105) / 15.0).abs() < 1e-6, "{from}");
        assert!(met[1].0.is_empty() && met[2].0 == [last] && met[3].0.is_empty());
    }
}

#[test]
fn ends_that_cannot_be_are_refused_and_change_nothing() {
    let block = block([1.0; 3]);
    let mut scene = SceneQuery::new();
    let at = |x: f32| Pose::from_translation([x, 0.0, 0.0]);
    let [a, b, gone] = [0.0, 3.0, 9.0].map(|x| scene.add(block.clone(), at(x)).unwrap());
    scene.remove(gone).unwrap();
    let mut other = SceneQuery::new();
    (0..9).for_each(|_| _ = other.add(block.clone(), at(0.0)).unwrap());
    let strange = other.bodies().last().unwrap().id();
    for id in [gone, strange] {
        assert_eq!(scene.impacts(&[(a, at(1.0)), (id, at(1.0))]), Err(Error::StaleBody { id }));
        assert_eq!(scene.first_impact(&[(id, at(1.0))]), Err(Error::StaleBody { id }));
    }
    let twice = [(b, at(1.0)), (a, at(2.0)), (b, at(3.0))];
    assert_eq!(scene.impacts(&twice), Err(Error::TwoEnds { id: b }));
    assert_eq!(scene.first_impact(&[(a, at(0.0)), (a, at(0.0))]), Err(Error::TwoEnds { id: a }));
    for x in [f32::NAN, f32::INFINITY, 1e38] {
        assert!(matches!(scene.impacts(&[(a, at(x))]), Err(Error::Pose(_))));
    }
    assert_eq!(scene.impacts(&[(a, at(0.5))]), Ok(Vec::new()));
    assert!(!scene.impacts(&[(a, at(1.0))]).unwrap().is_empty());
    assert_eq!(scene.count(), Ok(0));
}

#[test]
fn a_flag_ends_it() {
    let model = {
        let soup = sphere(12);
        Arc::new(Model::new(soup.positions, soup.triangles).unwrap())
    };
    for executor in executors() {
        let flag = Arc::new(AtomicBool::new(true));
        let mut scene = SceneQuery::new().on(&executor.with_cancel(flag.clone()));
        let [a, b] = [0.0, 9.0]
            .map(|x| scene.add(model.clone(), Pose::from_translation([x, 0.0, 0.0])).unwrap());
        let ends = [(b, Pose::IDENTITY)];
        assert_eq!(scene.impacts(&ends), Err(Error::Cancelled));
        assert_eq!(scene.first_impact(&ends), Err(Error::Cancelled));
        flag.store(false, Relaxed);
        assert_eq!(scene.impacts(&ends).unwrap()[0].0.bodies, [a, b]);
        assert!(scene.first_impact(&ends).unwrap().is_some());
    }
}
