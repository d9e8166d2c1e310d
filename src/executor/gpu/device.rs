//! A GPU as an executor has it: its lists, lent to a question until it is read, and the models that are there.

use super::gathered::Gathered;
use super::hidden::Hidden;
use super::meshes::DeviceMeshes;
use crate::executor::choice::Line;
use crate::executor::{Answer, Verb};
use crate::gpu::{Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuSettings, GpuVerb};
use crate::memory::push;
use crate::{Error, Model, TrianglePair};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Parts of tickets that are submitted at a time, each into lists of its own: the device works on one while another is read.
pub(crate) const IN_FLIGHT: usize = 2;

#[derive(Debug)]
pub(crate) struct Device {
    pub(crate) gpu: Hidden<Gpu>,
    pub(crate) settings: GpuSettings,
    line: Option<Line>,
    /// Lists, while no question has them.
    idle: Hidden<Mutex<Vec<GpuQuery>>>,
    /// Worlds of batches of pairs, while no batch has them.
    gathered: Hidden<Mutex<Vec<Gathered>>>,
    /// Meshes that do not move.
    meshes: Hidden<Mutex<DeviceMeshes>>,
    /// Parts of tickets that are submitted and not read yet.
    in_flight: AtomicUsize,
    /// Tickets that show their buffers.
    shown: AtomicUsize,
}

impl Device {
    pub(super) fn new(gpu: &Gpu, settings: GpuSettings, line: Option<Line>) -> Self {
        Self {
            gpu: Hidden::new(gpu.clone()),
            settings,
            line,
            idle: Hidden::new(Mutex::default()),
            gathered: Hidden::new(Mutex::default()),
            meshes: Hidden::new(Mutex::default()),
            in_flight: AtomicUsize::new(0),
            shown: AtomicUsize::new(0),
        }
    }

    /// The times that it is predicted to take beside a CPU; `None` if it is to answer all questions.
    pub(crate) fn choice_line(&self) -> Option<&Line> {
        self.line.as_ref()
    }

    /// Whether the device is lost after this error, if it is one of the device.
    pub(crate) fn is_lost_by(&self, error: &Error) -> Option<bool> {
        let Error::Gpu(error) = error else { return None };
        Some(matches!(error, GpuError::DeviceLost { .. }) || self.gpu.is_lost())
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

    /// Room for one more part of a ticket, if there is any.
    pub(crate) fn slot(self: &Arc<Self>) -> Option<Slot> {
        take_one(&self.in_flight, IN_FLIGHT).then(|| Slot(self.clone()))
    }

    /// The same in any case, for the ticket whose turn it is.
    pub(crate) fn slot_at_once(self: &Arc<Self>) -> Slot {
        self.in_flight.fetch_add(1, Relaxed);
        Slot(self.clone())
    }

    /// Whether one more ticket may show its buffers; if so, until [`Device::hide`].
    pub(crate) fn show(&self) -> bool {
        take_one(&self.shown, IN_FLIGHT)
    }

    pub(crate) fn hide(&self) {
        self.shown.fetch_sub(1, Relaxed);
    }

    /// A world for one more batch of pairs.
    pub(crate) fn lend_gathered(&self) -> Result<Gathered, GpuError> {
        let idle = lock(&self.gathered).pop();
        idle.map_or_else(|| Gathered::new(&self.gpu, self.settings), Ok)
    }

    /// Takes it back.
    pub(crate) fn take_back_gathered(&self, gathered: Gathered) {
        lock(&self.gathered).push(gathered);
    }

    /// Asks and waits; `pairs` is replaced, by the list under [`Verb::All`]. Open pairs are decided by `intersects`.
    pub(crate) fn ask(
        &self,
        question: &GpuQuestion<'_>,
        cancel: Option<&Arc<AtomicBool>>,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
        intersects: impl Fn(TrianglePair) -> bool,
    ) -> Result<Answer<TrianglePair>, Error> {
        let mut query = self.lend()?;
        query.set_cancel(cancel.cloned());
        let ask = || {
            query.submit(question, verb.into())?;
            let answer = read(&mut query, verb, pairs)?;
            match query.open() {
                [] => Ok(answer),
                _ => merge_open(&query, verb, answer, pairs, intersects),
            }
        };
        let answer = ask();
        // After another error nothing is known of the lists.
        if matches!(answer, Ok(_) | Err(Error::Cancelled)) {
            query.set_cancel(None);
            self.take_back([query]);
        }
        answer
    }
}

/// Room for a part of a ticket, until it is dropped.
#[derive(Debug)]
pub(crate) struct Slot(Arc<Device>);

impl Drop for Slot {
    fn drop(&mut self) {
        self.0.in_flight.fetch_sub(1, Relaxed);
    }
}

/// Adds one, unless there are so many.
fn take_one(taken: &AtomicUsize, most: usize) -> bool {
    taken.fetch_update(Relaxed, Relaxed, |taken| (taken < most).then_some(taken + 1)).is_ok()
}

/// Adds the pairs that `intersects` finds among those that the device has left open to an answer, and to `pairs`
/// under [`Verb::All`].
pub(crate) fn merge_open(
    query: &GpuQuery,
    verb: Verb,
    answer: Answer<TrianglePair>,
    pairs: &mut Vec<TrianglePair>,
    intersects: impl Fn(TrianglePair) -> bool,
) -> Result<Answer<TrianglePair>, Error> {
    let mut open = query.open().iter().copied().filter(|&pair| intersects(pair));
    Ok(match verb {
        Verb::All => {
            let listed = pairs.len();
            for pair in open {
                push(pairs, pair)?;
            }
            pairs[listed..].sort_unstable();
            // Two sorted runs, which this sort merges.
            pairs.sort();
            Answer::listed(pairs)
        }
        Verb::Count => Answer::counted(answer.count + open.count() as u64),
        Verb::Any => Answer::found(answer.first.or_else(|| open.next())),
    })
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
