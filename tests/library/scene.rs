//! Scenes of many bodies, through all that may happen to them between frames, against brute force with
//! the exact oracle; on any number of threads the same.

use pfront::{
    Body, BodyId, BodyOptions, Error, Groups, Model, PairQuery, Pose, PoseError, SceneHit,
    SceneQuery,
};
use pfront::{Piece, TrianglePair};
use pfront_core::MeshError;
use pfront_testkit::oracle::pairs;
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::shapes::{pose_rows, posed, sheet, sphere, tangle, union};
use pfront_testkit::{MeshData, Rows};
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::Arc;

/// A scene without threads, and one for each number of workers and schedule.
fn scenes() -> Vec<SceneQuery> {
    #[cfg(feature = "threads")]
    {
        use pfront::threads::{Pool, Schedule, Settings};
        let schedules = [Schedule::Static, Schedule::Hybrid];
        let threaded = [1, 2, 3, 7, 64].into_iter().flat_map(|workers| {
            schedules.map(|schedule| {
                // The two make up for each other in what they leave at the default.
                let max_nodes = if schedule == Schedule::Static { 1 } else { 1 << 20 };
                let settings = Settings { schedule, max_nodes, ..Settings::default() };
                let pool = Pool::new(workers).with_settings(settings);
                SceneQuery::new().on(&pool.into())
            })
        });
        [SceneQuery::new()].into_iter().chain(threaded).collect()
    }
    #[cfg(not(feature = "threads"))]
    vec![SceneQuery::new()]
}

/// Scenes that are all told the same, and what they are known to hold.
struct Trial {
    scenes: Vec<SceneQuery>,
    known: Vec<(BodyId, MeshData, Rows)>,
    ignored: BTreeSet<[BodyId; 2]>,
}

impl Trial {
    fn new() -> Self {
        Self { scenes: scenes(), known: Vec::new(), ignored: BTreeSet::new() }
    }

    /// Tells all scenes, which give the same answer.
    fn tell<R: PartialEq>(&mut self, mut call: impl FnMut(&mut SceneQuery) -> R) -> R {
        let answers: Vec<R> = self.scenes.iter_mut().map(&mut call).collect();
        assert!(answers.windows(2).all(|two| two[0] == two[1]));
        answers.into_iter().next().unwrap()
    }

    fn add(&mut self, soup: MeshData, rows: Rows) {
        let model = Arc::new(model(&soup));
        let id = self.tell(|scene| scene.add(model.clone(), Pose::new(rows)).unwrap());
        self.known.push((id, soup, rows));
    }

    fn remove(&mut self, place: usize) {
        let (id, ..) = self.known.remove(place);
        self.tell(|scene| scene.remove(id).map(|body| body.id())).unwrap();
        assert_eq!(self.tell(|scene| scene.remove(id).err()), Some(Error::StaleBody { id }));
    }

    fn pose(&mut self, place: usize, rows: Rows) {
        self.known[place].2 = rows;
        let id = self.known[place].0;
        self.tell(|scene| scene.set_pose(id, Pose::new(rows))).unwrap();
    }

    fn group(&mut self, place: usize, rng: &mut impl Rng) {
        let id = self.known[place].0;
        let mut bits = || 1 << rng.random_range(0..3) | 1 << rng.random_range(0..3);
        let groups = Groups { memberships: bits(), filter: bits() };
        let user_data = u64::from(groups.filter);
        let options = BodyOptions { groups, user_data, itself: None };
        self.tell(|scene| scene.set_options(id, options)).unwrap();
    }

    /// Ignores two bodies, or no longer if they were ignored.
    fn ignore(&mut self, places: [usize; 2]) {
        let mut ids = places.map(|place| self.known[place].0);
        let [a, b] = ids;
        ids.sort();
        let ignored = self.ignored.insert(ids);
        if !ignored {
            self.ignored.remove(&ids);
        }
        self.tell(|scene| scene.ignore(a, b, ignored)).unwrap();
    }

    fn deform(&mut self, place: usize, rng: &mut impl Rng) {
        let (id, soup, _) = &mut self.known[place];
        let stretch = [0; 3].map(|_| rng.random_range(0.8..1.25f32));
        *soup = std::mem::take(soup).map(|p| [0, 1, 2].map(|k| p[k] * stretch[k]));
        let (id, positions) = (*id, soup.positions.clone());
        self.tell(|scene| scene.set_positions(id, &positions)).unwrap();
    }

    fn split(&mut self, place: usize, parts: u32) {
        let (id, soup, rows) = self.known.remove(place);
        let pieces = self.tell(|scene| scene.split(id, |triangle| triangle * 7 % parts).unwrap());
        for Piece { body, part, triangles, .. } in pieces {
            assert!(triangles.is_sorted() && triangles.iter().all(|t| t * 7 % parts == part));
            let mesh = self.scenes[0].body(body).unwrap().model().mesh();
            let old = |&t: &u32| soup.triangles[t as usize].map(|v| soup.positions[v as usize]);
            assert!((0..).zip(&triangles).all(|(new, t)| mesh.shadow_triangle(new) == old(t)));
            let used: BTreeSet<_> =
                triangles.iter().flat_map(|&t| soup.triangles[t as usize]).collect();
            assert_eq!(mesh.vertex_count(), used.len());
            let (positions, triangles) =
                (mesh.positions().unwrap().to_vec(), mesh.triangles().to_vec());
            self.known.push((body, MeshData { positions, triangles }, rows));
        }
    }

