//! `pfront any A B`

use super::model;
use crate::args::TwoMeshes;
use crate::how::How;
use crate::output::out;
use anyhow::Result;
use std::convert::identity;
use std::io::Write;

pub(crate) fn run(meshes: &TwoMeshes, how: &How) -> Result<bool> {
    let mut query = how.asked()?.pair_query();
    let (a, b) = (model(&meshes.a, identity)?, model(&meshes.b, identity)?);
    let found = query.any(&a, &b, &meshes.a_from_b())?;
    match found {
        Some(pair) => writeln!(out(), "triangles {} and {} meet", pair.a, pair.b)?,
        None => writeln!(out(), "nothing meets")?,
    }
    Ok(found.is_some())
}
