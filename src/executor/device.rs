//! A GPU as an executor has it: its lists, shared by all queries or lent to a ticket, and the models that are there.

use super::gathered::Gathered;
use super::measure::Line;
use super::{Answer, Verb};
use crate::gpu::{Gpu, GpuError, GpuModel, GpuPairQuery, GpuSelfQuery, GpuSettings, GpuSubmission};
use crate::{Adjacency, Model, Pose, Stamp, TrianglePair};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

#[derive(Debug)]
pub(crate) struct Device {
    pub(crate) gpu: Gpu,
    pub(crate) settings: GpuSettings,
    /// What it is predicted to take beside a CPU; `None` if it is to answer whatever is asked.
    pub(super) line: Option<Line>,
    pair: Mutex<Option<GpuPairQuery>>,
    within: Mutex<Option<GpuSelfQuery>>,
    /// Lists of tickets, while no ticket has them.
    idle: Mutex<Vec<GpuSubmission>>,
    /// The same for batches of pairs.
    gathered: Mutex<Vec<Gathered>>,
    /// Models that do not move, for as long as some query has them.
    models: Mutex<Vec<(Stamp, Weak<GpuModel>)>>,
}

impl Device {
    pub(super) fn new(gpu: &Gpu, settings: GpuSettings, line: Option<Line>) -> Self {
        Self {
            gpu: gpu.clone(),
            settings,
            line,
            pair: Mutex::default(),
            within: Mutex::default(),
            idle: Mutex::default(),
            gathered: Mutex::default(),
            models: Mutex::default(),
        }
    }

    /// A model there, which is uploaded unless some query has it.
    pub(crate) fn model(&self, model: &Model) -> Result<Arc<GpuModel>, GpuError> {
        let stamp = model.stamp();
        let mut models = lock(&self.models);
        models.retain(|(_, model)| model.strong_count() > 0);
        let known = models.iter().find(|(known, _)| *known == stamp);
        if let Some(model) = known.and_then(|(_, model)| model.upgrade()) {
            return Ok(model);
        }
        let uploaded = Arc::new(GpuModel::new(&self.gpu, model.bvh())?);
        models.push((stamp, Arc::downgrade(&uploaded)));
        Ok(uploaded)
    }

    /// Lists for one more question at a time.
    pub(crate) fn lend(&self) -> Result<GpuSubmission, GpuError> {
        let idle = lock(&self.idle).pop();
        idle.map_or_else(|| GpuSubmission::new(&self.gpu, self.settings), Ok)
    }

    /// Takes lists back.
    pub(crate) fn take_back(&self, lists: impl IntoIterator<Item = GpuSubmission>) {
        lock(&self.idle).extend(lists);
    }

    /// A world for one more batch of pairs.
    pub(crate) fn lend_gathered(&self) -> Result<Gathered, GpuError> {
        let idle = lock(&self.gathered).pop();
        idle.map_or_else(|| Gathered::new(self), Ok)
    }

    /// Takes it back.
    pub(crate) fn take_back_gathered(&self, gathered: Gathered) {
        lock(&self.gathered).push(gathered);
    }

    /// Asks about two models there.
    pub(crate) fn ask_pair(
        &self,
        [a, b]: [&GpuModel; 2],
        a_from_b: &Pose,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, GpuError> {
        let mut query = lock(&self.pair);
        let query = match &mut *query {
            Some(query) => query,
            none => none.insert(GpuPairQuery::with_settings(&self.gpu, self.settings)?),
        };
        Ok(match verb {
            Verb::All => {
                query.all_into(a, b, a_from_b, pairs)?;
                Answer::listed(pairs)
            }
            Verb::Count => Answer::counted(query.count(a, b, a_from_b)?),
            Verb::Any => Answer::found(query.any(a, b, a_from_b)?),
        })
    }

    /// Asks about a model there and itself.
    pub(crate) fn ask_within(
        &self,
        model: &GpuModel,
        adjacency: Adjacency,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, GpuError> {
        let mut within = lock(&self.within);
        let query = match within.take() {
            Some(query) => query,
            None => GpuSelfQuery::with_settings(&self.gpu, self.settings)?,
        };
        let query = within.insert(query.with_adjacency(adjacency));
        Ok(match verb {
            Verb::All => {
                query.all_into(model, pairs)?;
                Answer::listed(pairs)
            }
            Verb::Count => Answer::counted(query.count(model)?),
            Verb::Any => Answer::found(query.any(model)?),
        })
    }
}

/// Nothing is half done under these locks that the next question would not do anew.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
