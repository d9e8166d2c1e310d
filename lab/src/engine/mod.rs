//! Moving objects and an executor that answers, frame by frame.
//!
//! One driver for all studies and for the command: [`Objects`] are what is asked about, [`Asked`] says how and
//! of whom, and the [`Engine`] that both make keeps its buffers from frame to frame.

mod cpu;
#[cfg(feature = "gpu")]
mod gpu;
mod numbers;
mod tally;

pub use tally::Tally;

use crate::stability::Reference;
use pfront::executor::Plan;
#[cfg(feature = "gpu")]
use pfront::gpu::{Gpu, GpuSettings, Timing};
use pfront::threads::Report;
use pfront::{Accuracy, Adjacency, Executor, Model, Pose, TrianglePair};
use pfront_testkit::scenes::Kind;
use std::sync::Arc;

/// Models and the query over them.
pub trait Engine {
    /// Moves an object to where it is in the world. The world of a pair is its first object, which stays
    /// where it is.
    ///
    /// # Errors
    /// [`EngineError::Query`] for a pose that takes it out of range; [`EngineError::Unmovable`].
    fn place(&mut self, object: usize, world_from_object: Pose) -> Result<(), EngineError>;

    /// Moves the vertices of the one mesh.
    ///
    /// # Errors
    /// [`EngineError::Query`] for a coordinate that is not finite or another number of them;
    /// [`EngineError::Unmovable`].
    fn deform(&mut self, _positions: &[[f32; 3]]) -> Result<(), EngineError> {
        Err(EngineError::Unmovable { what: "the vertices of rigid objects" })
    }

    /// All pairs, sorted, numbered as in a pair file: triangles of many objects through all of them.
    ///
    /// # Errors
    /// Those of the query; so for all that asks.
    fn all(&mut self) -> Result<&[TrianglePair], EngineError>;

    /// Some pair that meets.
    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError>;

    /// How many pairs meet.
    fn count(&mut self) -> Result<u64, EngineError>;

    /// Finds all pairs as the query gives them, and says how many there are.
    fn find(&mut self) -> Result<usize, EngineError> {
        Ok(self.all()?.len())
    }

    /// Who answered the last frame, and why.
    fn plan(&self) -> Option<&Plan> {
        None
    }

    /// What the last frame on threads did.
    fn report(&self) -> Option<&Report> {
        None
    }

    /// Algorithm 1 for this frame; only of two objects or one, on the CPU.
    fn reference(&self, _workers: usize) -> Result<Option<Reference>, EngineError> {
        Ok(None)
    }

    /// What the last frame on a GPU did.
    #[cfg(feature = "gpu")]
    fn gpu_report(&self) -> Option<pfront::gpu::GpuReport> {
        None
    }

    /// Bytes of device memory that the models take.
    fn device_bytes(&self) -> u64 {
        0
    }

    /// The passes of the last frame on a GPU that was asked to keep time.
    #[cfg(feature = "gpu")]
    fn timings(&self) -> Result<Vec<Timing>, EngineError> {
        Ok(Vec::new())
    }
}

/// Why an engine could not do as told.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// A mesh, a pose or a question was refused.
    #[error(transparent)]
    Query(#[from] pfront::Error),
    /// The GPU refused or failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] pfront::gpu::GpuError),
    /// All objects together are too large.
    #[error("more triangles than u32 can number; leave out some objects")]
    TooMany,
    /// What does not move so.
    #[error("{what} cannot be moved: place objects, and deform only what is asked about itself")]
    Unmovable {
        /// What was to be moved.
        what: &'static str,
    },
    /// Not everyone can do everything.
    #[error("there is no way {what}: ask somebody else")]
    Unable {
        /// What was to be done.
        what: &'static str,
    },
    /// There is no such object.
    #[error("there is no object {object}; there are {objects}")]
    NoObject {
        /// Asked for.
        object: usize,
        /// How many there are.
        objects: usize,
    },
}

