//! Many posed bodies.

mod answer;
mod arena;
mod pairs;
mod placing;
mod table;
#[cfg(test)]
mod tests;

use crate::check::check_pose;
use crate::engine::Engine;
use crate::layout::{Body, InstancePair, Query, Row};
use crate::memory::reserve;
use crate::report::reports;
use crate::runner::{Asked, Runner};
use crate::task::{GpuVerb, Task};
use crate::{Gpu, GpuError, GpuReport, GpuSettings};
pub use answer::WorldAnswer;
use arena::Arena;
use bytemuck::Zeroable;
pub use pairs::BodyPair;
use pairs::{Chunk, Chunks};
#[cfg(not(target_arch = "wasm32"))]
use pfront_core::bvtt::TrianglePair;
use pfront_core::{Bvh, Mesh, Pose};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use table::Table;

/// Many bodies, of which pairs are asked whether they meet in the world. The answer is the same, to the bit, as that of the
/// CPU: every vertex is posed into the world by [`Pose::apply`], whatever the other body is.
///
/// A body is an instance of a mesh: a pose and what comparing boxes takes of it. On the device each mesh lies once
/// and the passes pose what they test. A scene has its bodies here, and a batch of poses of two meshes is a body for
/// each pose. The caller finds the pairs of bodies that may meet, by a broad phase over their boxes.
///
/// For two meshes take a [`GpuQuery`](crate::GpuQuery): a world of two bodies answers the same in 1.3 to 1.6 times as long, since the
/// commands of a query are recorded ahead and its one pose is a parameter (`benches/record/gpu.md`).
///
/// # Memory
/// On the device, 52 bytes a triangle and 32 a node (about 21 a triangle with the default leaf size) for each mesh; 12
/// a vertex and about 9 a node more if it deforms; 128 a body, as on the host; 212 for each pair of the largest question, of which at most
/// 65,535 are there at a time; and the [`crate::Budget`].
///
/// # Complexity
/// A question about m pairs of bodies takes O(m) on the host and uploads 24 bytes a pair, up to twice as much where meshes
/// differ most in size, and 128 a body from the first to the last that has moved. The device makes rows of pairs of them.
///
/// # Examples
/// ```no_run
/// use pfront_core::Pose;
/// use pfront_gpu::{Gpu, World};
/// # fn demo(tile: pfront_core::Bvh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// let gpu = Gpu::new()?;
/// let mut world = World::new(&gpu, gpu.settings())?;
/// let mesh = world.add_mesh(tile)?;
/// world.set_bodies(&[(mesh, Pose::IDENTITY); 2])?;
/// for frame in 0..4 {
///     world.set_pose(1, Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]))?;
///     println!("{} pairs", world.all(&[[0, 1]])?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct World {
    runner: Runner,
    arena: Arena,
    bodies: Arc<Vec<Body>>,
    /// The number of the mesh of each.
    meshes: Arc<Vec<u32>>,
    /// The bodies of which the device does not know yet what they are now.
    moved: Range<usize>,
    /// Whether a mesh has moved since its bodies were placed.
    is_stale: bool,
    table: Table,
    /// Memory for rows.
    spare: Vec<Row>,
    question: Option<WorldQuestion>,
    found: WorldAnswer,
    /// Chunks of the next question for all hits, at least.
    chunks: u64,
}

/// A question that has been submitted.
#[derive(Debug)]
struct WorldQuestion {
    verb: GpuVerb,
    pairs: Vec<BodyPair>,
    /// Pairs to be asked later, if there are any.
    later: Option<Chunks>,
    /// The chunk that has been submitted, and the number of its first pair.
    now: Option<(Asked, usize)>,
}

