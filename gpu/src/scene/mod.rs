//! Many posed shapes.

mod arena;
mod bodies;
mod broad;
mod edit;
mod pending;
mod shape;

pub use bodies::{Body, BodyId};
pub use pending::PendingScene;
pub use shape::Shape;

use crate::answer::{Answer, Want};
use crate::clock::Clock;
use crate::engine::{Engine, Entry, Run, Task};
use crate::layout::{Placement, Query};
use crate::{Error, Gpu, Report, Settings, Timing};
use arena::Arena;
use bodies::Bodies;
use broad::Broad;
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use wgpu::CommandEncoder;

/// Two triangles of different bodies that meet. The order is that of `bodies`, then `pair`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SceneHit {
    /// The bodies, the one that was added first before the other.
    pub bodies: [BodyId; 2],
    /// A triangle of the first body and one of the second.
    pub pair: TrianglePair,
}

/// Asks which triangles of many bodies meet, each body against each. The answer is the same, to the bit,
/// as that of the CPU: every vertex is posed into the world by [`Pose::apply`], whatever the other body
/// is.
///
/// A body is a [`Shape`] in a pose. Bodies are added, removed, moved and deformed between frames. A frame
/// uploads 48 bytes a body; the device poses all vertices, refits all trees and asks all pairs of
/// bodies whose boxes overlap at once. Where nothing has moved, it only asks.
///
/// A deforming body is not asked whether it meets itself; [`crate::SelfQuery`] does that.
///
/// # Memory
/// On the device, 52 bytes a triangle, 28 a vertex and 41 a node (about 27 a triangle with the default leaf
/// size) for each body, however many share its shape, and the [`crate::Budget`].
///
/// # Complexity
/// A frame takes O(n) on the host for n bodies, and O(vertices + triangles) on the device, before the
/// query itself. After bodies have come or gone, the next frame uploads all of them anew.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, SceneQuery, Shape};
/// use std::sync::Arc;
/// # fn demo(bvh: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::Error> {
/// let mut scene = SceneQuery::new(&Gpu::new()?)?;
/// let tile = Arc::new(Shape::new(bvh));
/// scene.add(tile.clone(), Pose::IDENTITY)?;
/// let above = scene.add(tile, Pose::IDENTITY)?;
/// for frame in 0..4 {
///     scene.set_pose(above, Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]))?;
///     println!("{} pairs", scene.all()?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct SceneQuery {
    answer: Answer,
    bodies: Bodies,
    broad: Broad,
    /// `None` once a body has come or gone.
    arena: Option<Arena>,
    /// Whether the broad phase knows of the last change.
    is_paired: bool,
    /// Whether the device does.
    is_posed: bool,
    hits: Vec<SceneHit>,
    /// Measures the passes that move bodies, if times are wanted.
    clock: Option<Clock>,
}

impl SceneQuery {
    /// A query of no bodies, with the settings that suit the device.
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
        Ok(Self {
            answer: Answer::new(Engine::new(gpu, &settings)?),
            bodies: Bodies::default(),
            broad: Broad::default(),
            arena: None,
            is_paired: false,
            is_posed: false,
            hits: Vec::new(),
            clock: None,
        })
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if all bodies together do not fit in a binding; [`Error::DeviceLost`],
    /// [`Error::Device`], [`Error::OutOfMemory`].
    pub fn all(&mut self) -> Result<&[SceneHit], Error> {
        self.ask(Want::All)?;
        Ok(&self.hits)
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn any(&mut self) -> Result<Option<SceneHit>, Error> {
        self.ask(Want::Any)?;
        Ok(self.hits.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn count(&mut self) -> Result<u64, Error> {
        self.ask(Want::Count)?;
        Ok(self.answer.count)
    }

    /// Records everything that [`SceneQuery::all`] does into an encoder of the caller's, to be submitted
    /// with other work and read later. An encoder whose answer was not read may still be submitted, before
    /// the one that is read.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    ///
    /// # Examples
    /// ```no_run
    /// # use pfront_gpu::{Error, Gpu, SceneQuery};
    /// # fn demo(gpu: Gpu, mut scene: SceneQuery) -> Result<(), Error> {
    /// let mut encoder = gpu.device().create_command_encoder(&Default::default());
    /// let pending = scene.record(&mut encoder)?;
    /// // … record what else the frame needs …
    /// gpu.queue().submit([encoder.finish()]);
    /// let hits = pending.read()?;
    /// # Ok(()) }
    /// ```
    pub fn record<'q>(
        &'q mut self,
        encoder: &mut CommandEncoder,
    ) -> Result<PendingScene<'q>, Error> {
        let gpu = self.answer.engine.gpu.clone();
        let question = gpu.checked(|| self.start(encoder, Want::All))?;
        Ok(PendingScene { scene: self, question })
    }

    /// The same, keeping the device time of moving all bodies and of a run, each as a whole.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn with_time(self) -> Result<Self, Error> {
        self.keep_time(false)
    }

