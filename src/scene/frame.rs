//! A frame of a scene, as its executor answers it.

use super::cache::merge;
use super::device::DeviceScene;
use super::hit::SceneHit;
use super::id::BodyId;
use super::pairs::{BodyPairs, TwoBodies};
use crate::executor::{Answer, Backend, CpuHistory, Device, Frame, Named, Verb};
use crate::{Error, TrianglePair};

pub(super) struct SceneFrame<'s> {
    pub(super) pairs: BodyPairs<'s>,
    /// New hits; empty.
    pub(super) hits: &'s mut Vec<SceneHit>,
    pub(super) device: &'s mut DeviceScene,
    /// The part of the CPU that answered about the others beside a GPU.
    pub(super) beside: Option<Backend>,
}

impl Named for SceneHit {
    type Name = [BodyId; 2];

    fn new(bodies: [BodyId; 2], pair: TrianglePair) -> Self {
        Self { bodies, pair }
    }

    fn name(&self) -> [BodyId; 2] {
        self.bodies
    }

    fn pair(&self) -> TrianglePair {
        self.pair
    }
}

impl Frame for SceneFrame<'_> {
    type Hit = SceneHit;

    fn on_cpu(
        &mut self,
        cpu: &mut CpuHistory<[BodyId; 2]>,
        verb: Verb,
    ) -> (Backend, Result<Answer<SceneHit>, Error>) {
        cpu.ask_many(self.pairs.bodies(), TwoBodies::tree, verb, self.hits)
    }

    fn is_for_cpu(&self) -> bool {
        !self.pairs.bodies.are_all_of_gpu() && self.pairs.of_gpu(true).pairs().next().is_none()
    }

    /// A scene stays itself, whichever bodies it has.
    fn meshes(&self) -> [u64; 2] {
        [0; 2]
    }

    fn to_upload(&mut self) -> usize {
        self.device.lacks(self.pairs.bodies)
    }

    /// Pairs that no GPU answers are asked about on the CPU beside, and both lists are merged.
    fn on_gpu(
        &mut self,
        device: &Device,
        cpu: &mut CpuHistory<[BodyId; 2]>,
        verb: Verb,
    ) -> Result<Answer<SceneHit>, Error> {
        if self.pairs.bodies.are_all_of_gpu() {
            return self.device.ask(device, &self.pairs, cpu.cancel(), verb, self.hits);
        }
        let whole = self.pairs;
        let own = self.device.ask(device, &whole.of_gpu(true), cpu.cancel(), verb, self.hits)?;
        if own.first.is_some() && verb == Verb::Any {
            return Ok(own);
        }
        let rest = whole.of_gpu(false);
        if rest.pairs().next().is_none() {
            return Ok(own);
        }
        let found = std::mem::take(self.hits);
        self.pairs = rest;
        let (backend, answer) = self.on_cpu(cpu, verb);
        self.pairs = whole;
        self.beside = Some(backend);
        let answer = answer?;
        Ok(match verb {
            Verb::All => {
                let late = std::mem::replace(self.hits, found);
                merge(self.hits, &late)?;
                Answer::listed(self.hits)
            }
            Verb::Count => Answer::counted(own.count + answer.count),
            Verb::Any => answer,
        })
    }
}