impl World {
    /// A world of no bodies.
    ///
    /// # Errors
    /// [`GpuError::Budget`], [`GpuError::TooLarge`], [`GpuError::OutOfMemory`]; [`GpuError::Device`] if a shader does not
    /// compile.
    pub fn new(gpu: &Gpu, settings: GpuSettings) -> Result<Self, GpuError> {
        let passes = gpu.instances()?;
        let engine = Engine::with_passes(gpu, &settings, passes.descent.clone())?;
        Ok(Self {
            runner: Runner::new(engine),
            arena: Arena::new(),
            bodies: Arc::default(),
            meshes: Arc::default(),
            moved: 0..0,
            is_stale: false,
            table: Table::new(passes),
            spare: Vec::new(),
            question: None,
            found: WorldAnswer::default(),
            chunks: 1,
        })
    }

    /// Removes all bodies and all meshes.
    pub fn clear(&mut self) {
        self.question = None;
        (self.bodies, self.meshes) = Default::default();
        self.arena = Arena::new();
    }

    /// Uploads a mesh with its BVH, and returns its number: they count from 0. An answer that has not been read is lost.
    /// After an error there are no bodies and no meshes.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if all meshes together do not fit in a binding; [`GpuError::OutOfMemory`].
    ///
    /// # Complexity
    /// O(triangles), but for the growth of buffers.
    pub fn add_mesh(&mut self, bvh: Bvh<'_>) -> Result<u32, GpuError> {
        self.question = None;
        let gpu = self.runner.engine.gpu.clone();
        self.arena.add(&gpu, &bvh).inspect_err(|_| self.clear())?;
        Ok(self.arena.meshes.len() as u32 - 1)
    }

    /// Replaces all bodies, each by the number of its mesh and its pose `world_from_body`. On error nothing changes.
    ///
    /// # Errors
    /// [`GpuError::NoMesh`]; [`GpuError::Pose`] if a pose is not finite or takes its body out of range; [`GpuError::Coordinate`].
    pub fn set_bodies(&mut self, bodies: &[(u32, Pose)]) -> Result<(), GpuError> {
        bodies.iter().try_for_each(|(mesh, pose)| self.check(*mesh, pose))?;
        let placed = bodies.iter().map(|(mesh, pose)| self.arena.place(*mesh, pose));
        match Arc::get_mut(&mut self.bodies) {
            Some(own) => {
                own.clear();
                own.extend(placed);
            }
            None => self.bodies = Arc::new(placed.collect()),
        }
        self.meshes = Arc::new(bodies.iter().map(|(mesh, _)| *mesh).collect());
        (self.moved, self.is_stale) = (0..bodies.len(), false);
        Ok(())
    }

    /// Moves a body to the pose `world_from_body`.
    ///
    /// # Errors
    /// [`GpuError::NoBody`]; [`GpuError::Pose`] if the pose is not finite or takes the body out of range; [`GpuError::Coordinate`].
    ///
    /// # Complexity
    /// O(1); O(bodies) while a question has not been read, and once after one that failed.
    pub fn set_pose(&mut self, body: u32, world_from_body: Pose) -> Result<(), GpuError> {
        let (bodies, at) = (self.bodies.len() as u32, body as usize);
        let mesh = *self.meshes.get(at).ok_or(GpuError::NoBody { body, bodies })?;
        self.check(mesh, &world_from_body)?;
        Arc::make_mut(&mut self.bodies)[at] = self.arena.place(mesh, &world_from_body);
        self.moved = match &self.moved {
            moved if moved.is_empty() => at..at + 1,
            moved => moved.start.min(at)..moved.end.max(at + 1),
        };
        Ok(())
    }

    /// Moves the vertices of a mesh, given in its own frame, and of all bodies that have it. Their poses have to be such
    /// that do not take them out of range. An answer that has not been read is lost.
    ///
    /// # Errors
    /// [`GpuError::NoMesh`]; [`GpuError::Mesh`] if a coordinate is not finite or the number of vertices differs;
    /// [`GpuError::OutOfMemory`] the first time.
    ///
    /// # Complexity
    /// O(vertices) on the host; the next question refits the tree of this mesh, and looks at all bodies once.
    pub fn set_positions(&mut self, mesh: u32, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        let meshes = self.arena.meshes.len() as u32;
        if mesh >= meshes {
            return Err(GpuError::NoMesh { mesh, meshes });
        }
        Mesh::new(positions, &[])?;
        self.question = None;
        self.is_stale = true;
        self.arena.set_positions(&self.runner.engine.gpu, mesh as usize, positions)
    }

