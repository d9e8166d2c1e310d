//! Models on a GPU, brought there when it is first asked, and the queries about them.

use super::question::OnGpu;
use super::ways::{Given, Want};
use crate::gpu::{self, Deforming, Error, Gpu, Settings};
use crate::model::Stamp;
use crate::planner::{Owed, Planner};
use crate::{Adjacency, Model};
use pfront_core::bvtt::TrianglePair;

#[derive(Debug)]
pub(crate) struct Device {
    gpu: Gpu,
    settings: Settings,
    models: [Option<Mirror>; 2],
    pair: Option<gpu::PairQuery>,
    within: Option<(Adjacency, gpu::SelfQuery)>,
}

/// A clone has to bring its models there by itself.
impl Clone for Device {
    fn clone(&self) -> Self {
        Self::empty(self.gpu.clone(), self.settings)
    }
}

/// A model as it was brought there.
#[derive(Debug)]
struct Mirror {
    stamp: Stamp,
    model: Mirrored,
}

#[derive(Debug)]
enum Mirrored {
    Rigid(gpu::Model),
    Moving(Box<Deforming>),
}

impl Mirror {
    fn model(&self) -> &gpu::Model {
        match &self.model {
            Mirrored::Rigid(model) => model,
            Mirrored::Moving(model) => model,
        }
    }

    /// Makes it that of a model: uploads it, or its positions if it is the same mesh that has moved.
    fn bring(own: &mut Option<Self>, gpu: &Gpu, model: &Model, moves: bool) -> Result<(), Error> {
        let stamp = model.stamp();
        let same_mesh = own.as_ref().is_some_and(|own| own.stamp.mesh() == stamp.mesh());
        match own {
            Some(own) if own.stamp == stamp => return Ok(()),
            Some(Self { stamp: own, model: Mirrored::Moving(moving) })
                if same_mesh && own.tree() == stamp.tree() =>
            {
                moving.set_positions(model.mesh().positions())?;
                *own = stamp;
                return Ok(());
            }
            _ => {}
        }
        let model = match moves || same_mesh {
            true => Mirrored::Moving(Box::new(Self::moving(gpu, model)?)),
            false => Mirrored::Rigid(gpu::Model::new(gpu, model.bvh())?),
        };
        *own = Some(Self { stamp, model });
        Ok(())
    }

    /// A mesh whose boxes the GPU fits to its positions, if the CPU has not.
    fn moving(gpu: &Gpu, model: &Model) -> Result<Deforming, Error> {
        match model.map_unfitted(|bvh| Deforming::new(gpu, bvh)) {
            Some(moving) => {
                let mut moving = moving?;
                moving.set_positions(model.mesh().positions())?;
                Ok(moving)
            }
            None => Deforming::new(gpu, model.bvh()),
        }
    }
}

impl Device {
    /// The planner's, if it knows what to expect of it.
    pub(crate) fn new(planner: &Planner) -> Option<Self> {
        let (gpu, settings) = planner.device()?;
        Some(Self::empty(gpu, settings))
    }

    fn empty(gpu: Gpu, settings: Settings) -> Self {
        Self { gpu, settings, models: [None, None], pair: None, within: None }
    }

    /// What it lacks.
    pub(crate) fn owed(&self, on: OnGpu<'_>) -> Owed {
        let (models, moves) = match on {
            OnGpu::Pair([a, b], _) if a.stamp() == b.stamp() => ([Some(a), None], false),
            OnGpu::Pair([a, b], _) => ([Some(a), Some(b)], false),
            OnGpu::Within(model, _) => ([Some(model), None], true),
        };
        let compile = moves && !self.gpu.is_warm();
        let mut owed = Owed { triangles: 0, bytes: self.settings.budget.bytes, compile };
        for (own, model) in self.models.iter().zip(models) {
            let Some(model) = model else { continue };
            let (vertices, triangles) =
                (model.mesh().positions().len() as u64, model.mesh().triangles().len());
            let has_it = own.as_ref().is_some_and(|own| own.stamp.mesh() == model.stamp().mesh());
            owed.triangles += if has_it { 0 } else { triangles };
            // What gpu::Model and gpu::Deforming say that they take.
            owed.bytes += 84 * triangles as u64;
            owed.bytes += if moves { 12 * vertices + 17 * triangles as u64 } else { 0 };
        }
        owed
    }

    /// What it takes to move vertices there and refit in each frame, in nanoseconds.
    pub(crate) fn upkeep(&self, on: OnGpu<'_>, planner: &Planner) -> f64 {
        let OnGpu::Within(model, _) = on else { return 0.0 };
        let question = planner.machine().device.as_ref().map_or(0.0, |device| device.question);
        // As found on an H200, where a question takes 130 us: a pass for each level, and all boxes.
        1.2 * question + 10.0 * model.mesh().triangles().len() as f64
    }

    /// Asks; tells how many leaf pairs there were as well.
    pub(crate) fn ask(
        &mut self,
        on: OnGpu<'_>,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<(Given, u32), Error> {
        self.bring(on)?;
        match on {
            OnGpu::Pair(_, a_from_b) => {
                let (Some(query), Some([a, b])) = (&mut self.pair, both(&self.models)) else {
                    return Ok(Default::default());
                };
                let given = match want {
                    Want::All => {
                        query.all_into(a, b, a_from_b, pairs)?;
                        Given::listed(pairs)
                    }
                    Want::Count => Given::counted(query.count(a, b, a_from_b)?),
                    Want::Any => Given::found(query.any(a, b, a_from_b)?),
                };
                Ok((given, query.report().leaf_pairs))
            }
            OnGpu::Within(..) => {
                let (Some((_, query)), Some([model, _])) = (&mut self.within, both(&self.models))
                else {
                    return Ok(Default::default());
                };
                let given = match want {
                    Want::All => {
                        query.all_into(model, pairs)?;
                        Given::listed(pairs)
                    }
                    Want::Count => Given::counted(query.count(model)?),
                    Want::Any => Given::found(query.any(model)?),
                };
                Ok((given, query.report().leaf_pairs))
            }
        }
    }

    /// Brings there what is asked about, and makes the query.
    fn bring(&mut self, on: OnGpu<'_>) -> Result<(), Error> {
        let Self { gpu, settings, models: [first, second], pair, within } = self;
        match on {
            OnGpu::Pair([a, b], _) => {
                Mirror::bring(first, gpu, a, false)?;
                if a.stamp() == b.stamp() {
                    *second = None;
                } else {
                    Mirror::bring(second, gpu, b, false)?;
                }
                if pair.is_none() {
                    *pair = Some(gpu::PairQuery::with_settings(gpu, *settings)?);
                }
            }
            OnGpu::Within(model, adjacency) => {
                Mirror::bring(first, gpu, model, true)?;
                if within.as_ref().is_none_or(|(own, _)| *own != adjacency) {
                    let query = gpu::SelfQuery::with_settings(gpu, *settings)?;
                    *within = Some((adjacency, query.with_adjacency(adjacency)));
                }
            }
        }
        Ok(())
    }
}

/// The models there, of which the second may be the first.
fn both([first, second]: &[Option<Mirror>; 2]) -> Option<[&gpu::Model; 2]> {
    let first = first.as_ref()?.model();
    Some([first, second.as_ref().map_or(first, Mirror::model)])
}
