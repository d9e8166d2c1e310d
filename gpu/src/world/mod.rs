//! Many posed bodies.

mod arena;

use crate::answer::{Answer, Verb};
use crate::clock::Clock;
use crate::engine::{Engine, Entry, Run, Task};
use crate::layout::{Placement, Query};
use crate::{Gpu, GpuError, GpuReport, GpuSettings, Timing};
use arena::Arena;
use bytemuck::Zeroable;
use pfront_core::bvtt::{PosedBvh, TrianglePair};
use pfront_core::{Bvh, Mesh, MeshError, Pose};
use wgpu::CommandEncoder;

/// Two different bodies by their numbers.
pub type Bodies = [u32; 2];

/// Many bodies, of which pairs are asked whether they meet in the world. The answer is the same, to the bit, as that of the
/// CPU: every vertex is posed into the world by [`Pose::apply`], whatever the other body is.
///
/// The caller finds the pairs of bodies that may meet, by a broad phase over their boxes. A frame uploads 48 bytes
/// a body; the device poses all vertices, refits all trees and asks all pairs at once. Where nothing has moved, it only
/// asks.
///
/// # Memory
/// On the device, 52 bytes a triangle, 28 a vertex and 41 a node (about 27 a triangle with the default leaf
/// size) for each body, and the [`crate::Budget`].
///
/// # Complexity
/// A frame takes O(n + pairs) on the host for n bodies, and O(vertices + triangles) on the device, before the
/// query itself.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, World};
/// # fn demo(tile: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// let gpu = Gpu::new()?;
/// let mut world = World::new(&gpu, gpu.settings())?;
/// world.set_bodies(&[tile; 2])?;
/// for frame in 0..4 {
///     world.set_pose(1, tile, Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]))?;
///     println!("{} pairs", world.all(&[[0, 1]])?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct World {
    answer: Answer,
    arena: Option<Arena>,
    poses: Vec<Pose>,
    /// Whether the device knows of the last change.
    is_posed: bool,
    hits: Vec<(Bodies, TrianglePair)>,
    /// Measures the passes that move bodies, if times are wanted.
    clock: Option<Clock>,
}

