//! A mesh that moves: positions are uploaded, or taken from a buffer of the caller's; everything else happens on the device.

mod extent;
mod vertices;

use crate::build::{Built, price};
use crate::clock::{Clock, Timing};
use crate::gpu::Gpu;
use crate::model::Outside;
use crate::refit::{Origin, Refit};
use crate::schedule::Schedule;
use crate::sequence::Sequence;
use crate::source::Source;
use crate::totals::count;
use crate::{GpuError, GpuModel};
use extent::Extent;
use pfront_core::bvh::BuildOptions;
use pfront_core::{Aabb, Bvh, Mesh, MeshError};
use std::ops::Deref;
use std::sync::Arc;
use vertices::Taken;
pub use vertices::VertexBuffer;
use wgpu::{Buffer, CommandEncoder, WriteOnly};

/// A [`GpuModel`] whose vertices move. Ask about it as about any other.
///
/// A refit moves the boxes of the tree that is there, and queries slow down as the mesh leaves the shape
/// that the tree was built for. A rebuild makes a new tree. The answers are the same.
///
/// Takes 12 bytes a vertex and 12 a triangle beside those of the model; about 9 a node while the tree is
/// an uploaded one, and 16 a triangle from the first build on. Positions are brought there through two staging buffers in turn,
/// of 12 bytes a vertex each.
///
/// # Examples
/// ```no_run
/// # fn demo(gpu: pfront_gpu::Gpu, mesh: pfront_core::Mesh<'_>) -> Result<(), pfront_gpu::GpuError> {
/// use pfront_gpu::{Deforming, GpuQuery, GpuQuestion};
/// let mut cloth = Deforming::build(&gpu, mesh, &Default::default())?;
/// let mut query = GpuQuery::new(&gpu)?;
/// # let frames: [Vec<[f32; 3]>; 0] = [];
/// for (frame, positions) in frames.iter().enumerate() {
///     if frame % 10 == 0 {
///         cloth.rebuild_at(positions)?;
///     } else {
///         cloth.set_positions(positions)?;
///     }
///     println!("{} pairs", query.all(&GpuQuestion::itself(&cloth))?.len());
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Deforming {
    gpu: Gpu,
    model: GpuModel,
    source: Source,
    options: BuildOptions<'static>,
    /// The dispatches that fit the boxes.
    fit: Arc<Sequence>,
    /// The refit to positions from the host.
    refit: Arc<Refit>,
    /// The refits to positions from buffers of the caller's, the last that was new first.
    taken: Vec<Taken>,
    /// `None` while the tree is an uploaded one.
    build: Option<Sequence>,
    /// If times are wanted.
    clock: Option<Clock>,
}

impl Deref for Deforming {
    type Target = GpuModel;

    fn deref(&self) -> &GpuModel {
        &self.model
    }
}

impl Deforming {
    /// The size of leaves that suits devices. Leaves of the CPU are larger, since it tests eight triangles at once.
    pub const LEAF_SIZE: u32 = 4;

    /// Uploads a mesh with its BVH.
    ///
    /// # Errors
    /// As [`GpuModel::new`].
    ///
    /// # Complexity
    /// O(triangles).
    pub fn new(gpu: &Gpu, bvh: Bvh<'_>) -> Result<Self, GpuError> {
        GpuModel::check_precision(bvh.mesh())?;
        let source = Source::new(gpu, bvh.mesh())?;
        let model = GpuModel::of_source(gpu, bvh, &source)?;
        let schedule = Schedule::new(bvh.nodes());
        let fit = schedule.sequence(gpu, [&model.nodes, &model.corners], 0, &source.positions)?;
        // A rebuild keeps to leaves of this size.
        let leaf_size = bvh.nodes().iter().map(|node| node.count).max().unwrap_or(0);
        let options = BuildOptions { leaf_size, ..BuildOptions::default() };
        Ok(Self::of(gpu, model, source, options, fit, None))
    }