    /// Gives a mesh another tree or another shape, for all bodies that have it. Their poses have to be such that do not take them
    /// out of range. An answer that has not been read is lost. After an error there are no bodies and no meshes.
    ///
    /// # Errors
    /// [`GpuError::NoMesh`]; as [`World::add_mesh`].
    ///
    /// # Complexity
    /// O(triangles), but for the growth of buffers; the next question looks at all bodies once.
    pub fn set_mesh(&mut self, mesh: u32, bvh: Bvh<'_>) -> Result<(), GpuError> {
        let meshes = self.arena.meshes.len() as u32;
        if mesh >= meshes {
            return Err(GpuError::NoMesh { mesh, meshes });
        }
        (self.question, self.is_stale) = (None, true);
        let gpu = self.runner.engine.gpu.clone();
        self.arena.set_mesh(&gpu, mesh as usize, &bvh).inspect_err(|_| self.clear())
    }
}

/// Verbs that wait for their answers.
#[cfg(not(target_arch = "wasm32"))]
impl World {
    /// All pairs of triangles of these pairs of bodies that meet, sorted; the first triangle is one of the first body.
    ///
    /// # Errors
    /// [`GpuError::NoBody`]; [`GpuError::TooLarge`] if 128 bytes for each body of the world are more than the device binds: a million by WebGPU's
    /// default limits; [`GpuError::DeviceLost`], [`GpuError::Device`], [`GpuError::OutOfMemory`].
    pub fn all(&mut self, pairs: &[BodyPair]) -> Result<&[(BodyPair, TrianglePair)], GpuError> {
        Ok(&self.ask(pairs, GpuVerb::All)?.hits)
    }

    /// Calls back with the hits of each pair of bodies that has any, as [`World::all`] lists them, in one call or a few, in
    /// the order of `pairs`. Needs no list of all of them.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn all_each(
        &mut self,
        pairs: &[BodyPair],
        mut visit: impl FnMut(BodyPair, &[TrianglePair]),
    ) -> Result<(), GpuError> {
        self.submit(pairs, GpuVerb::All)?;
        let take =
            |_: &mut WorldAnswer, runner: &mut Runner, pairs: &[BodyPair], first, shift, _| {
                answer::each_list(runner, &pairs[first..], shift, &mut visit)
            };
        pollster::block_on(self.finish(take)).map(drop)
    }

    /// Some pair that meets, if any does.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn any(
        &mut self,
        pairs: &[BodyPair],
    ) -> Result<Option<(BodyPair, TrianglePair)>, GpuError> {
        Ok(self.ask(pairs, GpuVerb::Any)?.hits.first().copied())
    }

    /// How many pairs meet. Needs no memory for them.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn count(&mut self, pairs: &[BodyPair]) -> Result<u64, GpuError> {
        Ok(self.ask(pairs, GpuVerb::Count)?.count)
    }

    /// Some pair of triangles that meets of each pair of bodies, if any does.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn any_each(&mut self, pairs: &[BodyPair]) -> Result<&[Option<TrianglePair>], GpuError> {
        Ok(&self.ask(pairs, GpuVerb::AnyEach)?.each)
    }

    /// How many pairs of triangles of each pair of bodies meet.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn count_each(&mut self, pairs: &[BodyPair]) -> Result<&[u64], GpuError> {
        Ok(&self.ask(pairs, GpuVerb::CountEach)?.counts)
    }

    /// Waits for the question that was submitted, and answers it. On the web this is an `async fn`.
    ///
    /// # Errors
    /// [`GpuError::NotSubmitted`] if there is none; as [`World::all`].
    pub fn read(&mut self) -> Result<&WorldAnswer, GpuError> {
        pollster::block_on(self.answer())
    }

    fn ask(&mut self, pairs: &[BodyPair], verb: GpuVerb) -> Result<&WorldAnswer, GpuError> {
        self.submit(pairs, verb)?;
        self.read()
    }
}