impl World {
    /// A world of no bodies.
    ///
    /// # Errors
    /// [`GpuError::Budget`], [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        Ok(Self {
            answer: Answer::new(Engine::new(gpu, &settings)?),
            arena: None,
            poses: Vec::new(),
            is_posed: false,
            hits: Vec::new(),
            clock: None,
        })
    }

    /// Replaces all bodies, by their BVHs; each is at [`Pose::IDENTITY`]. After an error there is none.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if all bodies together do not fit in a binding; [`GpuError::OutOfMemory`].
    ///
    /// # Complexity
    /// O(triangles).
    pub fn set_bodies(&mut self, bodies: &[Bvh<'_>]) -> Result<(), GpuError> {
        // The memory of the last ones is free before that of the next is taken.
        self.arena = None;
        self.is_posed = false;
        self.poses.clear();
        if bodies.iter().any(|bvh| !bvh.order().is_empty()) {
            self.arena = Some(Arena::new(&self.answer.engine.gpu, bodies)?);
        }
        self.poses.resize(bodies.len(), Pose::IDENTITY);
        Ok(())
    }

    /// Moves a body, whose present shape is that of `bvh`, to the pose `world_from_body`.
    ///
    /// # Errors
    /// [`GpuError::NoBody`]; [`GpuError::Pose`] if the pose is not finite or takes the body out of range.
    pub fn set_pose(
        &mut self,
        body: u32,
        bvh: Bvh<'_>,
        world_from_body: Pose,
    ) -> Result<(), GpuError> {
        let bodies = self.poses.len() as u32;
        let pose = self.poses.get_mut(body as usize).ok_or(GpuError::NoBody { body, bodies })?;
        if *pose != world_from_body {
            PosedBvh::new(bvh, &world_from_body)?;
            *pose = world_from_body;
            self.is_posed = false;
        }
        Ok(())
    }

    /// Moves the vertices of a body, given in its own frame. Its pose has to be one that does not take them out of range.
    ///
    /// # Errors
    /// [`GpuError::NoBody`]; [`GpuError::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices) on the host; the device refits all trees anyway.
    pub fn set_positions(&mut self, body: u32, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        let bodies = self.poses.len() as u32;
        if body >= bodies {
            return Err(GpuError::NoBody { body, bodies });
        }
        Mesh::new(positions, &[])?;
        if let Some(arena) = &self.arena {
            let (expected, found) = (arena.vertices(body as usize), positions.len());
            if expected != found {
                return Err(MeshError::VertexCount { expected, found }.into());
            }
            arena.write_positions(&self.answer.engine.gpu, body as usize, positions);
        }
        self.is_posed = false;
        Ok(())
    }

    /// All pairs of triangles of these pairs of bodies that meet, sorted; the first triangle is one of the first body.
    ///
    /// # Errors
    /// [`GpuError::NoBody`]; [`GpuError::DeviceLost`], [`GpuError::Device`], [`GpuError::OutOfMemory`].
    pub fn all(&mut self, pairs: &[Bodies]) -> Result<&[(Bodies, TrianglePair)], GpuError> {
        self.ask(pairs, Verb::All)?;
        Ok(&self.hits)
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn any(&mut self, pairs: &[Bodies]) -> Result<Option<(Bodies, TrianglePair)>, GpuError> {
        self.ask(pairs, Verb::Any)?;
        Ok(self.hits.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn count(&mut self, pairs: &[Bodies]) -> Result<u64, GpuError> {
        self.ask(pairs, Verb::Count)?;
        Ok(self.answer.count)
    }

    /// The same, keeping the device time of moving all bodies and of a run, each as a whole.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn with_time(self) -> Result<Self, GpuError> {
        self.keep_time(false)
    }

    /// The same, keeping the device time of each pass, which takes some microseconds for each.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn with_timings(self) -> Result<Self, GpuError> {
        self.keep_time(true)
    }

    /// Times of the last question on the device, with those of moving bodies, if any had moved, before the last run;
    /// empty without [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::Device`].
    pub fn timings(&self) -> Result<Vec<Timing>, GpuError> {
        let mut timings = Clock::read(self.clock.as_ref(), &self.answer.engine.gpu)?;
        timings.extend(self.answer.engine.timings()?);
        Ok(timings)
    }

    /// Counts and times of the last answer.
    #[must_use]
    pub fn report(&self) -> GpuReport {
        self.answer.report
    }

    /// Bytes of device memory that the bodies hold.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.arena.as_ref().map_or(0, Arena::bytes)
    }

    fn keep_time(mut self, each: bool) -> Result<Self, GpuError> {
        self.answer.engine.keep_time(each)?;
        self.clock = Clock::new(&self.answer.engine.gpu, each)?;
        Ok(self)
    }

    fn ask(&mut self, pairs: &[Bodies], verb: Verb) -> Result<(), GpuError> {
        let bodies = self.poses.len() as u32;
        if let Some(&body) = pairs.iter().flatten().find(|&&body| body >= bodies) {
            return Err(GpuError::NoBody { body, bodies });
        }
        let gpu = self.answer.engine.gpu.clone();
        let question = gpu.checked(|| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let mut question = self.start(&mut encoder, pairs, verb)?;
            if let Some(question) = &mut question {
                question.run.submission = Some(gpu.queue().submit([encoder.finish()]));
            }
            Ok(question)
        })?;
        match question {
            Some(Question { task, parts, run }) => {
                self.answer.finish_parts(&task, parts, run, verb)?;
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

    /// Records what brings the device up to date and the first run; `None` if there is nothing to ask.
    fn start(
        &mut self,
        encoder: &mut CommandEncoder,
        pairs: &[Bodies],
        verb: Verb,
    ) -> Result<Option<Question>, GpuError> {
        if let Some(clock) = &mut self.clock {
            clock.forget();
        }
        let Some(arena) = &self.arena else { return Ok(None) };
        let (front, levels) = arena.front(pairs);
        let Some(&root) = front.first() else { return Ok(None) };
        if !self.is_posed {
            let gpu = &self.answer.engine.gpu;
            arena.record_motion(gpu, encoder, &self.poses, self.clock.as_mut());
        }
        self.answer.engine.bind(&arena.model, &arena.model)?;
        // No body is paired with itself, so that these are two meshes.
        let query = Query {
            sides: [Placement::new(&Pose::IDENTITY); 2],
            leaf_size: arena.model.leaf_size,
            ..Query::zeroed()
        };
        let task = Task { query, root, levels, levels_below_seeds: levels };
        let (parts, run) = self.answer.record_from(encoder, &task, &front, verb)?;
        Ok(Some(Question { task, parts, run }))
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
