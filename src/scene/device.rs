//! A scene's bodies on a GPU, brought there when it is first asked and kept up to date from then on.

use super::SceneHit;
use super::bodies::{Bodies, BodyId};
use super::frame::Given;
use crate::answer::Want;
use crate::gpu::{self, Error, Gpu, Settings, Shape};
use crate::model::{Model, Stamp};
use crate::planner::{Owed, Planner};
use pfront_core::bvtt::TrianglePair;
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct Device {
    gpu: Gpu,
    settings: Settings,
    scene: Option<Scene>,
}

/// A clone has to bring its bodies there by itself.
impl Clone for Device {
    fn clone(&self) -> Self {
        Self { gpu: self.gpu.clone(), settings: self.settings, scene: None }
    }
}

#[derive(Debug)]
struct Scene {
    query: gpu::SceneQuery,
    /// The bodies there, as they were brought; both ids ascend.
    bodies: Vec<Brought>,
    /// The time of the last frame that was asked there.
    at: u64,
}

#[derive(Clone, Copy, Debug)]
struct Brought {
    body: BodyId,
    there: gpu::BodyId,
    stamp: Stamp,
}

impl Device {
    /// The planner's, if it knows what to expect of it.
    pub(super) fn new(planner: &Planner) -> Option<Self> {
        let (gpu, settings) = planner.device()?;
        Some(Self { gpu, settings, scene: None })
    }

    /// What it lacks.
    pub(super) fn owed(&self, bodies: &Bodies) -> Owed {
        let [all, vertices] = bodies.sizes();
        // What gpu::SceneQuery says that it takes.
        let bytes = self.settings.budget.bytes + 77 * all as u64 + 28 * vertices as u64;
        // One that comes or goes makes it bring all.
        let is_there = self.scene.as_ref().is_some_and(|scene| bodies.gathered() <= scene.at);
        let triangles = if is_there { 0 } else { all };
        Owed { triangles, bytes, compile: !self.gpu.is_warm() }
    }

    /// What it takes to move bodies there in each frame, in nanoseconds: its broad phase, and a refit of all.
    pub(super) fn upkeep(&self, bodies: &Bodies, planner: &Planner) -> f64 {
        let [triangles, _] = bodies.sizes();
        let question = planner.machine().device.as_ref().map_or(0.0, |device| device.question);
        // As found on an H200, where a question takes 135 us.
        1.5 * question + 4.0 * triangles as f64 + 400.0 * bodies.len() as f64
    }

    /// Asks about all bodies; tells how many leaf pairs there were as well.
    pub(super) fn ask(
        &mut self,
        bodies: &Bodies,
        want: Want,
        hits: &mut Vec<SceneHit>,
    ) -> Result<(Given, u32), Error> {
        let scene = match &mut self.scene {
            Some(scene) => scene,
            none => {
                let query = gpu::SceneQuery::with_settings(&self.gpu, self.settings)?;
                none.insert(Scene { query, bodies: Vec::new(), at: 0 })
            }
        };
        scene.bring(bodies)?;
        let Scene { query, bodies: brought, .. } = scene;
        let own = |hit: &gpu::SceneHit| {
            let bodies = hit.bodies.map(|there| {
                let place = brought.binary_search_by_key(&there, |body| body.there);
                // Every body there is one that was brought.
                brought[place.unwrap_or_default()].body
            });
            let TrianglePair { a, b } = hit.pair;
            SceneHit { bodies, pair: TrianglePair { a, b } }
        };
        let given = match want {
            Want::All => {
                hits.extend(query.all()?.iter().map(own));
                Given::listed(hits)
            }
            Want::Count => Given::counted(query.count()?),
            Want::Any => Given::found(query.any()?.as_ref().map(own)),
        };
        Ok((given, query.report().leaf_pairs))
    }
}

impl Scene {
    /// Makes the bodies there those of the scene.
    fn bring(&mut self, bodies: &Bodies) -> Result<(), Error> {
        if bodies.gathered() > self.at || self.at == 0 {
            self.gather(bodies)?;
        }
        for (body, brought) in bodies.iter().zip(&mut self.bodies) {
            if bodies.changed([body.id(); 2]) <= self.at {
                continue;
            }
            let stamp = body.model().stamp();
            if stamp.positions() != brought.stamp.positions() {
                self.query.set_positions(brought.there, body.model().mesh().positions())?;
                brought.stamp = stamp;
            }
            self.query.set_pose(brought.there, body.pose())?;
        }
        self.at = bodies.time();
        Ok(())
    }

    /// Takes out bodies that are gone and adds those that have come.
    fn gather(&mut self, bodies: &Bodies) -> Result<(), Error> {
        let (query, mut gone) = (&mut self.query, Ok(()));
        self.bodies.retain(|brought| {
            let stays = bodies.get(brought.body).is_ok();
            if !stays && let Err(error) = query.remove(brought.there) {
                gone = Err(error);
            }
            stays
        });
        gone?;
        let last = self.bodies.last().map(|brought| brought.body);
        let mut shapes: Vec<(Stamp, Arc<Shape>)> = Vec::new();
        for body in bodies.iter().filter(|body| Some(body.id()) > last) {
            let model: &Model = body.model();
            let stamp = model.stamp();
            let shape = match shapes.iter().find(|(known, _)| *known == stamp) {
                Some((_, shape)) => shape.clone(),
                None => {
                    let shape = Arc::new(Shape::new(model.bvh()));
                    shapes.push((stamp, shape.clone()));
                    shape
                }
            };
            let there = query.add(shape, body.pose())?;
            self.bodies.push(Brought { body: body.id(), there, stamp });
        }
        Ok(())
    }
}
