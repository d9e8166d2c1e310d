//! `pfront pairs A B`

use super::{explain, hits, list_fits, two};
use crate::args::{Listing, TwoMeshes};
use crate::listing::{Found, Kind, Origin};
use crate::progress::shown;
use anyhow::Result;
use pfront::{PairQuery, Pose, TrianglePair};
use pfront_cli::executor::ExecutorArgs;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, executor: &ExecutorArgs) -> Result<bool> {
    let contacts = listing.needs_contacts()?;
    let mut query = PairQuery::new().on(&executor.open()?);
    let [(a, source_a), (b, source_b)] = two(meshes, listing.file())?;
    let a_from_b = meshes.a_from_b();
    let pairs = shown("asking which triangles meet".to_owned(), || {
        list_fits(query.count(&a, &b, a_from_b)?, size_of::<TrianglePair>(), &meshes.reading)?;
        anyhow::Ok(query.all(&a, &b, a_from_b)?)
    })?;
    let bvtt = a_from_b.pair([a.bvh(), b.bvh()])?;
    let is_f64 = a.is_f64() || b.is_f64() || a_from_b.is_f64();
    let origins = [&source_a, &source_b].map(Origin::of_file);
    let found = Found {
        origins: &origins,
        kind: Kind::Pairs,
        hits: hits(pairs, [0, 1], contacts, is_f64, &bvtt),
    };
    found.write(listing, &[(a.mesh(), Pose::IDENTITY.into()), (b.mesh(), a_from_b)])?;
    explain(executor, query.plan());
    Ok(true)
}
