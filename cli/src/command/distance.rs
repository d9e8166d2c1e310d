//! `pfront distance A B`

use super::{explain, two};
use crate::args::TwoMeshes;
use crate::listing::FileRow;
use anyhow::Result;
use pfront::PairQuery;
use pfront_cli::executor::ExecutorArgs;
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::output::out;
use serde_json::{json, to_value};
use std::io::Write;

/// `Ok(false)` if they are farther apart than is asked.
pub(crate) fn run(meshes: &TwoMeshes, executor: &ExecutorArgs, as_json: bool) -> Result<bool> {
    let mut query = PairQuery::new().on(&executor.open()?);
    let [(a, _), (b, _)] = two(meshes, None)?;
    let gap = match meshes.near.within {
        None => query.distance(&a, &b, meshes.a_from_b())?,
        Some(limit) => query.distance_below(&a, &b, meshes.a_from_b(), limit)?,
    };
    if as_json {
        let files =
            [(&meshes.a, &a), (&meshes.b, &b)].map(|(path, model)| FileRow::new(path, [model]));
        let mut answer = json!({
            "version": VERSION,
            "files": files,
            "distance": gap.map(|gap| gap.interval),
            "pair": gap.map(|gap| [gap.pair.a, gap.pair.b]),
            "points": gap.map(|gap| gap.points),
        });
        if let Some(limit) = meshes.near.within {
            answer["within"] = to_value(limit)?;
        }
        write_json(&mut out(), &answer)?;
    } else {
        match gap {
            None if meshes.near.within.is_some() => writeln!(out(), "they are farther apart"),
            None => writeln!(out(), "a mesh has no triangles"),
            Some(gap) => {
                let ([low, high], [from, to]) = (gap.interval, gap.points);
                let point = |p: [f64; 3]| format!("{},{},{}", p[0], p[1], p[2]);
                let (from, to) = (point(from), point(to));
                let triangles = format!("triangles {} and {}", gap.pair.a, gap.pair.b);
                if high == 0.0 {
                    writeln!(out(), "0, as {triangles} meet at {from}")
                } else {
                    writeln!(out(), "{low} to {high}, {triangles}, from {from} to {to}")
                }
            }
        }?;
    }
    explain(executor, query.plan());
    Ok(gap.is_some())
}
