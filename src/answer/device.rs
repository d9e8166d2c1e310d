//! Models on a GPU, brought there when it is first asked, and the queries about them.

use super::planned::{Given, Want};
use super::question::OnGpu;
use crate::gpu::{self, Deforming, Error, Gpu, Settings};
use crate::model::Stamp;
use crate::planner::Planner;
use crate::{Adjacency, Model};
use pfront_core::query::TrianglePair;

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
            true => Mirrored::Moving(Box::new(Deforming::new(gpu, model.bvh())?)),
            false => Mirrored::Rigid(gpu::Model::new(gpu, model.bvh())?),
        };
        *own = Some(Self { stamp, model });
        Ok(())
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

    /// How many triangles would have to be uploaded, and the bytes that are held in the end.
    pub(crate) fn owed(&self, on: OnGpu<'_>) -> (usize, u64) {
        let (models, moves) = match on {
            OnGpu::Pair([a, b], _) if a.stamp() == b.stamp() => ([Some(a), None], false),
            OnGpu::Pair([a, b], _) => ([Some(a), Some(b)], false),
            OnGpu::Within(model, _) => ([Some(model), None], true),
        };
        let mut owed = (0, self.settings.budget.bytes);
        for (own, model) in self.models.iter().zip(models) {
            let Some(model) = model else { continue };
            let (vertices, triangles) =
                (model.mesh().positions().len() as u64, model.mesh().triangles().len());
            let has_it = own.as_ref().is_some_and(|own| own.stamp.mesh() == model.stamp().mesh());
            owed.0 += if has_it { 0 } else { triangles };
            // What gpu::Model and gpu::Deforming say that they take.
            owed.1 += 84 * triangles as u64;
            owed.1 += if moves { 12 * vertices + 17 * triangles as u64 } else { 0 };
        }
        owed
    }

    /// Asks; tells how many leaf pairs there were as well.
    pub(crate) fn ask(
        &mut self,
        on: OnGpu<'_>,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<(Given, u32), Error> {
        let Self { gpu, settings, models: [first, second], pair, within } = self;
        match on {
            OnGpu::Pair([a, b], a_from_b) => {
                Mirror::bring(first, gpu, a, false)?;
                let one = a.stamp() == b.stamp();
                if !one {
                    Mirror::bring(second, gpu, b, false)?;
                }
                let query = match pair {
                    Some(query) => query,
                    none => none.insert(gpu::PairQuery::with_settings(gpu, *settings)?),
                };
                let (Some(a), Some(b)) = (&*first, if one { &*first } else { &*second }) else {
                    return Ok((Given::default(), 0));
                };
                let (a, b) = (a.model(), b.model());
                let given = match want {
                    Want::All => {
                        query.all_into(a, b, a_from_b, pairs)?;
                        listed(pairs)
                    }
                    Want::Count => counted(query.count(a, b, a_from_b)?),
                    Want::Any => found(query.any(a, b, a_from_b)?),
                };
                Ok((given, query.report().leaf_pairs))
            }
            OnGpu::Within(model, adjacency) => {
                Mirror::bring(first, gpu, model, true)?;
                let query = match within {
                    Some((own, query)) if *own == adjacency => query,
                    none => {
                        let query = gpu::SelfQuery::with_settings(gpu, *settings)?;
                        &mut none.insert((adjacency, query.with_adjacency(adjacency))).1
                    }
                };
                let Some(model) = first else { return Ok((Given::default(), 0)) };
                let model = model.model();
                let given = match want {
                    Want::All => {
                        query.all_into(model, pairs)?;
                        listed(pairs)
                    }
                    Want::Count => counted(query.count(model)?),
                    Want::Any => found(query.any(model)?),
                };
                Ok((given, query.report().leaf_pairs))
            }
        }
    }
}

fn listed(pairs: &[TrianglePair]) -> Given {
    Given { count: pairs.len() as u64, first: pairs.first().copied() }
}

fn counted(count: u64) -> Given {
    Given { count, first: None }
}

fn found(first: Option<TrianglePair>) -> Given {
    Given { count: u64::from(first.is_some()), first }
}
