//! A GPU as an executor has it: its lists, lent to a question until it is read, and the models that are there.

use super::gathered::Gathered;
use super::measure::Line;
use super::meshes::DeviceMeshes;
use super::{Answer, Verb};
use crate::gpu::{Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuSettings, GpuVerb};
use crate::{Model, TrianglePair};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

#[derive(Debug)]
pub(crate) struct Device {
    pub(crate) gpu: Gpu,
    pub(crate) settings: GpuSettings,
    /// The times that it is predicted to take beside a CPU; `None` if it is to answer all questions.
    pub(super) line: Option<Line>,
    /// Lists, while no question has them.
    idle: Mutex<Vec<GpuQuery>>,
    /// Worlds of batches of pairs, while no batch has them.
    gathered: Mutex<Vec<Gathered>>,
    /// Meshes that do not move.
    meshes: Mutex<DeviceMeshes>,
}

impl Device {
    pub(super) fn new(gpu: &Gpu, settings: GpuSettings, line: Option<Line>) -> Self {
        Self {
            gpu: gpu.clone(),
            settings,
            line,
            idle: Mutex::default(),
            gathered: Mutex::default(),
            meshes: Mutex::default(),
        }
    }

    /// A model there, which is uploaded unless it is there already.
    pub(crate) fn model(&self, model: &Model) -> Result<Arc<GpuModel>, GpuError> {
        let mut meshes = lock(&self.meshes);
        meshes.trim(self.settings.mesh_bytes);
        meshes.get(&self.gpu, model)
    }

    /// Lists for one more question at a time.
    pub(crate) fn lend(&self) -> Result<GpuQuery, GpuError> {
        let idle = lock(&self.idle).pop();
        idle.map_or_else(|| GpuQuery::with_settings(&self.gpu, self.settings), Ok)
    }

    /// Takes lists back.
    pub(crate) fn take_back(&self, lists: impl IntoIterator<Item = GpuQuery>) {
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

    /// Asks and waits; `pairs` is replaced, by the list under [`Verb::All`]. Of shadows, `meets` decides what is left open.
    pub(crate) fn ask(
        &self,
        question: &GpuQuestion<'_>,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
        meets: impl Fn(TrianglePair) -> bool,
    ) -> Result<Answer<TrianglePair>, GpuError> {
        let mut query = self.lend()?;
        query.submit(question, verb.into())?;
        let answer = read(&mut query, verb, pairs)?;
        let mut open = query.open().iter().copied().filter(|&pair| meets(pair));
        let answer = match verb {
            Verb::All => {
                let mut late: Vec<_> = open.collect();
                if !late.is_empty() {
                    late.sort_unstable();
                    pairs.append(&mut late);
                    // Two sorted runs, which this sort merges.
                    pairs.sort();
                }
                Answer::listed(pairs)
            }
            Verb::Count => Answer::counted(answer.count + open.count() as u64),
            Verb::Any => Answer::found(answer.first.or_else(|| open.next())),
        };
        self.take_back([query]);
        Ok(answer)
    }
}

/// Waits for what has been submitted, and reads it; `pairs` is replaced, by the list under [`Verb::All`].
pub(crate) fn read(
    query: &mut GpuQuery,
    verb: Verb,
    pairs: &mut Vec<TrianglePair>,
) -> Result<Answer<TrianglePair>, GpuError> {
    let count = query.read(pairs)?;
    Ok(match verb {
        Verb::All => Answer::listed(pairs),
        Verb::Count => Answer::counted(count),
        Verb::Any => Answer::found(pairs.first().copied()),
    })
}

impl From<Verb> for GpuVerb {
    fn from(verb: Verb) -> Self {
        match verb {
            Verb::All => Self::All,
            Verb::Count => Self::Count,
            Verb::Any => Self::Any,
        }
    }
}

/// Nothing is half done under these locks that the next question would not do anew.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
