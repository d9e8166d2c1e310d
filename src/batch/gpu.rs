//! Answering a batch on a GPU, which submits without waiting, and a thread that reads.

use super::found::Found;
use super::outcome::Outcome;
use super::{Job, Question};
use crate::executor::{Device, Verb, read};
use crate::gpu::{GpuError, GpuModel, GpuQuery, GpuQuestion, wgpu};
use crate::{AnyPose, Error, Model, Pose, Stamp, TrianglePair};
use std::collections::VecDeque;
use std::collections::hash_map::{Entry, HashMap};
use std::io;
use std::sync::{Arc, PoisonError};
#[cfg(not(target_arch = "wasm32"))]
use std::thread;

/// Whether a thread can wait for a GPU.
pub(super) const CAN_WAIT: bool = cfg!(not(target_arch = "wasm32"));

/// Questions of one ticket that are submitted at a time, so that the device works on one while another is read.
const RING: usize = 2;

/// Models on the device, by what they hold.
pub(super) type Uploads = Arc<HashMap<Stamp, Arc<GpuModel>>>;

/// Submits a batch, and returns the buffers of hits and counters of a single question. `uploads` are the models that the last
/// submission needed, and become those that this one needs.
pub(super) fn submit(
    device: &Arc<Device>,
    job: Job,
    uploads: &mut Uploads,
) -> Result<(Arc<Outcome>, Option<[wgpu::Buffer; 2]>), Error> {
    let pairs: Option<Vec<_>> = job.questions.iter().map(Question::pair).collect();
    if let Some(pairs) = pairs.filter(|pairs| pairs.len() > 1) {
        return Ok((gathered(device, &job, &pairs)?, None));
    }
    *uploads = Arc::new(upload(device, &job, uploads)?);
    let lists = Lists { device: device.clone(), own: VecDeque::new() };
    let mut ring = Ring { lists, uploads: uploads.clone(), found: Found::default(), job };
    let (outcome, count) = (Arc::<Outcome>::default(), ring.job.questions.len());
    if count == 0 {
        outcome.set(Ok(ring.found));
        return Ok((outcome, None));
    }
    // Its place in the queue is before whatever the caller submits next.
    ring.submit(0)?;
    let only = ring.lists.own.front().filter(|_| count == 1);
    let buffers = only.map(|lists| [lists.hits_buffer(), lists.count_buffer()].map(Clone::clone));
    let own = outcome.clone();
    let work = move || {
        own.guard(|| {
            if let Some(found) = ring.answer(&own)? {
                own.set(Ok(found));
            }
            Ok(())
        });
    };
    spawn(work).map_err(|error| GpuError::Device { reason: error.to_string() })?;
    Ok((outcome, buffers))
}

/// Submits pairs of models as one.
fn gathered(
    device: &Arc<Device>,
    job: &Job,
    pairs: &[([&Model; 2], Pose)],
) -> Result<Arc<Outcome>, Error> {
    let (mut world, device) = (device.lend_gathered()?, device.clone());
    let (outcome, verb, count) = (Arc::<Outcome>::default(), job.verb, pairs.len());
    world.submit(pairs, verb)?;
    let own = outcome.clone();
    let work = move || {
        own.guard(|| {
            let mut found = Found::default();
            world.read(count, verb, &mut found.answers, &mut found.pairs)?;
            device.take_back_gathered(world);
            own.set(Ok(found));
            Ok(())
        });
    };
    spawn(work).map_err(|error| GpuError::Device { reason: error.to_string() })?;
    Ok(outcome)
}

/// Starts the thread that reads.
#[cfg(not(target_arch = "wasm32"))]
fn spawn(work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    thread::Builder::new().name("pfront ticket".to_owned()).spawn(work).map(drop)
}

/// There are no threads.
#[cfg(target_arch = "wasm32")]
fn spawn(_: impl FnOnce()) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Brings each model of a batch there once.
fn upload(
    device: &Device,
    job: &Job,
    before: &Uploads,
) -> Result<HashMap<Stamp, Arc<GpuModel>>, GpuError> {
    let mut uploads = HashMap::new();
    let mut bring = |model: &Model| -> Result<(), GpuError> {
        if let Entry::Vacant(entry) = uploads.entry(model.stamp()) {
            let known = before.get(entry.key()).filter(|model| model.is_on(&device.gpu)).cloned();
            entry.insert(known.map_or_else(|| device.model(model), Ok)?);
        }
        Ok(())
    };
    for question in job.questions.iter() {
        match question {
            Question::Pair { models, .. } => models.iter().try_for_each(|model| bring(model))?,
            Question::Within { model, .. } => bring(model)?,
        }
    }
    Ok(uploads)
}

/// The lists of a ticket, the oldest submission first. They go back to the device when they are dropped.
#[derive(Debug)]
pub(super) struct Lists {
    device: Arc<Device>,
    own: VecDeque<GpuQuery>,
}

impl Drop for Lists {
    fn drop(&mut self) {
        self.device.take_back(self.own.drain(..));
    }
}

/// Questions that are submitted one after the other into the same few lists: one alone, or models with themselves.
struct Ring {
    job: Job,
    uploads: Uploads,
    lists: Lists,
    found: Found,
}

impl Ring {
    /// Reads what has been submitted and submits what is left, until all is answered; `None` if it is cancelled before.
    fn answer(mut self, outcome: &Outcome) -> Result<Option<Found>, Error> {
        for next in 1..self.job.questions.len() {
            if outcome.is_over() {
                return Ok(None);
            }
            self.submit(next)?;
        }
        for _ in 0..self.lists.own.len() {
            let read = self.read()?;
            self.lists.own.extend(read);
        }
        *outcome.lists.lock().unwrap_or_else(PoisonError::into_inner) = Some(self.lists);
        Ok(Some(self.found))
    }

    /// Submits a question into new lists, or into those of the oldest submission, which is read before.
    fn submit(&mut self, number: usize) -> Result<(), Error> {
        let oldest = if self.lists.own.len() < RING { None } else { self.read()? };
        let mut lists = oldest.map_or_else(|| self.lists.device.lend(), Ok)?;
        let there = |model: &Model| self.uploads.get(&model.stamp()).ok_or(GpuError::OtherDevice);
        let question = match &self.job.questions[number] {
            Question::Pair { models: [a, b], a_from_b: AnyPose::F32(a_from_b) } => {
                GpuQuestion::pair(there(a)?, there(b)?, a_from_b)
            }
            Question::Pair { .. } => return Err(Error::InF64),
            Question::Within { model, adjacency } => {
                GpuQuestion::Within { model: there(model)?, adjacency: *adjacency }
            }
        };
        lists.submit(&question, self.job.verb.into())?;
        self.lists.own.push_back(lists);
        Ok(())
    }

    /// Reads the oldest submission, and returns its lists. After an error nobody uses them again.
    fn read(&mut self) -> Result<Option<GpuQuery>, Error> {
        let Some(mut lists) = self.lists.own.pop_front() else { return Ok(None) };
        let mut pairs: Vec<TrianglePair> = Vec::new();
        self.found.answers.push(read(&mut lists, self.job.verb, &mut pairs)?);
        if self.job.verb == Verb::All {
            self.found.pairs.append(&mut pairs);
        }
        Ok(Some(lists))
    }
}
