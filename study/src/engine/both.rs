//! Threads and a GPU on one front, of which the GPU gets a share that does not change.

use super::{Engine, EngineError, Objects, OnGpu, second};
use pfront::core::bvtt::{self, NodePair, Query};
use pfront::gpu::wgpu::CommandEncoder;
use pfront::gpu::{self, Deforming, Gpu, Pending};
use pfront::threads::Traversal;
use pfront::{Adjacency, Model, Pose, TrianglePair};
use pfront_scenes::Kind;
use std::sync::Arc;

/// Of two models or one; many bodies are not divided so.
pub(super) fn engine(
    objects: &Objects,
    adjacency: Adjacency,
    on: OnGpu,
    traversal: Traversal,
    share: f64,
) -> Result<Box<dyn Engine>, EngineError> {
    let OnGpu { gpu, settings, .. } = on;
    let both = Both { share, traversal, pairs: Vec::new(), gpu: gpu.clone() };
    match (objects.kind, &objects.models[..]) {
        (Kind::Pair, [a, b]) => Ok(Box::new(Pair {
            both,
            device: [gpu::Model::new(&gpu, a.bvh())?, gpu::Model::new(&gpu, b.bvh())?],
            host: [a.clone(), b.clone()],
            a_from_b: Pose::IDENTITY,
            query: gpu::PairQuery::with_settings(&gpu, settings)?,
        })),
        (Kind::SelfMesh, [model]) => Ok(Box::new(Within {
            both,
            device: Deforming::new(&gpu, model.bvh())?,
            host: model.clone(),
            query: gpu::SelfQuery::with_settings(&gpu, settings)?.with_adjacency(adjacency),
            adjacency,
        })),
        _ => Err(EngineError::Unable { what: "to divide many bodies between CPU and GPU" }),
    }
}

struct Both {
    gpu: Gpu,
    share: f64,
    traversal: Traversal,
    pairs: Vec<TrianglePair>,
}

impl Both {
    /// Asks; `record` records what lies below the nodes that the GPU gets.
    fn all<'q>(
        &mut self,
        query: &(impl Query + Sync),
        record: impl FnOnce(&mut CommandEncoder, &[NodePair]) -> Result<Pending<'q>, gpu::Error> + Send,
    ) -> Result<&[TrianglePair], EngineError> {
        let Self { gpu, share, traversal, pairs } = self;
        let start = |below: &[NodePair]| {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            let pending = record(&mut encoder, below);
            gpu.queue().submit([encoder.finish()]);
            pending
        };
        let pending = traversal.all_beside(query, *share, start, pairs)?;
        pairs.extend_from_slice(pending.read()?);
        // Two ascending runs, which this merges.
        pairs.sort();
        Ok(pairs)
    }
}

struct Pair {
    both: Both,
    host: [Arc<Model>; 2],
    device: [gpu::Model; 2],
    a_from_b: Pose,
    query: gpu::PairQuery,
}

impl Engine for Pair {
    fn place(&mut self, object: usize, world_from_object: Pose) -> Result<(), EngineError> {
        second(object, world_from_object, &mut self.a_from_b)
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        let Self { both, host: [a, b], device: [on_a, on_b], a_from_b, query } = self;
        let asked =
            bvtt::PairQuery::new(a.bvh(), b.bvh(), *a_from_b).map_err(pfront::Error::from)?;
        both.all(&asked, |encoder, below| query.record_below(encoder, on_a, on_b, a_from_b, below))
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        Ok(self.all()?.first().copied())
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        Ok(self.all()?.len() as u64)
    }
}

struct Within {
    both: Both,
    host: Arc<Model>,
    device: Deforming,
    query: gpu::SelfQuery,
    adjacency: Adjacency,
}

impl Engine for Within {
    fn place(&mut self, _object: usize, _world_from_object: Pose) -> Result<(), EngineError> {
        Err(EngineError::Unmovable { what: "a mesh as a whole that is asked about itself" })
    }

    fn deform(&mut self, positions: &[[f32; 3]]) -> Result<(), EngineError> {
        let (model, threads) = (Arc::make_mut(&mut self.host), &self.both.traversal);
        let tree = model.stamp().tree();
        threads.install(|| model.set_positions_with_threads(positions))?;
        // Both have to have the same nodes.
        if model.stamp().tree() == tree {
            self.device.set_positions(positions)?;
        } else {
            self.device = Deforming::new(&self.both.gpu, model.bvh())?;
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair], EngineError> {
        let Self { both, host, device, query, adjacency } = self;
        let asked = bvtt::SelfQuery::new(host.bvh()).with_adjacency(*adjacency);
        let asked = asked.with_fans(host.fans());
        both.all(&asked, |encoder, below| query.record_below(encoder, device, below))
    }

    fn any(&mut self) -> Result<Option<TrianglePair>, EngineError> {
        Ok(self.all()?.first().copied())
    }

    fn count(&mut self) -> Result<u64, EngineError> {
        Ok(self.all()?.len() as u64)
    }
}