impl World {
    /// Submits a question, for [`World::read`] to answer, and waits for nothing. Bodies may change in the meantime: the
    /// question is about those of now. An earlier answer that has not been read is lost.
    ///
    /// # Errors
    /// As [`World::all`].
    pub fn submit(&mut self, pairs: &[BodyPair], verb: GpuVerb) -> Result<(), GpuError> {
        self.question = None;
        let bodies = self.bodies.len() as u32;
        if let Some(&body) = pairs.iter().flatten().find(|&&body| body >= bodies) {
            return Err(GpuError::NoBody { body, bodies });
        }
        if std::mem::take(&mut self.is_stale) {
            for (body, &mesh) in Arc::make_mut(&mut self.bodies).iter_mut().zip(&*self.meshes) {
                *body = self.arena.place(mesh, &Pose::new(body.pose));
            }
            self.moved = 0..self.bodies.len();
        }
        let limits = self.runner.engine.gpu.device().limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most_rows = (bytes / size_of::<InstancePair>() as u64) as usize;
        let is_each = verb == GpuVerb::AnyEach;
        let most_pairs = match verb {
            GpuVerb::All => pairs.len().div_ceil(self.chunks as usize),
            _ => pairs.len(),
        };
        let most = [most_rows, most_pairs.max(1)];
        let mut chunks = Chunks::new(&self.arena, self.meshes.clone(), pairs, most, is_each);
        let first = chunks.next(&self.arena, pairs, std::mem::take(&mut self.spare));
        let later = (!chunks.is_over(pairs)).then_some(chunks);
        let begin = |chunk| {
            self.runner.bodies = self.bodies.clone();
            let moved = std::mem::replace(&mut self.moved, 0..0);
            self.submit_chunk(chunk, moved, verb)
        };
        let now = first.map(begin).transpose()?;
        self.question = Some(WorldQuestion { verb, pairs: pairs.to_vec(), later, now });
        Ok(())
    }

    /// Whether what has been submitted is done, so that [`World::read`] does not wait for it; it does for what the budget
    /// makes necessary in addition.
    ///
    /// # Errors
    /// [`GpuError::NotSubmitted`]; [`GpuError::Device`], [`GpuError::DeviceLost`].
    pub fn is_ready(&mut self) -> Result<bool, GpuError> {
        let question = self.question.as_ref().ok_or(GpuError::NotSubmitted)?;
        match &question.now {
            Some((asked, _)) => self.runner.engine.read_back.is_done(&asked.run),
            None => Ok(true),
        }
    }

    /// Awaits the question that was submitted, and answers it.
    ///
    /// # Errors
    /// As natively.
    #[cfg(target_arch = "wasm32")]
    pub async fn read(&mut self) -> Result<&WorldAnswer, GpuError> {
        self.answer().await
    }

    async fn answer(&mut self) -> Result<&WorldAnswer, GpuError> {
        let (verb, pairs) = self.finish(WorldAnswer::add).await?;
        if verb == GpuVerb::AnyEach {
            self.found.count = self.found.each.iter().flatten().count() as u64;
        }
        // Hits of a pair of bodies are in order, and they come in the order of pairs.
        if !pairs.is_sorted_by(|x, y| x < y) {
            self.found.hits.sort();
        }
        Ok(&self.found)
    }