    /// Asks everything; returns how many pairs meet.
    fn check(&mut self) -> usize {
        let mut expected = Vec::new();
        let world = |(_, soup, rows): &(BodyId, MeshData, Rows)| posed(&soup.positions, rows);
        for (place, a) in self.known.iter().enumerate() {
            for b in &self.known[place + 1..] {
                let [s, t] = [a.0, b.0].map(|id| self.scenes[0].body(id).unwrap());
                if !s.options().groups.meet(&t.options().groups)
                    || self.ignored.contains(&[a.0, b.0])
                {
                    continue;
                }
                let found = pairs(&world(a), &a.1.triangles, &world(b), &b.1.triangles);
                let hit =
                    |(t, u)| SceneHit { bodies: [a.0, b.0], pair: TrianglePair { a: t, b: u } };
                expected.extend(found.into_iter().map(hit));
            }
        }
        for scene in &mut self.scenes {
            let ids: Vec<_> = scene.bodies().map(Body::id).collect();
            assert!(
                ids.iter().eq(self.known.iter().map(|(id, ..)| id)) && ids.len() == scene.len()
            );
            // Before the list is known, and when it is kept.
            for _ in 0..2 {
                let mut visited = Vec::new();
                let end = scene.visit(|hit| {
                    visited.push(hit);
                    ControlFlow::Continue(())
                });
                visited.sort_unstable();
                assert!(end.unwrap().is_continue() && visited == expected);
                let any = scene.any().unwrap();
                assert!(
                    any.map_or(expected.is_empty(), |hit| expected.binary_search(&hit).is_ok())
                );
                assert_eq!(scene.count().unwrap(), expected.len() as u64);
                scene.update().unwrap();
                assert!(scene.hits() == expected && scene.all().unwrap() == expected);
            }
            let contacts = scene.contacts().unwrap();
            assert!(contacts.iter().map(|(hit, _)| hit).eq(&expected));
        }
        expected.len()
    }
}

fn model(soup: &MeshData) -> Model {
    Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap()
}

fn soup(rng: &mut impl Rng) -> MeshData {
    match rng.random_range(0..4) {
        0 => sphere(5),
        1 => sheet(4, |x, y| 0.2 * x * y),
        2 => tangle(12, 15, 2, rng),
        _ => MeshData::default(),
    }
}

const IDENTITY: Rows = Pose::IDENTITY.rows;

#[test]
fn anything_may_happen_between_frames() {
    let mut rng = seeded(1);
    let (mut trial, mut met) = (Trial::new(), 0);
    for frame in 0..60 {
        for _ in 0..rng.random_range(0..4) {
            let rows = if rng.random() { pose_rows(1.5, &mut rng) } else { IDENTITY };
            let what = if trial.known.len() < 4 { 0 } else { rng.random_range(0..11) };
            let place = rng.random_range(0..trial.known.len().max(1));
            match what {
                0 => trial.add(soup(&mut rng), rows),
                1 => trial.remove(place),
                2 => trial.split(place, frame % 3 + 1),
                3 | 4 => trial.deform(place, &mut rng),
                5 => trial.group(place, &mut rng),
                6 => trial.ignore([place, rng.random_range(0..trial.known.len())]),
                _ => trial.pose(place, rows),
            }
        }
        while trial.known.len() > 9 {
            trial.remove(0);
        }
        met += trial.check();
    }
    assert!(met > 2000, "{met}");
}

#[test]
fn none_one_and_empty_bodies() {
    let mut trial = Trial::new();
    assert_eq!(trial.check(), 0);
    trial.add(sphere(4), IDENTITY);
    assert_eq!(trial.check(), 0);
    trial.add(MeshData::default(), IDENTITY);
    trial.add(MeshData::default(), Pose::from_translation([1.0; 3]).rows);
    trial.deform(2, &mut seeded(0));
    assert_eq!(trial.check(), 0);
    trial.split(1, 3);
    assert!(trial.known.len() == 2 && trial.scenes[0].len() == 2 && !trial.scenes[0].is_empty());
    trial.add(sphere(4), IDENTITY);
    assert!(trial.check() > 0);
    for _ in 0..3 {
        trial.remove(0);
    }
    assert!(trial.check() == 0 && trial.scenes[0].is_empty());
}