    /// Uploads a mesh and builds its BVH on the device.
    ///
    /// All leaves hold the same number of triangles or one more, at most `options.leaf_size`, of which 1
    /// counts as 2. The tree is balanced, and a refit of it takes fewer rounds than that of a CPU's tree.
    ///
    /// # Errors
    /// As [`GpuModel::new`].
    ///
    /// # Complexity
    /// O(vertices + triangles) on the host, which waits for nothing, and on the device.
    pub fn build(gpu: &Gpu, mesh: Mesh<'_>, options: &BuildOptions) -> Result<Self, GpuError> {
        GpuModel::check_precision(mesh)?;
        let source = Source::new(gpu, mesh)?;
        count(&gpu.counted().uploads);
        let bounds = Aabb::of(mesh.shadow());
        let Built { model, build, refit } = Built::new(gpu, &source, &bounds, *options)?;
        let options = BuildOptions { leaf_size: options.leaf_size, join: None };
        let mut own = Self::of(gpu, model, source, options, refit, Some(build));
        own.rebuild()?;
        Ok(own)
    }

    fn of(
        gpu: &Gpu,
        model: GpuModel,
        source: Source,
        options: BuildOptions<'static>,
        fit: Sequence,
        build: Option<Sequence>,
    ) -> Self {
        let (gpu, fit, taken, clock) = (gpu.clone(), Arc::new(fit), Vec::new(), None);
        let refit = refit_by_host(&gpu, &source, &fit);
        Self { gpu, model, source, options, fit, refit, taken, build, clock }
    }

