//! One question at a time about two models, or one: asked and waited for, or submitted now and read later.

use crate::check::{check_pose, check_shadows};
use crate::engine::Engine;
use crate::layout::{Counters, LARGEST_DISTANCE, Placement, Query};
use crate::report::reports;
use crate::runner::{Asked, Runner};
use crate::task::{GpuVerb, Task};
use crate::{Gpu, GpuError, GpuModel, GpuSettings};
use bytemuck::Zeroable;
use pfront_core::bvtt::{Shadows, TrianglePair};
use pfront_core::triangle::Adjacency;
use pfront_core::{Distance, Pose};
use std::mem::offset_of;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use wgpu::{Buffer, CommandEncoder};

/// The subject of a question.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{GpuModel, GpuQuestion};
/// # fn demo(a: GpuModel, b: GpuModel) {
/// let gap = GpuQuestion::pair(&a, &b, &Pose::from_translation([0.0, 0.0, 0.3]));
/// let folds = GpuQuestion::itself(&a);
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum GpuQuestion<'m> {
    /// Two models, the second posed into the frame of the first. Triangle `a` of a pair is one of `models[0]`.
    Pair {
        /// The models.
        models: [&'m GpuModel; 2],
        /// The pose of the second.
        a_from_b: Pose,
        /// See [`GpuQuestion::within`].
        within: Distance,
    },
    /// Two models, one of which or whose pose is in f64. See [`GpuQuestion::shadows`].
    Shadows {
        /// The models.
        models: [&'m GpuModel; 2],
        /// How their shadows are posed.
        shadows: Shadows,
        /// See [`GpuQuestion::within`].
        within: Distance,
    },
    /// A model and itself. Each unordered pair is reported once, with `a < b`; what two triangles share by index is no
    /// contact ([`pfront_core::triangle::intersects_in_mesh`]).
    Itself {
        /// The model.
        model: &'m GpuModel,
        /// The rule for triangles that share a vertex.
        adjacency: Adjacency,
    },
}

impl<'m> GpuQuestion<'m> {
    /// Two models, the second in the pose `a_from_b`.
    #[must_use]
    pub fn pair(a: &'m GpuModel, b: &'m GpuModel, a_from_b: &Pose) -> Self {
        Self::Pair { models: [a, b], a_from_b: *a_from_b, within: Distance::default() }
    }

    /// Two models, one of which or whose pose is in f64, by [`PairBvtt::shadows`](pfront_core::bvtt::PairBvtt::shadows) of their
    /// query.
    ///
    /// The device does not have their positions. The answer is what it knows by the shadows alone; triangle pairs that it
    /// leaves open are not part of it, nor of any count, but in [`GpuQuery::open`], for
    /// [`PairBvtt::intersects`](pfront_core::bvtt::PairBvtt::intersects) to decide. Shadows that no query can have made of
    /// these models, since a number is NaN or beyond f32, are [`GpuError::Shadows`]; those of other models would be taken for
    /// theirs.
    #[must_use]
    pub fn shadows(a: &'m GpuModel, b: &'m GpuModel, shadows: &Shadows) -> Self {
        Self::Shadows { models: [a, b], shadows: *shadows, within: Distance::default() }
    }

    /// Asks for the triangle pairs of two models that are at most so far apart, in place of those that meet.
    ///
    /// The answer is what f32 certifies. Pairs that it leaves open are not part of it, nor of any count, but in
    /// [`GpuQuery::open`], for [`PairBvtt::intersects`](pfront_core::bvtt::PairBvtt::intersects) of the same question to decide.
    /// Distances beyond a quarter of the range of f32 are [`GpuError::Distance`], and so are any of a model and itself but 0.
    ///
    /// # Examples
    /// ```no_run
    /// # use pfront_core::{Distance, Pose, bvtt::PairBvtt};
    /// # use pfront_gpu::*;
    /// # fn demo(tree: PairBvtt, a: GpuModel, b: GpuModel, mut query: GpuQuery) -> Result<(), Box<dyn std::error::Error>> {
    /// let distance = Distance::new(0.02)?;
    /// let question = GpuQuestion::pair(&a, &b, &Pose::IDENTITY).within(distance)?;
    /// let mut pairs = query.all(&question)?.to_vec();
    /// let tree = tree.within(distance);
    /// pairs.extend(query.open().iter().filter(|pair| tree.intersects(**pair)));
    /// # Ok(()) }
    /// ```
    ///
    /// # Errors
    /// [`GpuError::Distance`]. The query refuses a second model with coordinates beyond 2¹²⁵, as one that is posed.
    pub fn within(mut self, distance: Distance) -> Result<Self, GpuError> {
        match &mut self {
            Self::Pair { within, .. } | Self::Shadows { within, .. }
                if distance.get() <= LARGEST_DISTANCE =>
            {
                *within = distance;
                Ok(self)
            }
            Self::Itself { .. } if distance == Distance::default() => Ok(self),
            _ => Err(GpuError::Distance { distance: distance.get() }),
        }
    }

    /// A model and itself, under the shared-index rule.
    #[must_use]
    pub fn itself(model: &'m GpuModel) -> Self {
        Self::Itself { model, adjacency: Adjacency::default() }
    }

    /// Binds the models; `None` if one is empty.
    fn task(&self, engine: &mut Engine) -> Result<Option<Task>, GpuError> {
        let ([a, b], query) = match *self {
            Self::Pair { models: [a, b], a_from_b, within } => {
                let (Some(_), Some(bounds)) = (a.bounds, b.bounds) else { return Ok(None) };
                if a.is_shadow || b.is_shadow {
                    return Err(GpuError::InF64);
                }
                let moves = a_from_b != Pose::IDENTITY;
                if moves || within > Distance::default() {
                    check_pose(&a_from_b, &bounds)?;
                }
                let sides = [Pose::IDENTITY, a_from_b].each_ref().map(Placement::new);
                let posed = [0, u32::from(moves)];
                ([a, b], near(Query { sides, posed, ..Query::zeroed() }, within, engine)?)
            }
            Self::Shadows { models: [a, b], shadows, within } => {
                let (Some(of_a), Some(of_b)) = (a.bounds, b.bounds) else { return Ok(None) };
                check_shadows(&shadows, [&of_a, &of_b])?;
                engine.ready_to_certify()?;
                let Shadows { poses, padding, error } = shadows;
                let sides = [0, 1].map(|k| Placement::of_shadow(&poses[k], padding[k]));
                let own = Query { sides, posed: [1; 2], error, certify: 1, ..Query::zeroed() };
                ([a, b], near(own, within, engine)?)
            }
            Self::Itself { model, adjacency } => {
                if model.bounds.is_none() {
                    return Ok(None);
                }
                if model.is_shadow {
                    return Err(GpuError::InF64);
                }
                let sides = [Placement::new(&Pose::IDENTITY); 2];
                let apart = u32::from(adjacency == Adjacency::SkipNeighbours);
                ([model; 2], Query { sides, within: 1, apart, ..Query::zeroed() })
            }
        };
        engine.bind(a, b)?;
        let seeds = [a.seed_count, b.seed_count];
        Ok(Some(Task {
            query: Query { seeds, leaf_size: a.leaf_size, ..query },
            root: [a.root, b.root],
            levels: a.depth.max(b.depth),
            levels_below_seeds: a.depth_below_seeds.max(b.depth_below_seeds),
        }))
    }
}

/// A question about pairs within a distance: boxes of the second side, which is posed, grow by it.
fn near(query: Query, within: Distance, engine: &mut Engine) -> Result<Query, GpuError> {
    if within == Distance::default() {
        return Ok(query);
    }
    engine.ready_to_certify()?;
    let (mut query, distance) = (query, within.get());
    query.sides[1].grow(distance);
    Ok(Query { posed: [query.posed[0], 1], distance, certify: 1, ..query })
}

/// Asks which triangles of two models meet, or of one with itself. The answer is the same, to the bit, as that of the core.
///
/// Owns the lists that a question needs: make one and use it every frame, for any models. [`GpuQuery::all`],
/// [`GpuQuery::any`] and [`GpuQuery::count`] wait for their answers; [`GpuQuery::submit`] and [`GpuQuery::record`] do not, and
/// [`GpuQuery::read`] brings the answer later. A question that is asked before the last one was read takes its place.
///
/// While it waits, it records the commands of the next question, which serve if that has the same verb and models, in any
/// pose or shape. Models must not move between a question and its answer: where a list is full, the query goes on from them.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, GpuModel, GpuQuery, GpuQuestion, GpuVerb};
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// let gpu = Gpu::new()?;
/// let model = GpuModel::new(&gpu, bvh)?;
/// let mut query = GpuQuery::new(&gpu)?;
/// println!("{} pairs within", query.count(&GpuQuestion::itself(&model))?);
/// let mut pairs = Vec::new();
/// for frame in 0..4 {
///     let a_from_b = Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]);
///     query.submit(&GpuQuestion::pair(&model, &model, &a_from_b), GpuVerb::All)?;
///     // ... submit what else the frame needs ...
///     query.read(&mut pairs)?;
///     println!("{} pairs", pairs.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct GpuQuery {
    runner: Runner,
    /// The question that has not been read; `None` if there is none, or a model is empty.
    asked: Option<Asked>,
    verb: GpuVerb,
}