    /// The same, keeping the device time of each pass, which takes some microseconds for each.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn with_timings(self) -> Result<Self, Error> {
        self.keep_time(true)
    }

    /// Times of the last question on the device, with those of moving bodies, if any had moved, before the last run;
    /// empty without [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::Device`].
    pub fn timings(&self) -> Result<Vec<Timing>, Error> {
        let mut timings = Clock::read(self.clock.as_ref(), &self.answer.engine.gpu)?;
        timings.extend(self.answer.engine.timings()?);
        Ok(timings)
    }

    /// Counts and times of the last answer.
    #[must_use]
    pub fn report(&self) -> Report {
        self.answer.report
    }

    /// Bytes of device memory that the bodies hold; 0 before they are first asked about.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.arena.as_ref().map_or(0, Arena::bytes)
    }

    fn keep_time(mut self, each: bool) -> Result<Self, Error> {
        self.answer.engine.keep_time(each)?;
        self.clock = Clock::new(&self.answer.engine.gpu, each)?;
        Ok(self)
    }

    fn ask(&mut self, want: Want) -> Result<(), Error> {
        let gpu = self.answer.engine.gpu.clone();
        let question = gpu.checked(|| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let mut question = self.start(&mut encoder, want)?;
            if let Some(question) = &mut question {
                question.run.submission = Some(gpu.queue().submit([encoder.finish()]));
            }
            Ok(question)
        })?;
        self.finish(question, want)
    }

    /// Records what brings the device up to date and the first run; `None` if no boxes overlap.
    fn start(
        &mut self,
        encoder: &mut CommandEncoder,
        want: Want,
    ) -> Result<Option<Question>, Error> {
        if let Some(clock) = &mut self.clock {
            clock.forget();
        }
        if !self.is_paired {
            self.broad.update(self.bodies.solid().map(|(_, aabb)| aabb))?;
            self.is_paired = true;
        }
        let pairs = self.broad.pairs();
        if pairs.is_empty() {
            return Ok(None);
        }
        let gpu = self.answer.engine.gpu.clone();
        let arena = match &mut self.arena {
            Some(arena) => arena,
            none => none.insert(Arena::new(&gpu, &self.bodies)?),
        };
        if !self.is_posed {
            arena.record_motion(&gpu, encoder, &self.bodies, self.clock.as_mut());
        }
        self.answer.engine.bind(&arena.model, &arena.model)?;
        let (front, levels) = arena.front(&self.bodies, pairs);
        // No body is paired with itself, so that these are two meshes.
        let query = Query {
            sides: [Placement::new(&Pose::IDENTITY); 2],
            leaf_size: arena.model.leaf_size,
            ..Query::zeroed()
        };
        let task = Task { query, root: front[0], levels, levels_below_seeds: levels };
        let (parts, run) = self.answer.record_from(encoder, &task, &front, want)?;
        Ok(Some(Question { task, parts, run }))
    }

    /// Reads the answer.
    fn finish(&mut self, question: Option<Question>, want: Want) -> Result<(), Error> {
        match question {
            Some(Question { task, parts, run }) => {
                self.answer.finish_parts(&task, parts, run, want)?;
                self.is_posed = true;
            }
            None => self.answer.clear(),
        }
        self.hits.clear();
        if let Some(arena) = &self.arena {
            self.hits.extend(self.answer.pairs.iter().map(|&pair| arena.hit(pair)));
        }
        // The pairs are in order, and so are those of two bodies: this merges runs.
        self.hits.sort();
        Ok(())
    }
}

/// A question that has been recorded.
#[derive(Debug)]
struct Question {
    task: Task,
    /// The last of them is what the run is about.
    parts: Vec<Vec<Entry>>,
    run: Run,
}
