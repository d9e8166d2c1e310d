//! Scenes with a long history give the answers of scenes that have none: random edits and questions, on every executor.
//!
//! `PFRONT_ROUNDS` says how many edits and questions there are, `PFRONT_SEED` where they begin.

use pfront::{
    Adjacency, AnyPose, Body, BodyId, BodyOptions, Contact, Error, Executor, Groups, Model, Pose,
    Pose64, SceneHit, SceneQuery,
};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use pfront_testkit::scenes::icosphere;
use pfront_testkit::shapes::{sheet, sphere};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// The most bodies of a scene.
const BODIES: usize = 9;

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap())
}

/// Models in f32 and in f64, of which f32 holds some; one has no triangle.
fn models() -> Vec<Arc<Model>> {
    let shapes = [icosphere(20), sheet(3, |x, y| 0.3 * x * y), sphere(3)];
    let mut models = vec![Model::new(Vec::new(), Vec::new()).unwrap()];
    for shape in shapes {
        let in_f64 = |noise: f64| {
            let place = |(p, i): (&[f32; 3], f64)| p.map(|x| f64::from(x) + noise * i);
            let positions = shape.positions.iter().zip((0..).map(f64::from)).map(place);
            Model::from_f64(positions.collect(), shape.triangles.clone()).unwrap()
        };
        models.extend([in_f64(1e-9), in_f64(0.0)]);
        models.push(Model::new(shape.positions, shape.triangles).unwrap());
    }
    models.into_iter().map(Arc::new).collect()
}

/// A pose on a lattice, so that bodies often touch, and often have the pose that they had.
fn somewhere(rng: &mut impl Rng) -> AnyPose {
    let at = [0; 3].map(|_| f64::from(rng.random_range(-3..=3_i8)) * 0.5);
    let turn = [0.0, 0.0, f64::from(rng.random_range(0..3_u8)), 1.0];
    match rng.random_range(0..8) {
        0 => Pose64::from_rotation_translation(turn, at).into(),
        1 => Pose::from_rotation_translation(turn.map(|x| x as f32), at.map(|x| x as f32)).into(),
        // Zeros of either sign.
        2 => Pose::from_translation([-0.0, 0.0, -0.0]).into(),
        _ => Pose::from_translation(at.map(|x| x as f32)).into(),
    }
}

/// The hits of a scene, by places of bodies instead of ids.
type Listed = Vec<([usize; 2], [u32; 2])>;

struct History {
    name: &'static str,
    scene: SceneQuery,
    executor: Executor,
    flag: Arc<AtomicBool>,
    models: Vec<Arc<Model>>,
}

impl History {
    fn new(name: &'static str, executor: Executor) -> Self {
        let flag = Arc::new(AtomicBool::new(false));
        let executor = executor.with_cancel(flag.clone());
        Self { name, scene: SceneQuery::new().on(&executor), executor, flag, models: models() }
    }

    fn ids(&self) -> Vec<BodyId> {
        self.scene.bodies().map(Body::id).collect()
    }

    fn places(&self, hits: impl IntoIterator<Item = SceneHit>) -> Listed {
        let ids = self.ids();
        let place = |id| ids.binary_search(&id).unwrap();
        hits.into_iter().map(|hit| (hit.bodies.map(place), [hit.pair.a, hit.pair.b])).collect()
    }

    /// A scene of the same bodies, which knows nothing.
    fn fresh(&self) -> SceneQuery {
        let mut fresh = SceneQuery::new();
        let add = |body: &Body| {
            fresh.add_with(body.model().clone(), body.pose(), body.options()).unwrap()
        };
        let ids: Vec<_> = self.scene.bodies().map(add).collect();
        let own = self.ids();
        for two in self.scene.ignored() {
            let [a, b] = two.map(|id| ids[own.binary_search(&id).unwrap()]);
            fresh.ignore(a, b, true).unwrap();
        }
        fresh
    }

