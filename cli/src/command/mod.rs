//! What each command does. `Ok(false)` is only for a question whose answer is no.

pub(crate) mod any;
pub(crate) mod bake;
pub(crate) mod bench;
pub(crate) mod devices;
pub(crate) mod pairs;
pub(crate) mod self_collision;

use anyhow::{Context, Result};
use pfront::core::bvtt::Query;
use pfront::executor::Plan;
use pfront::{Contact, Model, TrianglePair};
use pfront_cli::executor::ExecutorArgs;
use pfront_cli::mesh::{self, Loaded, MeshData};
use std::path::Path;

/// Reads a mesh, welds it if asked to, and builds its BVH, unless it was baked with one.
fn model(path: &Path, weld: bool) -> Result<Model> {
    let mesh = match mesh::load(path)? {
        Loaded::Baked(model) if !weld => return Ok(*model),
        loaded => MeshData::from(loaded),
    };
    let MeshData { positions, triangles } = if weld { mesh.welded() } else { mesh };
    Model::new(positions, triangles).with_context(|| path.display().to_string())
}

/// The contacts of pairs that meet. One that is only near, as other accuracies than exact report, has none.
fn contacts(query: &impl Query, pairs: &[TrianglePair]) -> Vec<(TrianglePair, Contact)> {
    pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?))).collect()
}

/// Says on standard error who has answered, and why, if there was a choice.
fn explain(executor: &ExecutorArgs, plan: Option<&Plan>) {
    if let Some(plan) = plan.filter(|_| executor.is_auto()) {
        eprintln!("{plan}");
    }
}