impl EngineError {
    /// Whether somebody else could do it, or the same with more memory.
    #[must_use]
    pub fn is_want_of_means(&self) -> bool {
        match self {
            Self::Unable { .. } => true,
            #[cfg(feature = "gpu")]
            Self::Gpu(error) | Self::Query(pfront::Error::Gpu(error)) => matches!(
                error,
                pfront::gpu::GpuError::TooLarge { .. } | pfront::gpu::GpuError::OutOfMemory { .. }
            ),
            _ => false,
        }
    }
}

/// What is wanted of an answer, and of whom.
#[derive(Clone)]
pub struct Asked {
    /// What the answer promises.
    pub accuracy: Accuracy,
    /// What counts within one mesh.
    pub adjacency: Adjacency,
    /// Who answers.
    pub on: On,
}

/// Who finds the pairs.
#[derive(Clone)]
pub enum On {
    /// An executor.
    Executor(Executor),
    /// A GPU of which counts and times are wanted.
    #[cfg(feature = "gpu")]
    Gpu(OnGpu),
}

/// A GPU, and how it is used.
#[cfg(feature = "gpu")]
#[derive(Clone)]
pub struct OnGpu {
    /// The GPU.
    pub gpu: Gpu,
    /// Of its queries.
    pub settings: GpuSettings,
    /// Keeps the time of each pass.
    pub timed: bool,
}

#[cfg(feature = "gpu")]
impl OnGpu {
    /// With the settings that suit it.
    #[must_use]
    pub fn new(gpu: Gpu) -> Self {
        Self { settings: gpu.settings(), gpu, timed: false }
    }
}

impl From<Executor> for Asked {
    /// Everything, exactly.
    fn from(executor: Executor) -> Self {
        On::Executor(executor).into()
    }
}

impl From<On> for Asked {
    /// Everything, exactly.
    fn from(on: On) -> Self {
        Self { accuracy: Accuracy::Exact, adjacency: Adjacency::default(), on }
    }
}

/// What is asked about.
#[derive(Clone, Debug)]
pub struct Objects {
    kind: Kind,
    models: Vec<Arc<Model>>,
}

impl Objects {
    /// Of any kind; objects may share a model.
    #[must_use]
    pub fn new(kind: Kind, models: Vec<Arc<Model>>) -> Self {
        Self { kind, models }
    }

    /// Two models, the second against the first.
    #[must_use]
    pub fn pair(a: Arc<Model>, b: Arc<Model>) -> Self {
        Self::new(Kind::Pair, vec![a, b])
    }

    /// A model against itself.
    #[must_use]
    pub fn within(model: Arc<Model>) -> Self {
        Self::new(Kind::SelfMesh, vec![model])
    }

    /// What is asked.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The model of each object.
    #[must_use]
    pub fn models(&self) -> &[Arc<Model>] {
        &self.models
    }

    /// Triangles of all objects together.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.models.iter().map(|model| model.mesh().triangles().len()).sum()
    }

    /// Puts them where they are asked about.
    ///
    /// # Errors
    /// If there are more triangles than u32 can number, or than the GPU has memory for.
    pub fn engine(self, asked: Asked) -> Result<Box<dyn Engine>, EngineError> {
        let Asked { accuracy, adjacency, on } = asked;
        match on {
            #[cfg(feature = "gpu")]
            On::Gpu(on) => gpu::engine(&self, adjacency, &on),
            On::Executor(executor) => cpu::engine(self, accuracy, adjacency, &executor),
        }
    }
}

/// Places an object of a pair, of which only the second moves.
fn second(object: usize, pose: Pose, a_from_b: &mut Pose) -> Result<(), EngineError> {
    match object {
        0 => Ok(()),
        1 => {
            *a_from_b = pose;
            Ok(())
        }
        _ => Err(EngineError::NoObject { object, objects: 2 }),
    }
}