/// The contract rounds both cubes to the world, not one to the frame of the other.
#[test]
fn a_cube_rests_on_a_cube() {
    let cube = cube(6);
    let mut rng = seeded(5);
    let (mut in_world, mut in_frame) = (0, 0);
    for _ in 0..4 {
        let below = pose_rows(0.3, &mut rng);
        let up = [0, 1, 2].map(|i| below[i][2]);
        let above = [0, 1, 2].map(|i| {
            let [x, y, z, t] = below[i];
            [x, y, z, t + up[i]]
        });
        let mut trial = Trial::new();
        trial.add(cube.clone(), below);
        trial.add(cube.clone(), above);
        in_world += trial.check();
        let (cube, relative) = (model(&cube), Pose::from_translation([0.0, 0.0, 1.0]));
        in_frame += PairQuery::new().all(&cube, &cube, relative).unwrap().len();
    }
    assert!(0 < in_world && in_world < in_frame, "{in_world} {in_frame}");
}

/// The unit cube of n × n squares a side.
fn cube(n: u32) -> MeshData {
    let face = |(axis, side): (usize, f32)| {
        sheet(n, |_, _| 0.0).map(|[x, y, _]| {
            let mut p = [side; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (0.5 + 0.5 * x, 0.5 + 0.5 * y);
            p
        })
    };
    union(&[(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0), (2, 1.0)].map(face))
}

#[test]
fn refuses_what_it_cannot_do_and_changes_nothing() {
    let mut trial = Trial::new();
    trial.add(sphere(4), IDENTITY);
    trial.add(sphere(4), Pose::from_translation([0.5, 0.1, 0.2]).rows);
    let met = trial.check();
    let (sphere, id) = (Arc::new(model(&sphere(4))), trial.known[1].0);

    let nan = Pose::from_translation([0.0, f32::NAN, 0.0]);
    let far = Pose::from_translation([0.0, 0.0, 1e38]);
    for (pose, error) in
        [(nan, PoseError::NonFinite { row: 1, column: 3 }), (far, PoseError::Range { row: 2 })]
    {
        let refused = Some(Error::Pose(error));
        assert_eq!(trial.tell(|scene| scene.set_pose(id, pose).err()), refused);
        assert_eq!(trial.tell(|scene| scene.add(sphere.clone(), pose).err()), refused);
        let empty = || Model::new(Vec::new(), Vec::new()).unwrap();
        assert_eq!(trial.tell(|scene| scene.add(empty(), pose).err()), refused);
    }
    let mut positions = trial.known[1].1.positions.clone();
    let refused = trial.tell(|scene| scene.set_positions(id, &positions[1..]).err());
    assert!(matches!(refused, Some(Error::Mesh(MeshError::VertexCount { .. }))));
    positions[7][1] = f32::INFINITY;
    let refused = trial.tell(|scene| scene.set_positions(id, &positions).err());
    assert_eq!(refused, Some(Error::Mesh(MeshError::NonFinite { vertex: 7 })));
    positions[7][1] = 3e38;
    let refused = trial.tell(|scene| scene.set_positions(id, &positions).err());
    assert_eq!(refused, Some(Error::Pose(PoseError::Range { row: 1 })));
    assert_eq!(trial.check(), met);

    let (gone, ..) = trial.known[0];
    trial.remove(0);
    let stale = Some(Error::StaleBody { id: gone });
    assert_eq!(trial.tell(|scene| scene.set_pose(gone, Pose::IDENTITY).err()), stale);
    assert_eq!(trial.tell(|scene| scene.set_positions::<f32>(gone, &[]).err()), stale);
    assert_eq!(trial.tell(|scene| scene.split(gone, |_| 0).err()), stale);
    assert_eq!(trial.tell(|scene| scene.body(gone).map(Body::id).err()), stale);
    let told = Error::StaleBody { id: gone }.to_string();
    assert_eq!(told, "body 0 is not in the scene; it has been removed or split");
    // The new one is another, though it may be in the same place.
    trial.add(MeshData::default(), IDENTITY);
    assert!(trial.known[1].0 > id && trial.check() == 0);
}

#[test]
fn a_shared_model_is_copied_when_one_body_deforms() {
    let shared = Arc::new(model(&sphere(4)));
    let mut scene = SceneQuery::new();
    let ids = [0, 1].map(|_| scene.add(shared.clone(), Pose::IDENTITY).unwrap());
    let small: Vec<_> =
        shared.mesh().positions().unwrap().iter().map(|p| p.map(|x| x * 0.5)).collect();
    scene.set_positions(ids[0], &small).unwrap();
    assert_eq!(scene.body(ids[0]).unwrap().model().mesh().positions().unwrap(), small);
    assert!(Arc::ptr_eq(scene.body(ids[1]).unwrap().model(), &shared));
    assert_eq!(scene.count().unwrap(), 0);
    // Now it has its own, which stays where it is.
    let before = Arc::as_ptr(scene.body(ids[0]).unwrap().model());
    scene.set_positions(ids[0], shared.mesh().positions().unwrap()).unwrap();
    assert_eq!(Arc::as_ptr(scene.body(ids[0]).unwrap().model()), before);
    assert!(scene.count().unwrap() > 0);
}
