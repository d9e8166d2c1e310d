//! Submitting a question without waiting, in lists that belong to the question until it is read.

use crate::answer::{Answer, GpuVerb};
use crate::engine::{Engine, Run, Start, Task};
use crate::layout::Counters;
use crate::{Gpu, GpuError, GpuModel, GpuSettings, pair, within};
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Adjacency;
use std::mem::offset_of;
use wgpu::Buffer;

/// One question at a time, about two models or one, that is submitted now and read later, and the lists that it works in.
///
/// A question that is submitted before the last one was read takes its place.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, GpuModel, GpuSubmission, GpuVerb};
/// # fn demo(gpu: Gpu, a: GpuModel, b: GpuModel) -> Result<(), pfront_gpu::GpuError> {
/// let mut question = GpuSubmission::new(&gpu, gpu.settings())?;
/// question.pair(&a, &b, &Pose::IDENTITY, GpuVerb::All)?;
/// // ... submit what else the frame needs ...
/// let mut pairs = Vec::new();
/// let count = question.read(&mut pairs)?;
/// assert_eq!(count, pairs.len() as u64);
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct GpuSubmission {
    answer: Answer,
    /// What has been submitted and not read; `None` where a model is empty.
    run: Option<(Task, Run)>,
    verb: GpuVerb,
}

impl GpuSubmission {
    /// The byte of [`GpuSubmission::count_buffer`] at which the number of hits is, a u32.
    pub const COUNT_OFFSET: u64 = offset_of!(Counters, hits) as u64;
    /// The byte at which a u32 is that is not 0 if a list was full: the answer is then in parts, and the host reads them.
    pub const OVERFLOW_OFFSET: u64 = offset_of!(Counters, overflow) as u64;
    /// The byte at which the number of triangle pairs is that are left to the CPU, a u32. They are not among the hits.
    pub const REST_OFFSET: u64 = offset_of!(Counters, rest) as u64;

    /// Lists for one question.
    ///
    /// # Errors
    /// [`GpuError::Budget`], [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        let answer = Answer::new(Engine::new(gpu, &settings)?);
        Ok(Self { answer, run: None, verb: GpuVerb::All })
    }

    /// Submits a question about two models, the second in the pose `a_from_b`, and does not wait.
    ///
    /// # Errors
    /// As [`crate::GpuPairQuery::all`].
    pub fn pair(
        &mut self,
        a: &GpuModel,
        b: &GpuModel,
        a_from_b: &Pose,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        self.run = None;
        let task = pair::prepare(&mut self.answer.engine, a, b, a_from_b)?;
        self.submit(task, verb)
    }

    /// Submits a question about a model and itself, and does not wait.
    ///
    /// # Errors
    /// As [`crate::GpuSelfQuery::all`].
    pub fn within(
        &mut self,
        model: &GpuModel,
        adjacency: Adjacency,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        self.run = None;
        let task = within::prepare(&mut self.answer.engine, model, adjacency)?;
        self.submit(task, verb)
    }

    /// Waits for the submission, and for no other, and returns how many pairs meet; under [`GpuVerb::Any`], at least one if any
    /// does. `pairs` is replaced: by all pairs, sorted, under [`GpuVerb::All`], by some pair that meets under [`GpuVerb::Any`]. A
    /// question is read once; the answer to none is empty.
    ///
    /// # Errors
    /// As [`crate::GpuPairQuery::all`].
    pub fn read(&mut self, pairs: &mut Vec<TrianglePair>) -> Result<u64, GpuError> {
        match self.run.take() {
            Some((task, run)) => self.answer.finish(&task, run, self.verb)?,
            None => self.answer.clear(),
        }
        std::mem::swap(&mut self.answer.pairs, pairs);
        Ok(self.answer.count)
    }

    /// The hits: `array<vec2<u32>>`, the triangles `(a, b)` of each, under [`GpuVerb::All`] sorted.
    #[must_use]
    pub fn hits_buffer(&self) -> &Buffer {
        &self.answer.engine.lists.hits
    }

    /// The counters: `array<u32>`, of which the constants of this type name three.
    #[must_use]
    pub fn count_buffer(&self) -> &Buffer {
        &self.answer.engine.lists.counters
    }

    fn submit(&mut self, task: Option<Task>, verb: GpuVerb) -> Result<(), GpuError> {
        self.verb = verb;
        if let Some(task) = task {
            self.run = Some((task, self.answer.run(&task, Start::Seeds, verb)?));
        }
        Ok(())
    }
}