    fn edit(&mut self, rng: &mut impl Rng) {
        let ids = self.ids();
        let any_model = self.models[rng.random_range(0..self.models.len())].clone();
        if ids.len() < 2 || ids.len() < BODIES && rng.random_range(0..6) == 0 {
            self.scene.add(any_model, somewhere(rng)).unwrap();
            return;
        }
        let id = ids[rng.random_range(0..ids.len())];
        let model = self.scene.body(id).unwrap().model().clone();
        let scale = f64::from(rng.random_range(0..4_u8)) * 0.25 + 0.5;
        let scene = &mut self.scene;
        match rng.random_range(0..16) {
            0 => drop(scene.remove(id).unwrap()),
            1 => {
                let parts = rng.random_range(1..4);
                let pieces = scene.split(id, |triangle| triangle % parts).unwrap();
                assert_eq!(scene.remove(id).err(), Some(Error::StaleBody { id }));
                // Most of the pieces go again.
                for piece in pieces.iter().skip(1) {
                    scene.remove(piece.body).unwrap();
                }
            }
            2 => {
                let pose = scene.body(id).unwrap().pose();
                scene.set_pose(id, pose).unwrap();
            }
            3 => scene.set_model(id, any_model).unwrap(),
            // The same mesh in another shape, or the same model.
            4 => {
                let mut other = Model::clone(&model);
                if rng.random() && !other.is_f64() {
                    let scaled = other.mesh().shadow().iter().map(|p| p.map(|x| x * scale as f32));
                    let scaled: Vec<_> = scaled.collect();
                    other.set_positions(&scaled).unwrap();
                }
                scene.set_model(id, other).unwrap();
            }
            5 => {
                let mut bits = || 1 << rng.random_range(0..2) | 1 << rng.random_range(0..2);
                let groups = Groups { memberships: bits(), filter: bits() };
                let itself = rng.random::<bool>().then(Adjacency::default);
                let options = BodyOptions { groups, user_data: rng.random(), itself };
                scene.set_options(id, options).unwrap();
            }
            6 => scene.set_options(id, BodyOptions::default()).unwrap(),
            7 => {
                let other = ids[rng.random_range(0..ids.len())];
                scene.ignore(id, other, rng.random()).unwrap();
            }
            8 | 9 => self.deform(id, &model, scale),
            // Bodies that come and go without a question between.
            10 => {
                for _ in 0..rng.random_range(0..80) {
                    let guest = scene.add(any_model.clone(), somewhere(rng)).unwrap();
                    scene.ignore(guest, id, rng.random()).unwrap();
                    scene.remove(guest).unwrap();
                }
            }
            _ => scene.set_pose(id, somewhere(rng)).unwrap(),
        }
        while self.scene.len() > BODIES {
            let id = self.ids()[rng.random_range(0..self.scene.len())];
            self.scene.remove(id).unwrap();
        }
    }

    /// Scales a body; by one it stays as it is.
    fn deform(&mut self, id: BodyId, model: &Arc<Model>, scale: f64) {
        let mesh = model.mesh();
        if let Some(positions) = mesh.positions_f64() {
            let scaled: Vec<_> = positions.iter().map(|p| p.map(|x| x * scale)).collect();
            self.scene.set_positions(id, &scaled).unwrap();
        } else if model.is_f64() {
            let scaled = mesh.shadow().iter().map(|p| p.map(|x| f64::from(x) * scale));
            self.scene.set_positions(id, &scaled.collect::<Vec<_>>()).unwrap();
        } else {
            let scaled = mesh.shadow().iter().map(|p| p.map(|x| x * scale as f32));
            self.scene.set_positions(id, &scaled.collect::<Vec<_>>()).unwrap();
        }
    }

    /// Lists of earlier questions tell of nothing that has gone.
    fn check_lists(&self) {
        let listed = self.scene.hits().iter();
        for hit in listed.chain(self.scene.last_contacts().iter().map(|(hit, _)| hit)) {
            for (id, triangle) in hit.bodies.into_iter().zip([hit.pair.a, hit.pair.b]) {
                let mesh = self.scene.body(id).unwrap().model().mesh();
                assert!((triangle as usize) < mesh.triangles().len());
            }
        }
    }

