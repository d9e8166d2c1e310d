//! What each command does. `Ok(false)` is only for a question whose answer is no.

pub(crate) mod any;
pub(crate) mod bake;
pub(crate) mod balance;
pub(crate) mod bench;
pub(crate) mod chart;
pub(crate) mod demo;
pub(crate) mod devices;
pub(crate) mod judge;
pub(crate) mod pairs;
pub(crate) mod record;
pub(crate) mod regret;
pub(crate) mod replay;
pub(crate) mod stability;
pub(crate) mod within;

use crate::how::How;
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use pfront::core::bvtt::Query;
use pfront::{Contact, Model, TrianglePair};
use pfront_cli::mesh::{self, Loaded, MeshData};
use pfront_study::engine::Engine;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Reads a mesh, welds it if asked to, and builds its BVH, unless it was baked with one.
fn model(path: &Path, weld: bool) -> Result<Arc<Model>> {
    let mesh = match mesh::load(path)? {
        Loaded::Baked(model) if !weld => return Ok(model.into()),
        loaded => MeshData::from(loaded),
    };
    let MeshData { positions, triangles } = if weld { mesh.welded() } else { mesh };
    let model = Model::new(positions, triangles);
    model.map(Arc::new).with_context(|| path.display().to_string())
}

/// Where pairs meet. One that is only near, as other accuracies than exact report, meets nowhere.
fn contacts(query: &impl Query, pairs: &[TrianglePair]) -> Vec<(TrianglePair, Contact)> {
    pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?))).collect()
}

/// Says on standard error who has answered, and why, if there was a choice.
fn explain(how: &How, engine: &dyn Engine) {
    if let Some(plan) = engine.plan().filter(|_| how.is_auto()) {
        eprintln!("{plan}");
    }
}

/// Progress over frames, on a terminal's standard error; elsewhere nothing.
fn progress(frames: u64) -> ProgressBar {
    let bar = ProgressBar::new(frames);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} frame {pos} of {len}, {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
