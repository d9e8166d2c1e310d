//! Bodies that come, go, move, deform and break, as two scenes are told and as they are known to be.

use crate::body::Body;
use crate::input::{Build, Builder, Change, Crew, Few, Palette, Placing, Question, Shape, Step};
use crate::truth::Truth;
use pfront::pfront_core::bvtt::PosedBvh;
use pfront::{BodyId, Bvh, Error, Executor, PairQuery, Piece, Pose, SceneQuery, SelfQuery};
use pfront_testkit::MeshData;
use pfront_testkit::shapes::posed;
use std::fmt::Debug;
use std::mem::take;
use std::sync::Arc;

/// Bodies, and two sets of queries that are asked the same from call to call: one on the calling thread,
/// one divided among workers, who remember what the last frame cost.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) palette: Palette,
    pub(crate) bodies: Vec<Known>,
    pub(crate) one: Queries,
    pub(crate) many: Queries,
    pub(crate) truth: Truth,
}

/// A body as the test knows it.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) id: BodyId,
    pub(crate) body: Body,
    pub(crate) pose: Pose,
}

impl Known {
    /// The mesh in the world.
    pub(crate) fn world(&self) -> MeshData {
        placed(&self.body.soup, &self.pose)
    }
}

/// The mesh in a pose.
///
/// # Panics
/// If a corner is not finite there, which a pose that was accepted rules out.
pub(crate) fn placed(soup: &MeshData, pose: &Pose) -> MeshData {
    let MeshData { positions, triangles } = soup.clone();
    let positions = posed(&positions, &pose.rows);
    let corners = triangles.iter().flatten().map(|&v| positions[v as usize]);
    assert!(corners.flatten().all(|x| x.is_finite()), "{pose:?}");
    MeshData { positions, triangles }
}

#[derive(Debug, Default)]
pub(crate) struct Queries {
    pub(crate) pair: PairQuery,
    pub(crate) within: SelfQuery,
    pub(crate) scene: SceneQuery,
}

impl Queries {
    fn on(self, executor: &Executor) -> Self {
        let Self { pair, within, scene } = self;
        Self { pair: pair.on(executor), within: within.on(executor), scene: scene.on(executor) }
    }
}

/// Every pair of bodies is asked of the oracle.
const MOST_BODIES: usize = 4;

impl World {
    /// An empty one.
    pub(crate) fn new(palette: Palette) -> Self {
        let one = Queries::default();
        let many = Queries::default().on(&Executor::threads(3));
        Self { palette, bodies: Vec::new(), one, many, truth: Truth::default() }
    }

    /// Lets something happen and asks all backends.
    pub(crate) fn step(&mut self, step: &Step) {
        self.change(&step.change);
        while self.bodies.len() > MOST_BODIES {
            self.remove(0);
        }
        match &step.question {
            _ if self.bodies.is_empty() => {}
            Question::Scene => {}
            Question::Pair(two, placing) => self.ask_pair(self.two(*two), *placing, step.ask),
            Question::World(two) => self.ask_world(self.two(*two), step.ask),
            Question::Within(place, skip) => {
                self.ask_within(self.place(*place), *skip, step.ask);
            }
        }
        // The history of one frame must not spoil the next, whatever has changed.
        self.ask_scene(step.ask);
    }

    fn change(&mut self, change: &Change) {
        match change {
            Change::Nothing => {}
            Change::Add(shape, placing, build) => self.add(shape, *placing, *build),
            Change::Divide(crew) => self.divide(*crew),
            _ if self.bodies.is_empty() => {}
            Change::Again(place, placing) => {
                let body = self.bodies[self.place(*place)].body.clone();
                self.push(body, *placing);
            }
            Change::Remove(place) => self.remove(self.place(*place)),
            Change::Split(place, parts) => self.split(self.place(*place), *parts),
            Change::Move(place, placing) => self.set_pose(self.place(*place), *placing),
            Change::Deform(place, some, all) => {
                let all = all.as_ref().and_then(Option::as_ref);
                self.deform(self.place(*place), some.all(), all.map(Few::all));
            }
            Change::Rebuild(place, build) => self.rebuild(self.place(*place), *build),
        }
    }

    fn two(&self, places: [u8; 2]) -> [usize; 2] {
        places.map(|place| self.place(place))
    }

    fn place(&self, place: u8) -> usize {
        usize::from(place) % self.bodies.len()
    }

    /// Tells both scenes, which say the same.
    fn tell<R: PartialEq + Debug>(&mut self, mut call: impl FnMut(&mut SceneQuery) -> R) -> R {
        let said = call(&mut self.one.scene);
        assert_eq!(call(&mut self.many.scene), said);
        said
    }

