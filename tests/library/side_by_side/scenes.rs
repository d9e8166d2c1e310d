//! A scene, and what is in it as far as the player knows.

use super::executors::{Executors, QueryExecutor};
use super::models::{Fresh, Points, Shape, somewhere};
use super::truth::{Answers, Truth, Verb};
use pfront::{
    Adjacency, AnyPose, Body, BodyId, BodyOptions, Error, Groups, Pose, SceneHit, SceneQuery,
};
use pfront_testkit::rng::{Rng, RngExt};
use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::rc::Rc;

/// The most bodies of a scene.
const BODIES: usize = 8;

/// Whether a body is to be asked about itself, which a third is.
fn itself(rng: &mut impl Rng) -> Option<Adjacency> {
    match rng.random_range(0..6) {
        0 => Some(Adjacency::SharedIndexRule),
        1 => Some(Adjacency::SkipNeighbours),
        _ => None,
    }
}

/// A body as it should be in the scene.
#[derive(Clone)]
struct KnownBody {
    id: BodyId,
    fresh: Rc<Fresh>,
    pose: AnyPose,
    options: BodyOptions,
    /// The body in the world, in f32 and in f64.
    placed: [OnceCell<Rc<Fresh>>; 2],
}

impl KnownBody {
    fn new(id: BodyId, fresh: Rc<Fresh>, pose: AnyPose, options: BodyOptions) -> Self {
        Self { id, fresh, pose, options, placed: Default::default() }
    }

    fn is_f64(&self) -> bool {
        self.pose.is_f64() || self.fresh.model.is_f64()
    }

    fn placed(&self, is_in_f64: bool) -> &Rc<Fresh> {
        self.placed[usize::from(is_in_f64)].get_or_init(|| {
            let points = self.fresh.points.posed(&self.pose, is_in_f64);
            Fresh::new(points, self.fresh.model.mesh().triangles())
        })
    }
}

/// A scene, its executor and its bodies in the order of their ids.
#[derive(Clone)]
pub(crate) struct ScenePlayer {
    pub(crate) scene: SceneQuery,
    pub(crate) seat: QueryExecutor,
    known: Vec<KnownBody>,
    ignored: BTreeSet<[BodyId; 2]>,
}

impl ScenePlayer {
    pub(crate) fn new(seat: QueryExecutor, executors: &Executors) -> Self {
        let scene = SceneQuery::new().on(executors.executor(seat));
        Self { scene, seat, known: Vec::new(), ignored: BTreeSet::new() }
    }

    /// The answer as the union of all pairs of bodies.
    pub(crate) fn truth(&self, answers: &mut Answers, verb: Verb) -> Truth<SceneHit> {
        let mut truth = Truth::default();
        for (i, a) in self.known.iter().enumerate() {
            if let Some(adjacency) = a.options.itself {
                let answer = answers.within(&a.fresh, adjacency);
                truth
                    .add_posed(&answer, verb, &a.pose, |pair| SceneHit { bodies: [a.id; 2], pair });
            }
            for b in &self.known[i + 1..] {
                let bodies = [a.id, b.id];
                if self.ignored.contains(&bodies) || !a.options.groups.meet(&b.options.groups) {
                    continue;
                }
                let is_in_f64 = a.is_f64() || b.is_f64();
                let two = [a.placed(is_in_f64), b.placed(is_in_f64)];
                let answer = answers.pair(two, &Pose::IDENTITY.into());
                truth.add(&answer, verb, |pair| SceneHit { bodies, pair });
            }
        }
        truth
    }

