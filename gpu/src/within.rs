//! One model with itself.

use crate::answer::{Answer, Verb};
use crate::engine::{Engine, Task};
use crate::layout::{Placement, Query};
use crate::report::reports;
use crate::{Error, Gpu, Model, Pending, Settings};
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Adjacency;

/// Asks which triangles of one model meet each other; each unordered pair is reported once, with
/// `a < b`. What two triangles share by index is no contact
/// ([`pfront_core::triangle::intersects_in_mesh`]).
///
/// Keeps its buffers, as [`crate::PairQuery`] does.
///
/// # Examples
/// ```no_run
/// use pfront_gpu::{Gpu, Model, SelfQuery};
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::Error> {
/// let gpu = Gpu::new()?;
/// let model = Model::new(&gpu, bvh)?;
/// println!("{} pairs", SelfQuery::new(&gpu)?.all(&model)?.len());
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct SelfQuery {
    answer: Answer,
    adjacency: Adjacency,
}

impl SelfQuery {
    /// A query under the shared-index rule, with the settings that suit the device.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(gpu: &Gpu) -> Result<Self, Error> {
        Self::with_settings(gpu, gpu.settings())
    }

    /// A query with other settings.
    ///
    /// # Errors
    /// [`Error::Budget`], [`Error::TooLarge`], [`Error::OutOfMemory`].
    pub fn with_settings(gpu: &Gpu, settings: Settings) -> Result<Self, Error> {
        let answer = Answer::new(Engine::new(gpu, &settings)?);
        Ok(Self { answer, adjacency: Adjacency::default() })
    }

    /// The same with another rule for triangles that share a vertex.
    #[must_use]
    pub fn with_adjacency(self, adjacency: Adjacency) -> Self {
        Self { adjacency, ..self }
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::Device`], [`Error::OutOfMemory`].
    pub fn all(&mut self, model: &Model) -> Result<&[TrianglePair], Error> {
        self.ask(model, Verb::All)?;
        Ok(&self.answer.pairs)
    }

    /// The same into a list of the caller's, whose memory the query takes in exchange.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn all_into(&mut self, model: &Model, out: &mut Vec<TrianglePair>) -> Result<(), Error> {
        self.ask(model, Verb::All)?;
        std::mem::swap(&mut self.answer.pairs, out);
        Ok(())
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn any(&mut self, model: &Model) -> Result<Option<TrianglePair>, Error> {
        self.ask(model, Verb::Any)?;
        Ok(self.answer.pairs.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn count(&mut self, model: &Model) -> Result<u64, Error> {
        self.ask(model, Verb::Count)?;
        Ok(self.answer.count)
    }

    /// Records the query; see [`crate::PairQuery::record`].
    ///
    /// # Errors
    /// As [`SelfQuery::all`].
    pub fn record<'q>(
        &'q mut self,
        encoder: &mut wgpu::CommandEncoder,
        model: &'q Model,
    ) -> Result<Pending<'q>, Error> {
        let task = self.prepare(model)?;
        Pending::record(&mut self.answer, encoder, task)
    }

    fn ask(&mut self, model: &Model, verb: Verb) -> Result<(), Error> {
        let task = self.prepare(model)?;
        self.answer.ask(task, verb)
    }

    /// Binds the model and says what to ask about it; `None` if it is empty.
    fn prepare(&mut self, model: &Model) -> Result<Option<Task>, Error> {
        if model.bounds.is_none() {
            return Ok(None);
        }
        self.answer.engine.bind(model, model)?;
        let query = Query {
            sides: [Placement::new(&Pose::IDENTITY); 2],
            seeds: [model.seed_count; 2],
            within: 1,
            apart: u32::from(self.adjacency == Adjacency::SkipNeighbours),
            leaf_size: model.leaf_size,
            ..Query::zeroed()
        };
        Ok(Some(Task {
            query,
            root: [model.root; 2],
            levels: model.depth,
            levels_below_seeds: model.depth_below_seeds,
        }))
    }
}

reports!(SelfQuery);
