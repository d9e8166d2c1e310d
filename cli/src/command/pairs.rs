//! `pfront pairs A B`

use super::{explain, hits, list_fits, two};
use crate::args::{Listing, TwoMeshes};
use crate::listing::{FileRow, Found, Kind, Origin};
use crate::progress::shown;
use anyhow::Result;
use pfront::{PairQuery, Pose, TrianglePair};
use pfront_cli::executor::ExecutorArgs;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, executor: &ExecutorArgs) -> Result<bool> {
    let contacts = listing.needs_contacts()?;
    let mut query = PairQuery::new().within(meshes.near.distance())?.on(&executor.open()?);
    let [(a, source_a), (b, source_b)] = two(meshes, listing.file())?;
    let a_from_b = meshes.a_from_b();
    let pairs = shown("asking which triangles meet".to_owned(), || query.all(&a, &b, a_from_b))?;
    list_fits(pairs.len(), size_of::<TrianglePair>(), &meshes.reading)?;
    let bvtt = a_from_b.pair([a.bvh(), b.bvh()])?;
    let is_f64 = a.is_f64() || b.is_f64() || a_from_b.is_f64();
    let origins = [&source_a, &source_b].map(Origin::of_file);
    let found = Found {
        files: vec![FileRow::new(&meshes.a, [&a]), FileRow::new(&meshes.b, [&b])],
        origins: &origins,
        kind: Kind::Pairs,
        within: meshes.near.within,
        hits: hits(pairs, [0, 1], contacts, is_f64, &bvtt),
    };
    let is_clear = !listing.fail || pairs.is_empty();
    found.write(listing, &[(a.mesh(), Pose::IDENTITY.into()), (b.mesh(), a_from_b)])?;
    explain(executor, query.plan());
    Ok(is_clear)
}
