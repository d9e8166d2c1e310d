//! The bodies of a scene on a GPU, brought there when it is first asked and kept up to date from then on.

use super::SceneHit;
use super::bodies::Bodies;
use super::broad::Places;
use super::frame::{Answer, Frame};
use crate::executor::{Device, Verb};
use crate::gpu::{GpuError, World};
use crate::model::Stamp;
use pfront_core::bvtt::TrianglePair;

#[derive(Debug, Default)]
pub(super) struct Mirror(Option<Scene>);

/// A clone has to bring its bodies there by itself.
impl Clone for Mirror {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug)]
struct Scene {
    world: World,
    /// The models of the bodies there, as they were brought.
    stamps: Vec<Stamp>,
    /// The time of the last frame that was asked there; 0 before the first.
    at: u64,
    pairs: Vec<Places>,
}

impl Mirror {
    /// Triangles to upload: one body that comes or goes makes it bring all.
    pub(super) fn lacks(&self, bodies: &Bodies) -> usize {
        let is_there = self.0.as_ref().is_some_and(|scene| bodies.gathered() <= scene.at);
        if is_there { 0 } else { bodies.triangles() }
    }

    /// Asks about the pairs of bodies of a frame.
    pub(super) fn ask(
        &mut self,
        device: &Device,
        frame: &Frame<'_>,
        verb: Verb,
        hits: &mut Vec<SceneHit>,
    ) -> Result<Answer, GpuError> {
        let scene = match &mut self.0 {
            Some(scene) => scene,
            none => none.insert(Scene {
                world: World::new(&device.gpu, device.settings)?,
                stamps: Vec::new(),
                at: 0,
                pairs: Vec::new(),
            }),
        };
        scene.bring(frame.bodies)?;
        let Scene { world, pairs, .. } = scene;
        pairs.clear();
        pairs.extend(frame.pairs());
        let own = |&(places, pair): &(Places, TrianglePair)| {
            let [a, b] = places.map(|place| frame.bodies.at(place));
            Some(SceneHit { bodies: [a?.id(), b?.id()], pair })
        };
        Ok(match verb {
            Verb::All => {
                hits.extend(world.all(pairs)?.iter().filter_map(own));
                Answer::listed(hits)
            }
            Verb::Count => Answer::counted(world.count(pairs)?),
            Verb::Any => Answer::found(world.any(pairs)?.as_ref().and_then(own)),
        })
    }
}

impl Scene {
    /// Makes the bodies there those of the scene.
    fn bring(&mut self, bodies: &Bodies) -> Result<(), GpuError> {
        // After an error nothing is known of what is there.
        let at = std::mem::take(&mut self.at);
        let is_there = at > 0 && bodies.gathered() <= at;
        if !is_there {
            let bvhs: Vec<_> = bodies.iter().map(|body| body.model().bvh()).collect();
            self.world.set_bodies(&bvhs)?;
            self.stamps.clear();
            self.stamps.extend(bodies.iter().map(|body| body.model().stamp()));
        }
        for ((body, stamp), number) in bodies.iter().zip(&mut self.stamps).zip(0..) {
            if is_there && bodies.changed([body.id(); 2]) <= at {
                continue;
            }
            let model = body.model();
            if model.stamp().positions() != stamp.positions() {
                self.world.set_positions(number, model.mesh().positions())?;
                *stamp = model.stamp();
            }
            self.world.set_pose(number, model.bvh(), body.pose())?;
        }
        self.at = bodies.time();
        Ok(())
    }
}
