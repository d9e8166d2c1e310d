//! `pfront pairs A B`

use super::model;
use crate::args::{Listing, TwoMeshes};
use crate::how::How;
use crate::listing::Found;
use anyhow::Result;
use std::convert::identity;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, how: &How) -> Result<bool> {
    let mut query = how.asked()?.pair_query();
    let (a, b) = (model(&meshes.a, identity)?, model(&meshes.b, identity)?);
    let a_from_b = meshes.a_from_b();
    let found = if listing.contacts {
        Found::Contacts(query.contacts(&a, &b, &a_from_b)?)
    } else {
        Found::Pairs(query.all(&a, &b, &a_from_b)?)
    };
    match listing.picture() {
        Some(path) => {
            let posed: Vec<_> = b.mesh().positions().iter().map(|&p| a_from_b.apply(p)).collect();
            found.paint(path, &[a.mesh(), b.mesh().with_positions(&posed)?])?;
        }
        None => found.print(listing)?,
    }
    Ok(true)
}