    /// Asks something, and compares with a fresh scene.
    fn ask(&mut self, rng: &mut impl Rng) -> usize {
        let mut fresh = self.fresh();
        let ids = self.ids();
        let fresh_ids: Vec<_> = fresh.bodies().map(Body::id).collect();
        let in_fresh = |hits: &[SceneHit]| -> Listed {
            let place = |id| fresh_ids.binary_search(&id).unwrap();
            hits.iter().map(|hit| (hit.bodies.map(place), [hit.pair.a, hit.pair.b])).collect()
        };
        let expected = in_fresh(fresh.all().unwrap());
        match rng.random_range(0..10) {
            0 => {
                let hit = self.scene.any().unwrap();
                let found = self.places(hit);
                assert!(found.len() == usize::from(!expected.is_empty()));
                assert!(found.iter().all(|hit| expected.binary_search(hit).is_ok()));
            }
            1 => assert_eq!(self.scene.count().unwrap(), expected.len() as u64),
            2 => {
                let mut pairs: Vec<_> =
                    expected.iter().map(|(two, _)| two.map(|i| ids[i])).collect();
                pairs.dedup();
                assert_eq!(self.scene.intersecting_bodies().unwrap(), pairs);
            }
            3 => {
                let of = |contacts: &[(SceneHit, Contact)]| -> (Vec<_>, Vec<_>) {
                    contacts.iter().copied().unzip()
                };
                let (hits, contacts) = of(self.scene.contacts().unwrap());
                let (fresh_hits, fresh_contacts) = of(fresh.contacts().unwrap());
                assert_eq!(self.places(hits), in_fresh(&fresh_hits));
                assert_eq!(contacts, fresh_contacts);
            }
            4 => {
                let (hits, contacts): (Vec<_>, Vec<_>) =
                    self.scene.contacts_f64().unwrap().into_iter().unzip();
                let (fresh_hits, fresh_contacts): (Vec<_>, Vec<_>) =
                    fresh.contacts_f64().unwrap().into_iter().unzip();
                assert_eq!(self.places(hits), in_fresh(&fresh_hits));
                assert_eq!(contacts, fresh_contacts);
            }
            5 => {
                let (mut visited, most) = (Vec::new(), rng.random_range(0..40));
                let end = self.scene.visit(|hit| {
                    visited.push(hit);
                    if visited.len() == most {
                        ControlFlow::Break(())
                    } else {
                        ControlFlow::Continue(())
                    }
                });
                assert_eq!(end.unwrap().is_break(), most > 0 && most <= expected.len());
                let mut visited = self.places(visited);
                assert!(visited.is_sorted_by_key(|(two, _)| *two));
                visited.sort_unstable();
                if most == 0 || most > expected.len() {
                    assert_eq!(visited, expected);
                } else {
                    assert!(visited.iter().all(|hit| expected.binary_search(hit).is_ok()));
                }
            }
            6 => {
                self.flag.store(true, Relaxed);
                let answer = self.scene.all().map(<[_]>::len);
                self.flag.store(false, Relaxed);
                assert!(matches!(answer, Err(Error::Cancelled)) || answer == Ok(expected.len()));
            }
            7 => {
                self.scene.update().unwrap();
                assert_eq!(self.places(self.scene.hits().to_vec()), expected);
            }
            _ => {
                let hits = self.scene.all().unwrap().to_vec();
                assert_eq!(self.places(hits), expected);
            }
        }
        assert!(self.scene.plan().is_some());
        expected.len()
    }
}

fn run(mut histories: Vec<History>, rounds: u64) {
    let seed = from_environment("PFRONT_SEED").unwrap_or(1);
    let (mut rng, mut met) = (seeded(seed), 0);
    for round in 0..rounds {
        let which = rng.random_range(0..histories.len());
        let history = &mut histories[which];
        let told = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            for _ in 0..rng.random_range(0..4) {
                history.edit(&mut rng);
                history.check_lists();
            }
            if rng.random_range(0..200) == 0 {
                history.scene = std::mem::take(&mut history.scene).on(&history.executor);
            }
            history.ask(&mut rng)
        }));
        met += told.unwrap_or_else(|panic| {
            eprintln!("seed {seed}, round {round}, {}", histories[which].name);
            std::panic::resume_unwind(panic)
        });
    }
    assert!(met as u64 > rounds, "{met} hits in {rounds} rounds");
}

#[test]
fn a_scene_with_a_history_answers_as_a_fresh_one() {
    #[cfg_attr(not(feature = "threads"), expect(unused_mut, reason = "there are no others"))]
    let mut histories = vec![History::new("one thread", Executor::sequential())];
    #[cfg(feature = "threads")]
    {
        use pfront::threads::{Pool, Schedule, Settings};
        let settings = Settings { schedule: Schedule::Static, ..Settings::default() };
        histories.push(History::new("threads", Executor::threads(2)));
        histories.push(History::new("static", Pool::new(3).with_settings(settings).into()));
    }
    run(histories, from_environment("PFRONT_ROUNDS").unwrap_or(2_000));
}

/// In lists so short that most answers take several runs.
#[cfg(feature = "gpu")]
#[test]
fn likewise_on_a_gpu() {
    use pfront::gpu::{Budget, Gpu, GpuSettings};
    let gpu = Gpu::new().unwrap();
    let settings = GpuSettings { budget: Budget { bytes: 64 << 10 }, ..gpu.settings() };
    let on_gpu = Executor::gpu(&gpu, settings);
    let history = History::new("GPU", on_gpu);
    run(vec![history], from_environment("PFRONT_ROUNDS").unwrap_or(2_000) / 20);
}
