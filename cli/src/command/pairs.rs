//! `pfront pairs A B`

use super::{explain, hits, list_fits, two};
use crate::args::{Listing, TwoMeshes};
use crate::listing::{Found, Kind, Origin};
use crate::progress::shown;
use anyhow::Result;
use pfront::pfront_core::bvtt::PairBvtt;
use pfront::{PairQuery, TrianglePair};
use pfront_cli::executor::ExecutorArgs;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, executor: &ExecutorArgs) -> Result<bool> {
    let contacts = listing.needs_contacts()?;
    let mut query = PairQuery::new().with_accuracy(executor.accuracy()).on(&executor.open()?);
    let [(a, source_a), (b, source_b)] = two(meshes, listing.file())?;
    let a_from_b = meshes.a_from_b();
    let pairs = shown("asking which triangles meet".to_owned(), || {
        list_fits(query.count(&a, &b, a_from_b)?, size_of::<TrianglePair>(), &meshes.reading)?;
        anyhow::Ok(query.all(&a, &b, a_from_b)?)
    })?;
    let bvtt = PairBvtt::new(a.bvh(), b.bvh(), a_from_b)?;
    let origins = [&source_a, &source_b].map(Origin::of_file);
    let found =
        Found { origins: &origins, kind: Kind::Pairs, hits: hits(pairs, [0, 1], contacts, &bvtt) };
    let posed: Vec<_> = b.mesh().positions().iter().map(|&p| a_from_b.apply(p)).collect();
    found.write(listing, &[a.mesh(), b.mesh().with_positions(&posed)?])?;
    explain(executor, query.plan());
    Ok(true)
}
