//! One model with itself.

use crate::answer::{Answer, GpuVerb};
use crate::engine::{Engine, Task};
use crate::layout::{Placement, Query};
use crate::report::reports;
use crate::{Gpu, GpuError, GpuModel, GpuSettings, Pending};
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Adjacency;

/// Asks which triangles of one model meet each other; each unordered pair is reported once, with
/// `a < b`. What two triangles share by index is no contact
/// ([`pfront_core::triangle::intersects_in_mesh`]).
///
/// Keeps its buffers, as [`crate::GpuPairQuery`] does.
///
/// # Examples
/// ```no_run
/// use pfront_gpu::{Gpu, GpuModel, GpuSelfQuery};
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// let gpu = Gpu::new()?;
/// let model = GpuModel::new(&gpu, bvh)?;
/// println!("{} pairs", GpuSelfQuery::new(&gpu)?.all(&model)?.len());
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct GpuSelfQuery {
    answer: Answer,
    adjacency: Adjacency,
}

impl GpuSelfQuery {
    /// A query under the shared-index rule, with the settings that suit the device.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Self::with_settings(gpu, gpu.settings())
    }

    /// A query with other settings.
    ///
    /// # Errors
    /// [`GpuError::Budget`], [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn with_settings(gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
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
    /// [`GpuError::DeviceLost`], [`GpuError::Device`], [`GpuError::OutOfMemory`].
    pub fn all(&mut self, model: &GpuModel) -> Result<&[TrianglePair], GpuError> {
        self.ask(model, GpuVerb::All)?;
        Ok(&self.answer.pairs)
    }

    /// The same into a list of the caller's, whose memory the query takes in exchange.
    ///
    /// # Errors
    /// As [`GpuSelfQuery::all`].
    pub fn all_into(
        &mut self,
        model: &GpuModel,
        out: &mut Vec<TrianglePair>,
    ) -> Result<(), GpuError> {
        self.ask(model, GpuVerb::All)?;
        std::mem::swap(&mut self.answer.pairs, out);
        Ok(())
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`GpuSelfQuery::all`].
    pub fn any(&mut self, model: &GpuModel) -> Result<Option<TrianglePair>, GpuError> {
        self.ask(model, GpuVerb::Any)?;
        Ok(self.answer.pairs.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`GpuSelfQuery::all`].
    pub fn count(&mut self, model: &GpuModel) -> Result<u64, GpuError> {
        self.ask(model, GpuVerb::Count)?;
        Ok(self.answer.count)
    }

    /// Records the query; see [`crate::GpuPairQuery::record`].
    ///
    /// # Errors
    /// As [`GpuSelfQuery::all`].
    pub fn record<'q>(
        &'q mut self,
        encoder: &mut wgpu::CommandEncoder,
        model: &'q GpuModel,
    ) -> Result<Pending<'q>, GpuError> {
        let task = prepare(&mut self.answer.engine, model, self.adjacency)?;
        Pending::record(&mut self.answer, encoder, task)
    }

    fn ask(&mut self, model: &GpuModel, verb: GpuVerb) -> Result<(), GpuError> {
        let task = prepare(&mut self.answer.engine, model, self.adjacency)?;
        self.answer.ask(task, verb)
    }
}

/// Binds the model and says what to ask about it; `None` if it is empty.
pub(crate) fn prepare(
    engine: &mut Engine,
    model: &GpuModel,
    adjacency: Adjacency,
) -> Result<Option<Task>, GpuError> {
    if model.bounds.is_none() {
        return Ok(None);
    }
    engine.bind(model, model)?;
    let query = Query {
        sides: [Placement::new(&Pose::IDENTITY); 2],
        seeds: [model.seed_count; 2],
        within: 1,
        apart: u32::from(adjacency == Adjacency::SkipNeighbours),
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

reports!(GpuSelfQuery);
