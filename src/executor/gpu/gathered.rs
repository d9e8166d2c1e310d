//! Many pairs of models in one submission to a GPU, which has each model once and a body for each pair.

use crate::executor::{Answer, Verb};
use crate::gpu::{Gpu, GpuError, GpuSettings, GpuVerb, World};
use crate::memory::reserve;
use crate::{Error, Model, Pose, Stamp, TrianglePair};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A world that questions are gathered in, and the meshes there by the models that they were brought from.
#[derive(Debug)]
pub(crate) struct Gathered {
    world: World,
    meshes: HashMap<Stamp, u32>,
    /// Triangles of the meshes there.
    triangles: usize,
    /// The number of the first body that stands for a question.
    firsts: u32,
}

impl Gathered {
    pub(super) fn new(gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        let world = World::new(gpu, settings)?;
        Ok(Self { world, meshes: HashMap::new(), triangles: 0, firsts: 0 })
    }

    /// Submits a question about each of these pairs of models and poses `a_from_b`, and does not wait. They are a part of a batch whose models
    /// have so many triangles in all.
    pub(crate) fn submit(
        &mut self,
        pairs: &[([&Model; 2], Pose)],
        in_batch: usize,
        verb: Verb,
    ) -> Result<(), GpuError> {
        // Neighbours are mostly about the same models, which need no look-up.
        let is_new = |(i, side): &(usize, usize)| {
            *i == 0 || pairs[*i].0[*side].stamp() != pairs[*i - 1].0[*side].stamp()
        };
        let places = (0..pairs.len()).flat_map(|i| [(i, 0), (i, 1)]).filter(is_new);
        let used: HashMap<Stamp, &Model> =
            places.map(|(i, side)| pairs[i].0[side]).map(|model| (model.stamp(), model)).collect();
        let count = |model: &&Model| model.mesh().triangles().len();
        // Meshes that nothing asks about any more are kept until they are most of all.
        if self.triangles > 2 * in_batch {
            self.world.clear();
            self.meshes.clear();
            self.triangles = 0;
        }
        for (stamp, model) in &used {
            if !self.meshes.contains_key(stamp) {
                self.meshes.insert(*stamp, self.world.add_mesh(model.bvh())?);
                self.triangles += count(model);
            }
        }
        // A body for each model as the first of two, by the number of its mesh, and one for each question.
        self.firsts = self.meshes.len() as u32;
        let mut bodies: Vec<_> = (0..self.firsts).map(|mesh| (mesh, Pose::IDENTITY)).collect();
        let (mut of_two, mut last) = (Vec::with_capacity(pairs.len()), [0; 2]);
        for (i, ([a, b], a_from_b)) in pairs.iter().enumerate() {
            for (side, model) in [a, b].into_iter().enumerate() {
                if is_new(&(i, side)) {
                    last[side] = self.meshes[&model.stamp()];
                }
            }
            of_two.push([last[0], bodies.len() as u32]);
            bodies.push((last[1], *a_from_b));
        }
        self.world.set_bodies(&bodies)?;
        let verb = match verb {
            Verb::All => GpuVerb::All,
            Verb::Count => GpuVerb::CountEach,
            Verb::Any => GpuVerb::AnyEach,
        };
        self.world.submit(&of_two, verb)
    }

    /// Has questions end early once a flag is set.
    pub(crate) fn set_cancel(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.world.set_cancel(flag);
    }

    /// Waits for the questions, and adds their answers in order; to `pairs` those of all questions, under [`Verb::All`].
    pub(crate) fn read(
        &mut self,
        count: usize,
        verb: Verb,
        answers: &mut Vec<Answer<TrianglePair>>,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<(), Error> {
        let found = self.world.read()?;
        reserve(answers, count)?;
        match verb {
            Verb::Any => answers.extend(found.each.iter().map(|&first| Answer::found(first))),
            Verb::Count => answers.extend(found.counts.iter().map(|&own| Answer::counted(own))),
            Verb::All => {
                // In order of the first bodies, and so not of questions; those of one question are together and in order.
                reserve(pairs, found.hits.len())?;
                let mut lists = vec![0..0; count];
                let mut from = 0;
                for own in found.hits.chunk_by(|x, y| x.0 == y.0) {
                    let [_, body] = own[0].0;
                    lists[(body - self.firsts) as usize] = from..from + own.len();
                    from += own.len();
                }
                for list in lists {
                    let first = pairs.len();
                    pairs.extend(found.hits[list].iter().map(|(_, pair)| pair));
                    answers.push(Answer::listed(&pairs[first..]));
                }
            }
        }
        Ok(())
    }
}
