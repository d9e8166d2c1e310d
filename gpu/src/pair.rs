//! Two models.

use crate::answer::{Answer, GpuVerb};
use crate::engine::{Engine, Task};
use crate::layout::{Placement, Query, check_pose};
use crate::report::reports;
use crate::{Gpu, GpuError, GpuModel, GpuSettings, Pending};
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;

/// Asks which triangles of two models meet, the second in the pose `a_from_b`. The answer is the same,
/// to the bit, as that of the core.
///
/// Keeps its buffers: make one and use it every frame, for any models.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, GpuModel, GpuPairQuery};
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// let gpu = Gpu::new()?;
/// let model = GpuModel::new(&gpu, bvh)?;
/// let mut query = GpuPairQuery::new(&gpu)?;
/// for frame in 0..4 {
///     let a_from_b = Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]);
///     println!("{} pairs", query.all(&model, &model, &a_from_b)?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct GpuPairQuery {
    answer: Answer,
}

impl GpuPairQuery {
    /// A query with the settings that suit the device.
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
        Ok(Self { answer: Answer::new(Engine::new(gpu, &settings)?) })
    }

    /// All pairs that meet, sorted; `a` and `b` of a pair are triangles of `a` and `b`.
    ///
    /// # Errors
    /// [`GpuError::Pose`] if the pose is not finite or takes `b` out of range; [`GpuError::DeviceLost`],
    /// [`GpuError::Device`], [`GpuError::OutOfMemory`].
    pub fn all(
        &mut self,
        a: &GpuModel,
        b: &GpuModel,
        a_from_b: &Pose,
    ) -> Result<&[TrianglePair], GpuError> {
        self.ask(a, b, a_from_b, GpuVerb::All)?;
        Ok(&self.answer.pairs)
    }

    /// The same into a list of the caller's, whose memory the query takes in exchange.
    ///
    /// # Errors
    /// As [`GpuPairQuery::all`].
    pub fn all_into(
        &mut self,
        a: &GpuModel,
        b: &GpuModel,
        a_from_b: &Pose,
        out: &mut Vec<TrianglePair>,
    ) -> Result<(), GpuError> {
        self.ask(a, b, a_from_b, GpuVerb::All)?;
        std::mem::swap(&mut self.answer.pairs, out);
        Ok(())
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`GpuPairQuery::all`].
    pub fn any(
        &mut self,
        a: &GpuModel,
        b: &GpuModel,
        a_from_b: &Pose,
    ) -> Result<Option<TrianglePair>, GpuError> {
        self.ask(a, b, a_from_b, GpuVerb::Any)?;
        Ok(self.answer.pairs.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`GpuPairQuery::all`].
    pub fn count(&mut self, a: &GpuModel, b: &GpuModel, a_from_b: &Pose) -> Result<u64, GpuError> {
        self.ask(a, b, a_from_b, GpuVerb::Count)?;
        Ok(self.answer.count)
    }

    /// Records the query into an encoder of the caller's, to be submitted with other work and read later.
    /// The models stay borrowed until then, since a full list makes the query go on from them. An
    /// encoder whose answer was not read may still be submitted, before the one that is read.
    ///
    /// # Errors
    /// As [`GpuPairQuery::all`].
    ///
    /// # Examples
    /// ```no_run
    /// # use pfront_core::Pose;
    /// # use pfront_gpu::*;
    /// # fn demo(gpu: Gpu, a: GpuModel, b: GpuModel, mut query: GpuPairQuery) -> Result<(), GpuError> {
    /// let mut encoder = gpu.device().create_command_encoder(&Default::default());
    /// let pending = query.record(&mut encoder, &a, &b, &Pose::IDENTITY)?;
    /// // … record what else the frame needs …
    /// gpu.queue().submit([encoder.finish()]);
    /// let pairs = pending.read()?;
    /// # Ok(()) }
    /// ```
    pub fn record<'q>(
        &'q mut self,
        encoder: &mut wgpu::CommandEncoder,
        a: &'q GpuModel,
        b: &'q GpuModel,
        a_from_b: &Pose,
    ) -> Result<Pending<'q>, GpuError> {
        let task = prepare(&mut self.answer.engine, a, b, a_from_b)?;
        Pending::record(&mut self.answer, encoder, task)
    }

    fn ask(
        &mut self,
        a: &GpuModel,
        b: &GpuModel,
        a_from_b: &Pose,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        let task = prepare(&mut self.answer.engine, a, b, a_from_b)?;
        self.answer.ask(task, verb)
    }
}

/// Binds the models and says what to ask about them; `None` if one is empty.
pub(crate) fn prepare(
    engine: &mut Engine,
    a: &GpuModel,
    b: &GpuModel,
    a_from_b: &Pose,
) -> Result<Option<Task>, GpuError> {
    let (Some(_), Some(bounds)) = (a.bounds, b.bounds) else { return Ok(None) };
    let posed = *a_from_b != Pose::IDENTITY;
    if posed {
        check_pose(a_from_b, &bounds)?;
    }
    engine.bind(a, b)?;
    let query = Query {
        sides: [Placement::new(&Pose::IDENTITY), Placement::new(a_from_b)],
        posed: [0, u32::from(posed)],
        seeds: [a.seed_count, b.seed_count],
        leaf_size: a.leaf_size,
        ..Query::zeroed()
    };
    Ok(Some(Task {
        query,
        root: [a.root, b.root],
        levels: a.depth.max(b.depth),
        levels_below_seeds: a.depth_below_seeds.max(b.depth_below_seeds),
    }))
}

reports!(GpuPairQuery);
