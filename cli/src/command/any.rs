//! `pfront any A B`

use super::{explain, two};
use crate::args::TwoMeshes;
use crate::listing::FileRow;
use anyhow::Result;
use pfront::PairQuery;
use pfront_cli::executor::ExecutorArgs;
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::output::out;
use serde_json::json;
use std::io::Write;

pub(crate) fn run(meshes: &TwoMeshes, executor: &ExecutorArgs, as_json: bool) -> Result<bool> {
    let mut query = PairQuery::new().within(meshes.near.distance())?.on(&executor.open()?);
    let [(a, _), (b, _)] = two(meshes, None)?;
    let found = query.any(&a, &b, meshes.a_from_b())?;
    if as_json {
        let files =
            [(&meshes.a, &a), (&meshes.b, &b)].map(|(path, model)| FileRow::new(path, [model]));
        let mut answer =
            json!({ "version": VERSION, "files": files, "pair": found.map(|p| [p.a, p.b]) });
        if let Some(distance) = meshes.near.within {
            answer["within"] = json!(distance);
        }
        write_json(&mut out(), &answer)?;
    } else {
        let is_near = meshes.near.within.is_some();
        match found {
            Some(pair) if is_near => {
                writeln!(out(), "triangles {} and {} are within the distance", pair.a, pair.b)
            }
            Some(pair) => writeln!(out(), "triangles {} and {} meet", pair.a, pair.b),
            None if is_near => writeln!(out(), "nothing is within the distance"),
            None => writeln!(out(), "nothing meets"),
        }?;
    }
    explain(executor, query.plan());
    Ok(found.is_some())
}
