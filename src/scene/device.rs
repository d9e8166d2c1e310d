//! The bodies of a scene on a GPU: each mesh is brought there when a body first has it, and kept up to date from then on.

use super::bodies::Bodies;
use super::body::Body;
use super::broad::Places;
use super::hit::SceneHit;
use super::id::BodyId;
use super::pairs::BodyPairs;
use crate::executor::{Answer, Device, Hidden, Verb};
use crate::gpu::{GpuError, World};
use crate::memory::{extend, push};
use crate::{AnyPose, Error, Model, Pose, Stamp};
use pfront_core::bvtt::TrianglePair;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[derive(Debug, Default)]
pub(super) struct DeviceScene {
    scene: Option<Hidden<Scene>>,
    lack: Lack,
}

/// Triangles that were found to lack, by the times when bodies were last added or removed, and when they were there.
#[derive(Debug, Default)]
struct Lack {
    times: Option<[u64; 2]>,
    triangles: usize,
}

/// A clone has to bring its bodies there by itself.
impl Clone for DeviceScene {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[derive(Debug)]
struct Scene {
    world: World,
    /// The numbers of the meshes there, by the models that they were brought from.
    meshes: HashMap<Stamp, u32>,
    /// Triangles of the meshes there.
    triangles: usize,
    /// The bodies there and the models of their meshes; none of a body in f64, in whose place another stands that nothing asks
    /// about.
    bodies: Vec<(BodyId, Option<Stamp>)>,
    /// The time of the last frame that was asked there; 0 before the first.
    at: u64,
    pairs: Vec<Places>,
}

impl DeviceScene {
    /// Triangles to upload: those of meshes that no body there has.
    ///
    /// # Complexity
    /// O(bodies) where bodies have been added or removed, else O(1).
    pub(super) fn lacks(&mut self, bodies: &Bodies) -> usize {
        let Self { scene, lack } = self;
        let at = scene.as_ref().map_or(0, |scene| scene.at);
        let times = [bodies.gathered(), at];
        if at > 0 && bodies.gathered() <= at {
            return 0;
        }
        if lack.times.replace(times) != Some(times) {
            let mut known: HashSet<Stamp> =
                scene.iter().flat_map(|scene| scene.meshes.keys().copied()).collect();
            let new = in_f32(bodies).filter(|body| known.insert(body.model().stamp()));
            lack.triangles = new.map(|body| triangles(body.model())).sum();
        }
        lack.triangles
    }

    /// Asks about the pairs of bodies of a frame, of which none is in f64.
    pub(super) fn ask(
        &mut self,
        device: &Device,
        frame: &BodyPairs<'_>,
        cancel: Option<&Arc<AtomicBool>>,
        verb: Verb,
        hits: &mut Vec<SceneHit>,
    ) -> Result<Answer<SceneHit>, Error> {
        let scene = match &mut self.scene {
            Some(scene) => scene,
            none => none.insert(Hidden::new(Scene {
                world: World::new(&device.gpu, device.settings)?,
                meshes: HashMap::new(),
                triangles: 0,
                bodies: Vec::new(),
                at: 0,
                pairs: Vec::new(),
            })),
        };
        scene.bring(frame.bodies)?;
        let Scene { world, pairs, .. } = &mut **scene;
        world.set_cancel(cancel.cloned());
        pairs.clear();
        for pair in frame.pairs() {
            push(pairs, pair)?;
        }
        let ids = |places: Places| {
            let [a, b] = places.map(|place| frame.bodies.at(place));
            Some([a?.id(), b?.id()])
        };
        let own = |&(places, pair): &(Places, TrianglePair)| {
            Some(SceneHit { bodies: ids(places)?, pair })
        };
        Ok(match verb {
            Verb::All => {
                // Pairs are in the order of bodies, and so of ids.
                let mut listed = Ok(());
                world.all_each(pairs, |places, of_two| {
                    let Some(bodies) = ids(places) else { return };
                    if listed.is_ok() {
                        let found = of_two.iter().map(|&pair| SceneHit { bodies, pair });
                        listed = extend(hits, found);
                    }
                })?;
                listed?;
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
        let is_same = |((_, own), body): (&(BodyId, Option<Stamp>), &Body)| *own == stamp(body);
        if is_there && self.bodies.iter().zip(bodies.iter()).all(is_same) {
            for (body, number) in bodies.iter().zip(0..) {
                if bodies.changed([body.id(); 2]) > at
                    && let AnyPose::F32(pose) = body.pose()
                    && !body.model().is_f64()
                {
                    self.world.set_pose(number, pose)?;
                }
            }
        } else {
            self.gather(bodies, at == 0)?;
        }
        self.at = bodies.time();
        Ok(())
    }

    /// Brings the meshes that are not there, and all bodies anew.
    fn gather(&mut self, bodies: &Bodies, is_lost: bool) -> Result<(), GpuError> {
        let used: HashMap<Stamp, &Model> =
            in_f32(bodies).map(|body| (body.model().stamp(), &**body.model())).collect();
        // Meshes that nothing has any more are kept until they are most of all.
        let in_use: usize = used.values().map(|model| triangles(model)).sum();
        if is_lost || self.triangles > 2 * in_use {
            self.clear();
        }
        for body in in_f32(bodies) {
            let stamp = body.model().stamp();
            if self.meshes.contains_key(&stamp) {
                continue;
            }
            // The mesh that the body had, if no other has it, takes the new shape.
            let before = self.bodies.binary_search_by_key(&body.id(), |(id, _)| *id).ok();
            let before = before
                .and_then(|at| self.bodies[at].1)
                .filter(|old| old.mesh() == stamp.mesh() && !used.contains_key(old));
            let before = before.and_then(|old| Some((old.tree(), self.meshes.remove(&old)?)));
            let number = match before {
                Some((tree, number)) => {
                    // A tree of the CPU that was built anew is better there, too.
                    if tree == stamp.tree() {
                        self.world.set_positions(number, body.model().mesh().shadow())?;
                    } else {
                        self.world.set_mesh(number, body.model().bvh())?;
                    }
                    number
                }
                None => {
                    self.triangles += triangles(body.model());
                    self.world.add_mesh(body.model().bvh())?
                }
            };
            self.meshes.insert(stamp, number);
        }
        self.bodies.clear();
        self.bodies.extend(bodies.iter().map(|body| (body.id(), stamp(body))));
        let posed = bodies.iter().map(|body| match body.pose() {
            AnyPose::F32(pose) if !body.model().is_f64() => {
                (self.meshes[&body.model().stamp()], pose)
            }
            // There is a mesh, since the pairs that are asked about have some.
            _ => (0, Pose::IDENTITY),
        });
        self.world.set_bodies(&posed.collect::<Vec<_>>())
    }

    fn clear(&mut self) {
        self.world.clear();
        self.meshes.clear();
        self.bodies.clear();
        self.triangles = 0;
    }
}

fn triangles(model: &Model) -> usize {
    model.mesh().triangles().len()
}

/// The stamp of the model that the mesh there was brought from, if there is one for this body.
fn stamp(body: &Body) -> Option<Stamp> {
    (!body.is_f64()).then(|| body.model().stamp())
}

/// The bodies that are there as themselves.
fn in_f32(bodies: &Bodies) -> impl Iterator<Item = &Body> {
    bodies.iter().filter(|body| !body.is_f64())
}