    pub(crate) fn add(&mut self, shape: &Shape, placing: Placing, build: Build) {
        if let Ok(body) = Body::new(shape.soup(&self.palette), build) {
            self.push(body, placing);
        }
    }

    fn push(&mut self, body: Body, placing: Placing) {
        let (model, pose) = (Arc::new(body.model.clone()), placing.pose(&self.palette));
        let id = self.tell(|scene| scene.add(model.clone(), pose));
        assert_eq!(id.as_ref().err(), refusal(body.bvh(), &pose).as_ref());
        if let Ok(id) = id {
            self.bodies.push(Known { id, body, pose });
        }
    }

    fn remove(&mut self, place: usize) {
        let id = self.bodies.remove(place).id;
        assert_eq!(self.tell(|scene| scene.remove(id).map(|body| body.id())), Ok(id));
        let stale = Some(Error::StaleBody { id });
        assert_eq!(self.tell(|scene| scene.remove(id).err()), stale);
        assert_eq!(self.tell(|scene| scene.set_pose(id, Pose::IDENTITY).err()), stale);
        assert_eq!(self.tell(|scene| scene.set_positions::<f32>(id, &[]).err()), stale);
        assert_eq!(self.tell(|scene| scene.split(id, |_| 0).err()), stale);
    }

    fn set_pose(&mut self, place: usize, placing: Placing) {
        let (id, pose) = (self.bodies[place].id, placing.pose(&self.palette));
        let said = self.tell(|scene| scene.set_pose(id, pose));
        let known = &mut self.bodies[place];
        assert_eq!(said.as_ref().err(), refusal(known.body.bvh(), &pose).as_ref());
        if said.is_ok() {
            known.pose = pose;
        }
    }

    fn deform(&mut self, place: usize, some: &[(u8, [u8; 3])], all: Option<&[[u8; 3]]>) {
        let Known { id, body, .. } = &self.bodies[place];
        let (id, mut positions) = (*id, body.soup.positions.clone());
        if let Some(all) = all {
            positions = self.palette.points(all);
        }
        let n = positions.len().max(1);
        for (vertex, pick) in some {
            if let Some(p) = positions.get_mut(usize::from(*vertex) % n) {
                *p = pick.map(|pick| self.palette.number(pick));
            }
        }
        // A pose that cannot take it is what only a scene can refuse.
        let said = self.tell(|scene| scene.set_positions(id, &positions));
        if !matches!(said, Err(Error::Pose(_))) {
            assert_eq!(self.bodies[place].body.deform(&positions), said);
        }
    }

    /// The scenes keep the BVHs that they have.
    fn rebuild(&mut self, place: usize, build: Build) {
        let body = &mut self.bodies[place].body;
        *body = Body::new(body.soup.clone(), build).unwrap();
    }

    fn split(&mut self, place: usize, parts: u8) {
        let parts = u32::from(parts.max(1));
        let Known { id, body, pose } = self.bodies.remove(place);
        let part_of = |triangle: u32| triangle * 7 % parts;
        let pieces = self.tell(|scene| scene.split(id, part_of)).unwrap();
        let total: usize = pieces.iter().map(|piece| piece.triangles.len()).sum();
        assert_eq!(total, body.soup.triangles.len());
        for Piece { body: id, part, triangles, .. } in pieces {
            assert!(triangles.is_sorted() && triangles.iter().all(|&t| part_of(t) == part));
            let mesh = self.one.scene.body(id).unwrap().model().mesh();
            let was = |&old: &u32| body.model.mesh().shadow_triangle(old);
            assert!((0..).zip(&triangles).all(|(new, old)| mesh.shadow_triangle(new) == was(old)));
            let (positions, triangles) =
                (mesh.positions().unwrap().to_vec(), mesh.triangles().to_vec());
            let build = Build { leaf_size: 1, builder: Builder::Morton };
            let body = Body::new(MeshData { positions, triangles }, build).unwrap();
            self.bodies.push(Known { id, body, pose });
        }
    }

    fn divide(&mut self, crew: Crew) {
        self.many = take(&mut self.many).on(&crew.pool().into());
    }
}

/// Why the core will not pose a mesh so.
fn refusal(bvh: Bvh<'_>, pose: &Pose) -> Option<Error> {
    let refused = PosedBvh::new(bvh, pose).err();
    assert!(refused.is_some() || pose.rows.as_flattened().iter().all(|x| x.is_finite()));
    refused.map(Error::Pose)
}
