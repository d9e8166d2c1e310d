//! `pfront pairs A B`

use super::{contacts, explain, model};
use crate::args::{Listing, TwoMeshes};
use crate::listing::Found;
use anyhow::Result;
use pfront::PairQuery;
use pfront::core::bvtt::PairBvtt;
use pfront_cli::executor::ExecutorArgs;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, executor: &ExecutorArgs) -> Result<bool> {
    let mut query = PairQuery::new().with_accuracy(executor.accuracy()).on(&executor.open()?);
    let (a, b) = (model(&meshes.a, false)?, model(&meshes.b, false)?);
    let a_from_b = meshes.a_from_b();
    let pairs = query.all(&a, &b, &a_from_b)?;
    let with_contacts;
    let found = if listing.contacts {
        with_contacts = contacts(&PairBvtt::new(a.bvh(), b.bvh(), a_from_b)?, pairs);
        Found::Contacts(&with_contacts)
    } else {
        Found::Pairs(pairs)
    };
    match listing.picture() {
        Some(path) => {
            let posed: Vec<_> = b.mesh().positions().iter().map(|&p| a_from_b.apply(p)).collect();
            found.paint(path, &[a.mesh(), b.mesh().with_positions(&posed)?])?;
        }
        None => found.print(listing)?,
    }
    explain(executor, query.plan());
    Ok(true)
}
