//! Many pairs of models in one submission to a GPU, which has each model once and two bodies for each pair.

use super::{Answer, Device, Verb};
use crate::gpu::{GpuError, GpuVerb, World};
use crate::{Model, Pose, Stamp, TrianglePair};
use std::collections::{HashMap, HashSet};

/// A world that questions are gathered in, and the meshes there by the models that they were brought from.
#[derive(Debug)]
pub(crate) struct Gathered {
    world: World,
    meshes: HashMap<Stamp, u32>,
    /// Triangles of the meshes there.
    triangles: usize,
}

impl Gathered {
    pub(super) fn new(device: &Device) -> Result<Self, GpuError> {
        let world = World::new(&device.gpu, device.settings)?;
        Ok(Self { world, meshes: HashMap::new(), triangles: 0 })
    }

    /// Submits a question about each of these pairs of models and poses `a_from_b`, and does not wait.
    pub(crate) fn submit<'m>(
        &mut self,
        pairs: impl Iterator<Item = ([&'m Model; 2], Pose)> + Clone,
        verb: Verb,
    ) -> Result<(), GpuError> {
        let mut seen = HashSet::new();
        let models = pairs.clone().flat_map(|(models, _)| models);
        let used: Vec<_> = models.filter(|model| seen.insert(model.stamp())).collect();
        let count = |model: &&Model| model.mesh().triangles().len();
        // Meshes that nothing asks about any more are kept until they are most of all.
        if self.triangles > 2 * used.iter().map(count).sum::<usize>() {
            self.world.clear();
            self.meshes.clear();
            self.triangles = 0;
        }
        for model in used {
            if !self.meshes.contains_key(&model.stamp()) {
                self.meshes.insert(model.stamp(), self.world.add_mesh(model.bvh())?);
                self.triangles += count(&model);
            }
        }
        let mut bodies = Vec::new();
        for ([a, b], a_from_b) in pairs {
            bodies.push((self.meshes[&a.stamp()], Pose::IDENTITY));
            bodies.push((self.meshes[&b.stamp()], a_from_b));
        }
        self.world.set_bodies(&bodies)?;
        let of_two: Vec<_> = (0..bodies.len() as u32 / 2).map(|i| [2 * i, 2 * i + 1]).collect();
        let verb = match verb {
            Verb::All => GpuVerb::All,
            Verb::Count => GpuVerb::CountEach,
            Verb::Any => GpuVerb::AnyEach,
        };
        self.world.submit(&of_two, verb)
    }

    /// Waits for the questions, and adds their answers in order; to `pairs` those of all questions, under [`Verb::All`].
    pub(crate) fn read(
        &mut self,
        count: usize,
        verb: Verb,
        answers: &mut Vec<Answer<TrianglePair>>,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<(), GpuError> {
        let found = self.world.read()?;
        match verb {
            Verb::Any => answers.extend(found.each.iter().map(|&first| Answer::found(first))),
            Verb::Count => answers.extend(found.counts.iter().map(|&own| Answer::counted(own))),
            Verb::All => {
                let mut rest = &found.hits[..];
                for number in 0..count as u32 {
                    let end = rest.partition_point(|([body, _], _)| *body <= 2 * number);
                    let (own, others) = rest.split_at(end);
                    let first = pairs.len();
                    pairs.extend(own.iter().map(|(_, pair)| pair));
                    answers.push(Answer::listed(&pairs[first..]));
                    rest = others;
                }
            }
        }
        Ok(())
    }
}