    /// The same, keeping the device time of a refit or rebuild as a whole.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn with_time(mut self) -> Result<Self, GpuError> {
        self.clock = Clock::new(&self.gpu, false)?;
        Ok(self)
    }

    /// The same, keeping the device time of each pass, which takes some microseconds for each.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn with_timings(mut self) -> Result<Self, GpuError> {
        self.clock = Clock::new(&self.gpu, true)?;
        Ok(self)
    }

    /// The passes of the last refit or rebuild with their times on the device; empty without
    /// [`Self::with_time`] or [`Self::with_timings`], or if the device cannot tell.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::Device`].
    pub fn timings(&self) -> Result<Vec<Timing>, GpuError> {
        Clock::read(self.clock.as_ref(), &self.gpu)
    }

    /// Moves the vertices and refits the BVH. On [`GpuError::Mesh`] nothing has changed.
    ///
    /// # Errors
    /// [`GpuError::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices) on the host, which waits for nothing; O(triangles) on the device.
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        // Times are those of the last refit that was recorded.
        if self.clock.is_some() || positions.is_empty() {
            return self.submit(|own, encoder| own.record_positions(encoder, positions));
        }
        self.check_count(positions)?;
        self.gpu.clone().checked(|| {
            let refit = self.refit.clone();
            let (commands, source) = refit.take()?;
            if let Some(source) = source {
                self.write(source, positions)?;
            }
            self.model.refit = Some(refit.clone());
            refit.submit(commands)
        })
    }

    /// The same in an encoder of the caller's, which has to be submitted before anything else is asked
    /// about the model.
    ///
    /// # Errors
    /// As [`Deforming::set_positions`].
    pub fn record_positions(
        &mut self,
        encoder: &mut CommandEncoder,
        positions: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        self.record_write(encoder, positions)?;
        self.fit.run(encoder, self.clock.as_mut());
        Ok(())
    }

    /// Moves the vertices to where a buffer of the caller's has them when the device comes to it, and refits the BVH. Nothing passes
    /// through the host, which waits for nothing.
    ///
    /// If a vertex is not in the box that was promised, or not finite, every question about the model that follows ends with
    /// [`GpuError::OutsideBox`], which names the first, until positions are set anew.
    ///
    /// # Errors
    /// [`GpuError::VertexBuffer`], which says what is wrong with the buffer; [`GpuError::TooLarge`] if so much of it cannot be bound at
    /// once; [`GpuError::OutOfMemory`]. Nothing has changed then.
    ///
    /// # Complexity
    /// O(1) on the host, a few microseconds where buffer, layout and box are among the last four; O(vertices + triangles) on the
    /// device.
    pub fn set_positions_from(&mut self, vertices: &VertexBuffer<'_>) -> Result<(), GpuError> {
        if self.clock.is_some() || self.source.vertices == 0 {
            return self.submit(|own, encoder| own.record_positions_from(encoder, vertices));
        }
        self.gpu.clone().checked(|| {
            let refit = self.refit_from(vertices)?;
            self.model.refit = Some(refit.clone());
            refit.submit(refit.take()?.0)
        })
    }

    /// The same in an encoder of the caller's, after the passes that write the buffer. It has to be submitted before anything else is
    /// asked about the model; a question may be recorded into it too ([`GpuQuery::record`](crate::GpuQuery::record)).
    ///
    /// # Errors
    /// As [`Deforming::set_positions_from`].
    pub fn record_positions_from(
        &mut self,
        encoder: &mut CommandEncoder,
        vertices: &VertexBuffer<'_>,
    ) -> Result<(), GpuError> {
        if self.source.vertices == 0 {
            return Ok(());
        }
        let refit = self.refit_from(vertices)?;
        refit.record(encoder, None, self.clock.as_mut());
        Ok(())
    }

    /// The refit to positions from a buffer of the caller's, which is to follow.
    fn refit_from(&mut self, vertices: &VertexBuffer<'_>) -> Result<Arc<Refit>, GpuError> {
        let outside = match self.model.outside.clone() {
            Some(outside) => outside,
            None => Outside::new(&self.gpu, &self.source)?,
        };
        let at = match self.taken.iter().position(|taken| taken.is_from(vertices)) {
            Some(at) => at,
            None => {
                let taken = Taken::new(&self.gpu, &self.source, &outside, &self.fit, vertices)?;
                self.taken.truncate(BUFFERS - 1);
                self.taken.insert(0, taken);
                0
            }
        };
        if self.model.outside.is_none() {
            // Commands that were recorded ahead do not ask whether a vertex is outside.
            (self.model.id, self.model.outside) = (GpuModel::next_id(), Some(outside));
        }
        self.model.bounds = self.model.bounds.map(|_| vertices.bounds);
        Ok(self.taken[at].refit.clone())
    }

    /// Builds a new BVH for the vertices where they are.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] and [`GpuError::TooLarge`], when it replaces an uploaded BVH.
    ///
    /// # Complexity
    /// O(1) on the host, which waits for nothing; O(triangles) on the device.
    pub fn rebuild(&mut self) -> Result<(), GpuError> {
        self.submit(Self::record_rebuild)
    }

    /// Whether a rebuild has paid for itself: queries about the model have done more box tests than when its tree was new, and all
    /// that they have done more are as many as a rebuild takes the time of. After a rebuild that has not halved
    /// them it takes twice as many.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.model.wear.is_due(price(self.source.count, self.options))
    }

    /// The same in an encoder of the caller's, which has to be submitted before anything else is asked
    /// about the model.
    ///
    /// # Errors
    /// As [`Deforming::rebuild`].
    pub fn record_rebuild(&mut self, encoder: &mut CommandEncoder) -> Result<(), GpuError> {
        self.prepare_build()?;
        if let Some(build) = &self.build {
            count(&self.gpu.counted().builds);
            self.model.wear.rebuilt();
            build.run(encoder, self.clock.as_mut());
        }
        Ok(())
    }

    /// Moves the vertices and builds a new BVH. On error none of them has moved.
    ///
    /// # Errors
    /// As [`Deforming::set_positions`] and [`Deforming::rebuild`].
    ///
    /// # Complexity
    /// As [`Deforming::set_positions`].
    pub fn rebuild_at(&mut self, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        self.submit(|own, encoder| own.record_rebuild_at(encoder, positions))
    }

    /// The same in an encoder of the caller's, which has to be submitted before anything else is asked
    /// about the model.
    ///
    /// # Errors
    /// As [`Deforming::rebuild_at`].
    pub fn record_rebuild_at(
        &mut self,
        encoder: &mut CommandEncoder,
        positions: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        self.prepare_build()?;
        self.record_write(encoder, positions)?;
        self.record_rebuild(encoder)
    }

    fn submit(
        &mut self,
        record: impl FnOnce(&mut Self, &mut CommandEncoder) -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        self.refit.lock().staging.forget();
        gpu.checked(|| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            record(self, &mut encoder)?;
            self.refit.submit(encoder.finish())
        })
    }

    /// Puts a model to build in place of an uploaded one.
    fn prepare_build(&mut self) -> Result<(), GpuError> {
        if let (None, Some(bounds)) = (&self.build, &self.model.bounds) {
            let Built { mut model, build, refit } =
                Built::new(&self.gpu, &self.source, bounds, self.options)?;
            model.wear = std::mem::take(&mut self.model.wear);
            model.outside = self.model.outside.take();
            (self.model, self.build, self.fit) = (model, Some(build), Arc::new(refit));
            self.refit = refit_by_host(&self.gpu, &self.source, &self.fit);
            self.taken.clear();
        }
        Ok(())
    }

    fn check_count(&self, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        let (expected, found) = (self.source.vertices, positions.len());
        if found == expected {
            return Ok(());
        }
        Err(MeshError::VertexCount { expected, found }.into())
    }

    /// Records that positions are copied. On error none of them has moved.
    fn record_write(
        &mut self,
        encoder: &mut CommandEncoder,
        positions: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        self.check_count(positions)?;
        let bytes = size_of_val(positions) as u64;
        if bytes == 0 {
            return Ok(());
        }
        let mut next = self.refit.lock();
        next.staging.forget();
        let source = next.staging.take(&self.gpu, bytes)?;
        drop(next);
        self.write(source.clone(), positions)?;
        encoder.copy_buffer_to_buffer(&source, 0, &self.source.positions, 0, bytes);
        Ok(())
    }

    /// Writes positions, which are checked in the same pass, into a mapped buffer.
    fn write(&mut self, source: Buffer, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        let mut extent = Extent::default();
        let fill = |mut view: WriteOnly<'_, [u8]>| {
            let parts = positions.chunks(PART);
            for (at, part) in (0..).step_by(PART * size_of::<[f32; 3]>()).zip(parts) {
                let part_bytes: &[u8] = bytemuck::cast_slice(part);
                view.slice(at..at + part_bytes.len()).copy_from_slice(part_bytes);
                extent.add(part);
            }
        };
        let bytes = size_of_val(positions) as u64;
        self.refit.lock().staging.write_into(&self.gpu, source, bytes, fill)?;
        if !extent.is_finite() {
            Mesh::new(positions, &[])?;
        }
        // The box of all vertices needs no read-back; it only bounds what a pose may do.
        self.model.bounds = self.model.bounds.map(|_| extent.aabb());
        // The host has seen all of them.
        self.taken.clear();
        self.model.refit = None;
        if self.model.outside.take().is_some() {
            self.model.id = GpuModel::next_id();
        }
        Ok(())
    }
}

/// The refit of a mesh to positions from the host, by these dispatches.
fn refit_by_host(gpu: &Gpu, source: &Source, fit: &Arc<Sequence>) -> Arc<Refit> {
    let bytes = (source.vertices * size_of::<[f32; 3]>()) as u64;
    let origin = Origin::Host(source.positions.clone(), bytes);
    Refit::new(gpu, origin, vec![fit.clone()])
}

/// The most buffers of the caller's that are remembered: one for each frame that a renderer has under way.
const BUFFERS: usize = 4;

/// Positions that are copied and checked while they are in the cache.
const PART: usize = 1024;
