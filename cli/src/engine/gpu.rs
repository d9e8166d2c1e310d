//! Engines on a GPU.

use super::{Engine, Objects, OnGpu};
use anyhow::{Result, bail};
use pfront::gpu::{Deforming, Gpu, Model, PairQuery, Report, SelfQuery, Settings, Timing};
use pfront::{Adjacency, Pose, TrianglePair};
use pfront_cli::workload::Frame;
use pfront_scenes::Kind;
use std::sync::Arc;

/// Uploads each model once.
pub(super) fn engine(
    objects: &Objects,
    adjacency: Adjacency,
    on: &OnGpu,
) -> Result<Box<dyn Engine>> {
    let OnGpu { gpu, settings, timed } = on;
    match (objects.kind, &objects.models[..]) {
        (Kind::Pair, [a, b]) => {
            let first = Arc::new(Model::new(gpu, a.bvh())?);
            let second = match Arc::ptr_eq(a, b) {
                true => first.clone(),
                false => Arc::new(Model::new(gpu, b.bvh())?),
            };
            let query = pair_query(gpu, *settings, *timed)?;
            Ok(Box::new(Pair { models: [first, second], a_from_b: Pose::IDENTITY, query }))
        }
        (Kind::SelfMesh, [model]) => {
            let model = Deforming::new(gpu, model.bvh())?;
            let model = if *timed { model.with_timings()? } else { model };
            let query = self_query(gpu, *settings, *timed)?.with_adjacency(adjacency);
            Ok(Box::new(Within { model, moved: false, query }))
        }
        _ => bail!("many objects at once do not run on a GPU yet: leave out --backend gpu"),
    }
}

fn pair_query(gpu: &Gpu, settings: Settings, timed: bool) -> Result<PairQuery> {
    let query = PairQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

fn self_query(gpu: &Gpu, settings: Settings, timed: bool) -> Result<SelfQuery> {
    let query = SelfQuery::with_settings(gpu, settings)?;
    Ok(if timed { query.with_timings()? } else { query })
}

struct Pair {
    models: [Arc<Model>; 2],
    a_from_b: Pose,
    query: PairQuery,
}

impl Engine for Pair {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Poses(&[_, a_from_b]) = frame {
            self.a_from_b = a_from_b;
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        let [a, b] = &self.models;
        Ok(self.query.all(a, b, &self.a_from_b)?)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>> {
        let [a, b] = &self.models;
        Ok(self.query.any(a, b, &self.a_from_b)?)
    }

    fn gpu_report(&self) -> Option<Report> {
        Some(self.query.report())
    }

    fn device_bytes(&self) -> u64 {
        let [a, b] = &self.models;
        a.bytes() + if Arc::ptr_eq(a, b) { 0 } else { b.bytes() }
    }

    fn timings(&self) -> Result<Vec<Timing>> {
        Ok(self.query.timings()?)
    }
}

struct Within {
    model: Deforming,
    /// Whether there has been a refit, which may be timed.
    moved: bool,
    query: SelfQuery,
}

impl Engine for Within {
    fn update(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Frame::Positions(positions) = frame {
            self.model.set_positions(positions)?;
            self.moved = true;
        }
        Ok(())
    }

    fn all(&mut self) -> Result<&[TrianglePair]> {
        Ok(self.query.all(&self.model)?)
    }

    fn any(&mut self) -> Result<Option<TrianglePair>> {
        Ok(self.query.any(&self.model)?)
    }

    fn gpu_report(&self) -> Option<Report> {
        Some(self.query.report())
    }

    fn device_bytes(&self) -> u64 {
        self.model.bytes()
    }

    fn timings(&self) -> Result<Vec<Timing>> {
        let mut timings = if self.moved { self.model.timings()? } else { Vec::new() };
        timings.extend(self.query.timings()?);
        Ok(timings)
    }
}
