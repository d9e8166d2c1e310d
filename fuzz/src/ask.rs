//! The questions: each of every backend, in all verbs, against brute force.

use crate::answers::{Answers, first_few, of_core, pages};
use crate::input::{Ask, Placing, adjacency};
use crate::truth::overlapping;
use crate::world::{World, placed};
use pfront::pfront_core::bvtt::{self, PosedBvh};
use pfront::{Error, Model, PairQuery, Pose, SceneHit, SceneQuery, SelfQuery, TrianglePair};
use std::mem::take;

impl World {
    pub(crate) fn ask_everything(&mut self, ask: Ask) {
        self.ask_scene(ask);
        for place in 0..self.bodies.len() {
            self.ask_within(place, false, ask);
            let two = [place, (place + 1) % self.bodies.len()];
            self.ask_pair(two, Placing::Here, ask);
            self.ask_world(two, ask);
        }
    }

    pub(crate) fn ask_pair(&mut self, two: [usize; 2], placing: Placing, ask: Ask) {
        let pose = placing.pose(&self.palette);
        let [a, b] = two.map(|place| &self.bodies[place].body);
        let core = bvtt::PairBvtt::new(a.bvh(), b.bvh(), pose).map(|query| of_core(&query, ask));
        let said = [&mut self.one, &mut self.many]
            .map(|queries| of_two(&mut queries.pair, &a.model, &b.model, &pose, ask));
        match (core, said) {
            (Ok(core), [Ok(one), Ok(many)]) => {
                let truth = self.truth.between(&a.soup, &placed(&b.soup, &pose));
                one.same(&many);
                [core, one, many].iter().for_each(|answers| answers.check(&truth, ask));
            }
            (core, [one, many]) => {
                let error = core.err().map(Error::Pose);
                assert!(error.is_some(), "{one:?} {many:?}");
                assert_eq!([one.err(), many.err()], [error.clone(), error]);
            }
        }
    }

    pub(crate) fn ask_world(&mut self, two: [usize; 2], ask: Ask) {
        let [a, b] = two.map(|place| &self.bodies[place]);
        let truth = self.truth.between(&a.world(), &b.world());
        for (s, t) in [
            (a.body.bvh(), b.body.bvh()),
            (a.body.model.bvh(), b.body.bvh()),
            (a.body.model.bvh(), b.body.model.bvh()),
        ] {
            let [s, t] = [(s, a), (t, b)].map(|(bvh, it)| PosedBvh::new(bvh, &it.pose).unwrap());
            let query = bvtt::PairBvtt::in_world(s, t);
            of_core(&query, ask).check(&truth, ask);
        }
    }

    pub(crate) fn ask_within(&mut self, place: usize, skip: bool, ask: Ask) {
        let body = &self.bodies[place].body;
        let truth = self.truth.within(&body.soup, skip);
        let [one, many] = [&mut self.one, &mut self.many].map(|queries| {
            queries.within = take(&mut queries.within).with_adjacency(adjacency(skip));
            of_one(&mut queries.within, &body.model, ask).unwrap()
        });
        one.same(&many);
        [one, many].iter().for_each(|answers| answers.check(&truth, ask));
        for bvh in [body.bvh(), body.model.bvh()] {
            let query = bvtt::SelfBvtt::new(bvh).with_adjacency(adjacency(skip));
            of_core(&query, ask).check(&truth, ask);
            of_core(&query.with_certificates(body.model.certificates()), ask).check(&truth, ask);
            let boxes = pages(&query.boxes_only(), ask.page());
            assert_eq!(boxes, overlapping(&body.soup));
        }
    }

    pub(crate) fn ask_scene(&mut self, ask: Ask) {
        let worlds: Vec<_> = self.bodies.iter().map(|known| (known.id, known.world())).collect();
        let mut truth = Vec::new();
        for (i, (first, a)) in worlds.iter().enumerate() {
            for (second, b) in &worlds[i + 1..] {
                let hit = |pair| SceneHit { bodies: [*first, *second], pair };
                truth.extend(self.truth.between(a, b).into_iter().map(hit));
            }
        }
        let [one, many] = [&mut self.one, &mut self.many].map(|queries| {
            assert_eq!(queries.scene.len(), worlds.len());
            assert!(queries.scene.bodies().map(|body| body.id()).eq(worlds.iter().map(|w| w.0)));
            of_many(&mut queries.scene, ask).unwrap()
        });
        one.same(&many);
        [one, many].iter().for_each(|answers| answers.check(&truth, ask));
    }
}

/// All verbs give the same error, if any.
fn of_two(
    query: &mut PairQuery,
    a: &Model,
    b: &Model,
    pose: &Pose,
    ask: Ask,
) -> Result<Answers<TrianglePair>, Error> {
    let mut visited = Vec::new();
    let visit = query.visit(a, b, pose, first_few(&mut visited, ask));
    let any = query.any(a, b, pose);
    let count = query.count(a, b, pose);
    let contacts = query.contacts(a, b, pose).map(<[_]>::to_vec);
    let all = query.all(a, b, pose).map(<[_]>::to_vec);
    let error = all.as_ref().err();
    let errors = [visit.as_ref().err(), any.as_ref().err(), count.as_ref().err()];
    assert_eq!((errors, contacts.as_ref().err()), ([error; 3], error));
    Ok(Answers { all: all?, count: count?, any: any?, visited, contacts: contacts? })
}

fn of_one(query: &mut SelfQuery, model: &Model, ask: Ask) -> Result<Answers<TrianglePair>, Error> {
    let mut visited = Vec::new();
    let _ = query.visit(model, first_few(&mut visited, ask))?;
    let (any, count) = (query.any(model)?, query.count(model)?);
    let contacts = query.contacts(model)?.to_vec();
    Ok(Answers { all: query.all(model)?.to_vec(), count, any, visited, contacts })
}

fn of_many(scene: &mut SceneQuery, ask: Ask) -> Result<Answers<SceneHit>, Error> {
    let mut visited = Vec::new();
    let _ = scene.visit(first_few(&mut visited, ask))?;
    let (any, count) = (scene.any()?, scene.count()?);
    let contacts = scene.contacts()?.to_vec();
    Ok(Answers { all: scene.all()?.to_vec(), count, any, visited, contacts })
}
