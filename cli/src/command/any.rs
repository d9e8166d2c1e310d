//! `pfront any A B`

use super::{explain, model};
use crate::args::TwoMeshes;
use crate::how::How;
use crate::output::out;
use anyhow::Result;
use pfront_study::engine::Objects;
use std::io::Write;

pub(crate) fn run(meshes: &TwoMeshes, how: &How) -> Result<bool> {
    let asked = how.asked()?;
    let (a, b) = (model(&meshes.a, false)?, model(&meshes.b, false)?);
    let mut engine = Objects::pair(a, b).engine(asked)?;
    engine.place(1, meshes.a_from_b())?;
    let found = engine.any()?;
    match found {
        Some(pair) => writeln!(out(), "triangles {} and {} meet", pair.a, pair.b)?,
        None => writeln!(out(), "nothing meets")?,
    }
    explain(how, &*engine);
    Ok(found.is_some())
}
