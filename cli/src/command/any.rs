//! `pfront any A B`

use super::{explain, model};
use crate::args::TwoMeshes;
use anyhow::Result;
use pfront::PairQuery;
use pfront_cli::executor::ExecutorArgs;
use pfront_cli::output::out;
use std::io::Write;

pub(crate) fn run(meshes: &TwoMeshes, executor: &ExecutorArgs) -> Result<bool> {
    let mut query = PairQuery::new().with_accuracy(executor.accuracy()).on(&executor.open()?);
    let (a, b) = (model(&meshes.a, false)?, model(&meshes.b, false)?);
    let found = query.any(&a, &b, &meshes.a_from_b())?;
    match found {
        Some(pair) => writeln!(out(), "triangles {} and {} meet", pair.a, pair.b)?,
        None => writeln!(out(), "nothing meets")?,
    }
    explain(executor, query.plan());
    Ok(found.is_some())
}
