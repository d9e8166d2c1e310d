//! What a workload asks, frame by frame, of the CPU or of a GPU.

mod cpu;
mod gpu;
mod numbers;

use anyhow::{Context, Result};
use pfront::gpu::{Gpu, Settings, Timing};
use pfront::threads::{Reference, Report, Traversal};
use pfront::{Accuracy, Adjacency, Model, TrianglePair};
use pfront_cli::workload::{Frame, Header};
use pfront_scenes::Kind;
use std::sync::Arc;

/// Models and the query over them.
pub(crate) trait Engine {
    /// Moves everything to where it is in a frame.
    fn update(&mut self, frame: Frame<'_>) -> Result<()>;
    /// All pairs, sorted, numbered as in a pair file.
    fn all(&mut self) -> Result<&[TrianglePair]>;
    /// Some pair that meets.
    fn any(&mut self) -> Result<Option<TrianglePair>>;
    /// What the last frame on threads did.
    fn report(&self) -> Option<&Report> {
        None
    }
    /// Algorithm 1 for this frame; only of two objects or one, on the CPU.
    fn reference(&self, _workers: usize) -> Result<Option<Reference>> {
        Ok(None)
    }
    /// What the last frame on a GPU did.
    fn gpu_report(&self) -> Option<pfront::gpu::Report> {
        None
    }
    /// Bytes of device memory that the models take.
    fn device_bytes(&self) -> u64 {
        0
    }
    /// The passes of the last frame on a GPU that was asked to keep time.
    fn timings(&self) -> Result<Vec<Timing>> {
        Ok(Vec::new())
    }
}

/// What is wanted of an answer, and of whom.
#[derive(Clone)]
pub(crate) struct Asked {
    pub(crate) accuracy: Accuracy,
    pub(crate) adjacency: Adjacency,
    pub(crate) on: On,
}

/// Who finds the pairs.
#[derive(Clone)]
pub(crate) enum On {
    /// Several threads, or else the calling one.
    Cpu(Option<Box<Traversal>>),
    /// A GPU, whose answers are all exact.
    Gpu(OnGpu),
}

#[derive(Clone)]
pub(crate) struct OnGpu {
    pub(crate) gpu: Gpu,
    pub(crate) settings: Settings,
    /// Keeps the time of each pass.
    pub(crate) timed: bool,
}

impl OnGpu {
    /// With the settings that suit it.
    pub(crate) fn new(gpu: Gpu) -> Self {
        Self { settings: gpu.settings(), gpu, timed: false }
    }
}

impl From<On> for Asked {
    /// Everything, exactly.
    fn from(on: On) -> Self {
        Self { accuracy: Accuracy::Exact, adjacency: Adjacency::default(), on }
    }
}

/// What a workload is about.
#[derive(Clone)]
pub(crate) struct Objects {
    kind: Kind,
    models: Vec<Arc<Model>>,
}

impl Objects {
    pub(crate) fn pair(a: Arc<Model>, b: Arc<Model>) -> Self {
        Self { kind: Kind::Pair, models: vec![a, b] }
    }

    pub(crate) fn within(model: Arc<Model>) -> Self {
        Self { kind: Kind::SelfMesh, models: vec![model] }
    }

    /// Builds each mesh's BVH, once.
    ///
    /// # Errors
    /// If a mesh is none.
    pub(crate) fn new(header: Header) -> Result<Self> {
        let models = header.meshes.into_iter().zip(0..).map(|(mesh, number)| {
            let model = Model::new(mesh.positions, mesh.triangles);
            model.map(Arc::new).with_context(|| format!("mesh {number}"))
        });
        let models: Vec<Arc<Model>> = models.collect::<Result<_>>()?;
        let models = header.objects.iter().map(|&m| models[m as usize].clone()).collect();
        Ok(Self { kind: header.kind, models })
    }

    /// Triangles of all objects together.
    pub(crate) fn triangles(&self) -> usize {
        self.models.iter().map(|model| model.mesh().triangles().len()).sum()
    }

    /// Puts them where they are asked about.
    ///
    /// # Errors
    /// If there are more triangles than u32 can number, or than the GPU has memory for.
    pub(crate) fn engine(self, asked: Asked) -> Result<Box<dyn Engine>> {
        match asked.on {
            On::Gpu(on) => gpu::engine(&self, asked.adjacency, &on),
            On::Cpu(_) => cpu::engine(self, asked),
        }
    }
}
