//! Backends that find the pairs of a frame: threads of the CPU, or the GPU.

use crate::cases::{Asker, Case, all_threads, pool};
use pfront::gpu::{Deforming, Gpu, GpuModel, GpuQuery, GpuQuestion};
use pfront::threads::Schedule;
use pfront::{Model, Pose, TrianglePair};

/// Moves what moves to a frame, and finds its pairs.
pub(crate) trait Backend {
    fn frame(&mut self, frame: usize) -> &[TrianglePair];
}

/// Threads of the CPU, or one.
pub(crate) struct Cpu<'c> {
    case: &'c Case,
    asker: Asker,
    /// The model that deforms.
    moving: Option<Model>,
}

impl<'c> Cpu<'c> {
    pub(crate) fn new(case: &'c Case, threads: bool) -> Self {
        let moving = match case {
            Case::Pair { .. } => None,
            Case::Within { model, .. } => Some(model.clone()),
        };
        let asker = match threads {
            true => Asker::on(&pool(all_threads(), Schedule::Hybrid)),
            false => Asker::default(),
        };
        Self { case, asker, moving }
    }
}

impl Backend for Cpu<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        match (self.case, &mut self.moving) {
            (Case::Within { frames, .. }, Some(moving)) => {
                let positions = frames[frame].mesh().shadow();
                self.asker.within.set_positions(moving, positions).unwrap();
                self.asker.within.all(moving).unwrap()
            }
            _ => self.case.found(&mut self.asker, frame),
        }
    }
}

struct Pair<'c> {
    models: [GpuModel; 2],
    poses: &'c [Pose],
    query: GpuQuery,
}

impl Backend for Pair<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        let [a, b] = &self.models;
        self.query.all(&GpuQuestion::pair(a, b, &self.poses[frame])).unwrap()
    }
}

struct Within<'c> {
    moving: Deforming,
    frames: &'c [Model],
    query: GpuQuery,
}

impl Backend for Within<'_> {
    fn frame(&mut self, frame: usize) -> &[TrianglePair] {
        self.moving.set_positions(self.frames[frame].mesh().shadow()).unwrap();
        self.query.all(&GpuQuestion::within(&self.moving)).unwrap()
    }
}

/// The best adapter's.
pub(crate) fn on_gpu<'c>(gpu: &Gpu, case: &'c Case) -> Box<dyn Backend + 'c> {
    match case {
        Case::Pair { a, b, poses, .. } => Box::new(Pair {
            models: [a, b].map(|model| GpuModel::new(gpu, model.bvh()).unwrap()),
            poses,
            query: GpuQuery::new(gpu).unwrap(),
        }),
        Case::Within { model, frames, .. } => Box::new(Within {
            moving: Deforming::new(gpu, model.bvh()).unwrap(),
            frames,
            query: GpuQuery::new(gpu).unwrap(),
        }),
    }
}
