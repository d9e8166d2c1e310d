//! Many posed shapes.

mod arena;
mod bodies;
mod broad;
mod shape;

pub use bodies::{Body, BodyId};
pub use shape::Shape;

use crate::answer::{Answer, Report, Want};
use crate::clock::Clock;
use crate::engine::{Engine, Task};
use crate::layout::{Placement, Query};
use crate::{Error, Gpu, Settings, Timing};
use arena::Arena;
use bodies::Bodies;
use broad::Broad;
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_core::query::TrianglePair;
use std::sync::Arc;

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
/// A body is a [`Shape`] in a pose. Bodies are added, removed and moved between frames. A frame uploads
/// 48 bytes a body; the device poses all vertices, refits all trees and asks all pairs of bodies
/// whose boxes overlap at once. Where nothing has moved, it only asks.
///
/// # Memory
/// On the device, 52 bytes a triangle, 28 a vertex and 37 a node (about 25 a triangle with the default leaf
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
    /// If times are wanted.
    clock: Option<Clock>,
    /// Whether the last question had bodies to move.
    has_moved: bool,
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
            has_moved: false,
        })
    }

    /// Adds a body in the pose `world_from_body`. Many bodies may share one shape. On error nothing has
    /// changed.
    ///
    /// # Errors
    /// [`Error::Pose`] if the pose is not finite or takes the shape out of range.
    pub fn add(
        &mut self,
        shape: impl Into<Arc<Shape>>,
        world_from_body: Pose,
    ) -> Result<BodyId, Error> {
        let id = self.bodies.add(shape.into(), world_from_body)?;
        self.come_or_gone();
        Ok(id)
    }

    /// Takes a body out and returns it.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    ///
    /// # Complexity
    /// O(n) for n bodies.
    pub fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        let body = self.bodies.remove(id)?;
        self.come_or_gone();
        Ok(body)
    }

    /// Moves a body to the pose `world_from_body`. On error nothing has changed.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there, [`Error::Pose`] as for [`SceneQuery::add`].
    ///
    /// # Complexity
    /// O(log n) for n bodies.
    pub fn set_pose(&mut self, id: BodyId, world_from_body: Pose) -> Result<(), Error> {
        let body = self.bodies.get_mut(id)?;
        if body.pose() != world_from_body {
            body.set_pose(world_from_body)?;
            (self.is_paired, self.is_posed) = (false, false);
        }
        Ok(())
    }

    /// A body.
    ///
    /// # Errors
    /// [`Error::StaleBody`] if it is not there.
    pub fn body(&self, id: BodyId) -> Result<&Body, Error> {
        self.bodies.get(id)
    }

    /// The bodies in the order in which they were added.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter()
    }

    /// How many bodies there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bodies.iter().len()
    }

    /// Whether there is no body.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All pairs that meet, sorted.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if all bodies together do not fit in a binding; [`Error::DeviceLost`],
    /// [`Error::Device`], [`Error::OutOfMemory`].
    pub fn all(&mut self) -> Result<&[SceneHit], Error> {
        self.ask(Want::All)?;
        self.hits.clear();
        if let Some(arena) = &self.arena {
            self.hits.extend(self.answer.pairs.iter().map(|&pair| arena.hit(pair)));
        }
        self.hits.sort_unstable();
        Ok(&self.hits)
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn any(&mut self) -> Result<Option<SceneHit>, Error> {
        self.ask(Want::Any)?;
        let first = self.answer.pairs.first();
        Ok(self.arena.as_ref().zip(first).map(|(arena, &pair)| arena.hit(pair)))
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`SceneQuery::all`].
    pub fn count(&mut self) -> Result<u64, Error> {
        self.ask(Want::Count)?;
        Ok(self.answer.count)
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

    /// What the last question took on the device, moving bodies, if any had moved, before the last run;
    /// empty without [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::Device`].
    pub fn timings(&self) -> Result<Vec<Timing>, Error> {
        let mut timings = match &self.clock {
            Some(clock) if self.has_moved => clock.read(&self.answer.engine.gpu)?,
            _ => Vec::new(),
        };
        timings.extend(self.answer.engine.timings()?);
        Ok(timings)
    }

    /// What the last answer took.
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

    fn come_or_gone(&mut self) {
        self.arena = None;
        (self.is_paired, self.is_posed) = (false, false);
    }

    fn ask(&mut self, want: Want) -> Result<(), Error> {
        self.has_moved = false;
        if !self.is_paired {
            self.broad.update(self.bodies.solid().map(|(_, aabb)| aabb))?;
            self.is_paired = true;
        }
        let pairs = self.broad.pairs();
        if pairs.is_empty() {
            self.answer.clear();
            return Ok(());
        }
        let gpu = self.answer.engine.gpu.clone();
        let arena = match &mut self.arena {
            Some(arena) => arena,
            none => none.insert(Arena::new(&gpu, &self.bodies)?),
        };
        let (front, levels) = arena.front(pairs);
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        if !self.is_posed {
            arena.record_motion(&gpu, &mut encoder, &self.bodies, self.clock.as_mut());
            self.has_moved = true;
        }
        self.answer.engine.bind(&arena.model, &arena.model)?;
        let query = Query {
            // No body is paired with itself, so that these are two meshes.
            sides: [Placement::new(&Pose::IDENTITY); 2],
            leaf_size: arena.model.leaf_size,
            ..Query::zeroed()
        };
        let task = Task { query, root: front[0], levels, levels_below_seeds: levels };
        self.answer.ask_from(encoder, &task, &front, want)?;
        self.is_posed = true;
        Ok(())
    }
}