impl GpuQuery {
    /// The byte of [`GpuQuery::count_buffer`] at which the number of hits is, a u32.
    pub const COUNT_OFFSET: u64 = offset_of!(Counters, last_hits) as u64;
    /// The byte at which a u32 is that is not 0 if a list was full: the answer is then in parts, and the host reads them.
    pub const OVERFLOW_OFFSET: u64 = offset_of!(Counters, last_overflow) as u64;
    /// The byte at which the number of triangle pairs is that are left to the CPU, a u32. They are not among the hits.
    pub const REST_OFFSET: u64 = offset_of!(Counters, last_rest) as u64;

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
        let runner = Runner::new(Engine::new(gpu, &settings)?);
        Ok(Self { runner, asked: None, verb: GpuVerb::All })
    }

    /// All pairs that meet, sorted, in the memory that the device has written where it can be: that stays mapped until the next question.
    /// Verbs that wait are there natively; on the web [`GpuQuery::read`] does.
    ///
    /// # Errors
    /// [`GpuError::Pose`] if the pose is not finite or takes its model out of range; [`GpuError::Coordinate`]; [`GpuError::InF64`],
    /// [`GpuError::Shadows`]; [`GpuError::OtherDevice`];
    /// [`GpuError::DeviceLost`], [`GpuError::Device`], [`GpuError::OutOfMemory`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn all(&mut self, question: &GpuQuestion<'_>) -> Result<&[TrianglePair], GpuError> {
        self.ask(question, GpuVerb::All)?;
        Ok(self.runner.pairs())
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`GpuQuery::all`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn any(&mut self, question: &GpuQuestion<'_>) -> Result<Option<TrianglePair>, GpuError> {
        self.ask(question, GpuVerb::Any)?;
        Ok(self.runner.pairs().first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`GpuQuery::all`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn count(&mut self, question: &GpuQuestion<'_>) -> Result<u64, GpuError> {
        self.ask(question, GpuVerb::Count)?;
        Ok(self.runner.count)
    }

    /// Submits a question and does not wait. Verbs for each pair of bodies are those for one.
    ///
    /// # Errors
    /// As [`GpuQuery::all`].
    pub fn submit(&mut self, question: &GpuQuestion<'_>, verb: GpuVerb) -> Result<(), GpuError> {
        let gpu = self.runner.engine.gpu.clone();
        gpu.checked(|| {
            if let Some(task) = self.next(question, verb)? {
                self.asked = Some(self.runner.submit(task, self.verb)?);
            }
            Ok(())
        })
    }

    /// Records a question into an encoder of the caller's, to be submitted with other work. An encoder whose answer was not
    /// read may still be submitted, before the one that is read, and not while [`GpuQuery::all`] shows its list.
    ///
    /// # Errors
    /// As [`GpuQuery::all`].
    ///
    /// # Examples
    /// ```no_run
    /// # use pfront_gpu::*;
    /// # fn demo(gpu: Gpu, question: GpuQuestion, mut query: GpuQuery) -> Result<(), GpuError> {
    /// let mut encoder = gpu.device().create_command_encoder(&Default::default());
    /// query.record(&mut encoder, &question, GpuVerb::All)?;
    /// // ... record what else the frame needs ...
    /// gpu.queue().submit([encoder.finish()]);
    /// let mut pairs = Vec::new();
    /// query.read(&mut pairs)?;
    /// # Ok(()) }
    /// ```
    pub fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        question: &GpuQuestion<'_>,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        let gpu = self.runner.engine.gpu.clone();
        gpu.checked(|| {
            if let Some(task) = self.next(question, verb)? {
                self.asked = Some(self.runner.begin(encoder, task, self.verb)?);
            }
            Ok(())
        })
    }

    /// Whether [`GpuQuery::read`] would not wait, but for what the budget makes necessary in addition. Does not wait. A recorded
    /// question must have been submitted.
    ///
    /// # Errors
    /// [`GpuError::Device`], [`GpuError::DeviceLost`].
    pub fn is_ready(&mut self) -> Result<bool, GpuError> {
        match &self.asked {
            Some(asked) => self.runner.engine.read_back.is_done(&asked.run),
            None => Ok(true),
        }
    }

    /// Waits for the submission, and for no other, and returns how many pairs meet; under [`GpuVerb::Any`], at least one if
    /// any does. `pairs` is replaced: by all pairs, sorted, under [`GpuVerb::All`], by some pair that meets under
    /// [`GpuVerb::Any`]. A question is read once; the answer to none is empty. On the web this is an `async fn`.
    ///
    /// # Errors
    /// [`GpuError::NotSubmitted`] if a recorded question was not submitted; as [`GpuQuery::all`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read(&mut self, pairs: &mut Vec<TrianglePair>) -> Result<u64, GpuError> {
        pollster::block_on(self.finish())?;
        self.runner.take_pairs(pairs)?;
        Ok(self.runner.count)
    }

    /// Awaits the answer, and else as natively.
    ///
    /// # Errors
    /// As natively.
    #[cfg(target_arch = "wasm32")]
    pub async fn read(&mut self, pairs: &mut Vec<TrianglePair>) -> Result<u64, GpuError> {
        self.finish().await?;
        self.runner.take_pairs(pairs)?;
        Ok(self.runner.count)
    }

    /// Has questions end early: once the flag is set, reading one waits for nothing, submits nothing more, and returns
    /// [`GpuError::Cancelled`]. Work that has been submitted goes on.
    pub fn set_cancel(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.runner.engine.cancel = flag;
    }

    /// The triangle pairs that the device left open in the last answer, if that was about shadows or pairs within a distance: see
    /// [`GpuQuestion::shadows`] and [`GpuQuestion::within`].
    /// They are for the caller to decide, unless the question was whether any pair meets, and one does.
    #[must_use]
    pub fn open(&self) -> &[TrianglePair] {
        &self.runner.open
    }

    /// The hits: `array<vec2<u32>>`, the triangles `(a, b)` of each. Under [`GpuVerb::All`] they are sorted, unless they are far
    /// more than in the last answers, or very uneven: [`GpuQuery::read`] sorts then what it brings.
    #[must_use]
    pub fn hits_buffer(&self) -> &Buffer {
        self.runner.engine.lists.results(self.verb)
    }

    /// The counters: `array<u32>`, of which the constants of this type name three.
    #[must_use]
    pub fn count_buffer(&self) -> &Buffer {
        &self.runner.engine.lists.counters
    }

    /// Forgets the last question, and binds the models of the next; `None` if one is empty.
    fn next(
        &mut self,
        question: &GpuQuestion<'_>,
        verb: GpuVerb,
    ) -> Result<Option<Task>, GpuError> {
        self.asked = None;
        self.verb = match verb {
            GpuVerb::AnyEach => GpuVerb::Any,
            GpuVerb::CountEach => GpuVerb::Count,
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => verb,
        };
        question.task(&mut self.runner.engine)
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn ask(&mut self, question: &GpuQuestion<'_>, verb: GpuVerb) -> Result<(), GpuError> {
        self.submit(question, verb)?;
        pollster::block_on(self.finish())
    }

    async fn finish(&mut self) -> Result<(), GpuError> {
        match self.asked.take() {
            Some(asked) => self.runner.finish(asked, self.verb).await,
            None => {
                self.runner.clear();
                Ok(())
            }
        }
    }
}

reports!(GpuQuery);