    /// Changes something.
    pub(crate) fn edit(&mut self, shapes: &[Shape], rng: &mut impl Rng) {
        let shape = &shapes[rng.random_range(0..shapes.len())];
        let n = self.known.len();
        if n < 2 || n < BODIES && rng.random_range(0..8) == 0 {
            self.add(shape, rng);
            return;
        }
        let at = rng.random_range(0..n);
        let (id, pose) = (self.known[at].id, self.known[at].pose);
        match rng.random_range(0..14) {
            0 => self.remove(at),
            1 => self.split(at, rng),
            2 => self.scene.set_pose(id, pose).unwrap(),
            3 | 4 => {
                self.scene.set_model(id, shape.model.clone()).unwrap();
                let options = self.known[at].options;
                self.known[at] = KnownBody::new(id, shape.fresh.clone(), pose, options);
            }
            5 => {
                let mut bits = || 1 << rng.random_range(0..2) | 1 << rng.random_range(0..2);
                let groups = Groups { memberships: bits(), filter: bits() };
                let options = BodyOptions { groups, user_data: rng.random(), itself: itself(rng) };
                self.scene.set_options(id, options).unwrap();
                self.known[at].options = options;
            }
            6 => {
                self.scene.set_options(id, BodyOptions::default()).unwrap();
                self.known[at].options = BodyOptions::default();
            }
            7 => {
                let (other, is_ignored) = (self.known[rng.random_range(0..n)].id, rng.random());
                self.scene.ignore(id, other, is_ignored).unwrap();
                let two = [id.min(other), id.max(other)];
                if is_ignored && id != other {
                    self.ignored.insert(two);
                } else {
                    self.ignored.remove(&two);
                }
            }
            8..=10 => self.deform(at, rng),
            _ => {
                let pose = somewhere(rng);
                self.scene.set_pose(id, pose).unwrap();
                let KnownBody { fresh, options, .. } = &self.known[at];
                self.known[at] = KnownBody::new(id, fresh.clone(), pose, *options);
            }
        }
        while self.known.len() > BODIES {
            self.remove(rng.random_range(0..self.known.len()));
        }
        assert!(self.scene.bodies().map(Body::id).eq(self.known.iter().map(|known| known.id)));
    }

    fn add(&mut self, shape: &Shape, rng: &mut impl Rng) {
        let pose = somewhere(rng);
        let options = BodyOptions { itself: itself(rng), ..BodyOptions::default() };
        let id = self.scene.add_with(shape.model.clone(), pose, options).unwrap();
        self.known.push(KnownBody::new(id, shape.fresh.clone(), pose, options));
    }

    fn remove(&mut self, at: usize) {
        let id = self.known.remove(at).id;
        self.scene.remove(id).unwrap();
        self.forget(id);
    }

    fn forget(&mut self, id: BodyId) {
        assert_eq!(self.scene.body(id).err(), Some(Error::StaleBody { id }));
        self.ignored.retain(|two| !two.contains(&id));
    }

    fn deform(&mut self, at: usize, rng: &mut impl Rng) {
        let KnownBody { id, fresh, pose, options, .. } = &self.known[at];
        let points = fresh.deformed(rng);
        match &points {
            Points::F32(points) => self.scene.set_positions(*id, points).unwrap(),
            Points::F64(points) => self.scene.set_positions(*id, points).unwrap(),
        }
        self.known[at] = KnownBody::new(*id, fresh.with(points), *pose, *options);
    }

    /// Splits a body, whose pieces have the triangles that it had.
    fn split(&mut self, at: usize, rng: &mut impl Rng) {
        let KnownBody { id, fresh, pose, options, .. } = self.known.remove(at);
        let parts = rng.random_range(1..4);
        for piece in self.scene.split(id, |triangle| triangle % parts).unwrap() {
            let model = self.scene.body(piece.body).unwrap().model();
            let triangles = model.mesh().triangles();
            assert_eq!(triangles.len(), piece.triangles.len());
            for (new, &old) in (0..).zip(&piece.triangles) {
                assert_eq!(old % parts, piece.part);
                let [own, whole] = [(&**model, new), (&fresh.model, old)]
                    .map(|(model, i)| model.mesh().shadow_triangle(i));
                assert!(model.is_f64() || own == whole);
            }
            let fresh = Fresh::new(Points::of(model), triangles);
            self.known.push(KnownBody::new(piece.body, fresh, pose, options));
        }
        self.forget(id);
    }
}