    /// Waits for the chunks of the question that was submitted, has the results of each taken, and submits the next. `take` gets
    /// the pairs of bodies, the number of the first of the chunk, and the bits of an id within a block.
    async fn finish(
        &mut self,
        mut take: impl FnMut(
            &mut WorldAnswer,
            &mut Runner,
            &[BodyPair],
            usize,
            u32,
            GpuVerb,
        ) -> Result<(), GpuError>,
    ) -> Result<(GpuVerb, Vec<BodyPair>), GpuError> {
        let WorldQuestion { verb, pairs, mut later, mut now } =
            self.question.take().ok_or(GpuError::NotSubmitted)?;
        self.found.clear();
        match verb {
            GpuVerb::AnyEach => {
                reserve(&mut self.found.each, pairs.len())?;
                self.found.each.resize(pairs.len(), None);
            }
            GpuVerb::CountEach => {
                reserve(&mut self.found.counts, pairs.len())?;
                self.found.counts.resize(pairs.len(), 0);
            }
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => {}
        }
        if now.is_none() {
            self.runner.clear();
        }
        let (mut report, mut hits, mut most_hits) = (GpuReport::default(), 0, 0);
        while let Some((asked, first)) = now {
            let shift = asked.task.query.pair_shift;
            let rows = std::mem::take(&mut self.spare);
            let next = later.as_mut().and_then(|later| later.next(&self.arena, &pairs, rows));
            self.runner.finish(asked, verb).await?;
            report.join(&self.runner.report);
            (hits, most_hits) = (hits + self.runner.count, most_hits.max(self.runner.count));
            take(&mut self.found, &mut self.runner, &pairs, first, shift, verb)?;
            self.runner.engine.read_back.shown = None;
            let is_over = verb == GpuVerb::Any && self.found.count != 0;
            let next = next.filter(|_| !is_over);
            if next.is_some() && self.runner.engine.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            now = next.map(|chunk| self.submit_chunk(chunk, 0..0, verb)).transpose()?;
        }
        self.runner.bodies = Arc::default();
        self.runner.report = report;
        if verb == GpuVerb::All {
            // As many as have the hits of each put in order by the device, at least if pairs are alike.
            let most = self.runner.engine.lists.capacities.ordered();
            let needed = (hits + hits / 4).div_ceil(most).max(1);
            self.chunks = match most_hits > most {
                true => (2 * self.chunks).min(2 * needed).max(needed),
                false if needed == 1 => 1,
                false => self.chunks.min(2 * needed).max(needed),
            };
        }
        Ok((verb, pairs))
    }

    /// Has questions end early: once the flag is set, reading one waits for nothing, submits nothing more, and returns
    /// [`GpuError::Cancelled`]. Work that has been submitted goes on.
    pub fn set_cancel(&mut self, flag: Option<Arc<AtomicBool>>) {
        self.runner.engine.cancel = flag;
    }

    /// Bytes of device memory that meshes, bodies and pairs take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.arena.bytes() + self.table.bytes()
    }

    fn check(&self, mesh: u32, pose: &Pose) -> Result<(), GpuError> {
        let meshes = self.arena.meshes.len() as u32;
        let own = self.arena.meshes.get(mesh as usize).ok_or(GpuError::NoMesh { mesh, meshes })?;
        match &own.bounds {
            Some(bounds) if *pose != Pose::IDENTITY => check_pose(pose, bounds),
            _ => Ok(()),
        }
    }

    /// Records and submits what brings the device up to date, and the first run over a chunk.
    fn submit_chunk(
        &mut self,
        chunk: Chunk,
        moved: Range<usize>,
        verb: GpuVerb,
    ) -> Result<(Asked, usize), GpuError> {
        let gpu = self.runner.engine.gpu.clone();
        let Chunk { rows, shift, first, front, levels } = chunk;
        self.spare = std::mem::replace(&mut self.runner.rows, rows);
        let submit = || {
            let mut encoder = self.runner.engine.encoder();
            self.arena.record_refits(&mut encoder);
            self.table.write(&mut self.runner, &self.arena, &mut encoder, moved)?;
            let leaf_size = self.arena.leaf_size;
            let query = Query { pair_shift: shift, leaf_size, ..Query::zeroed() };
            let root = front.first().copied().unwrap_or_default();
            let task = Task { query, root, levels, levels_below_seeds: levels };
            let asked = self.runner.begin_from(&mut encoder, task, &front, verb)?;
            self.runner.engine.submit(encoder.finish());
            self.arena.moved.clear();
            Ok((asked, first))
        };
        // Nothing is known of what is there then.
        gpu.checked(submit).inspect_err(|_| self.table.buffers = None)
    }
}

reports!(World);
