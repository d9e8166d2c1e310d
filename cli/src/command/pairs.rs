//! `pfront pairs A B`

use super::{contacts, explain, model};
use crate::args::{Listing, TwoMeshes};
use crate::how::How;
use crate::listing::Found;
use anyhow::Result;
use pfront::core::bvtt;
use pfront_study::engine::Objects;

pub(crate) fn run(meshes: &TwoMeshes, listing: &Listing, how: &How) -> Result<bool> {
    let asked = how.asked()?;
    let (a, b) = (model(&meshes.a, false)?, model(&meshes.b, false)?);
    let a_from_b = meshes.a_from_b();
    let mut engine = Objects::pair(a.clone(), b.clone()).engine(asked)?;
    engine.place(1, a_from_b)?;
    let pairs = engine.all()?;
    let with_contacts;
    let found = if listing.contacts {
        let query = bvtt::PairBvtt::new(a.bvh(), b.bvh(), a_from_b)?;
        with_contacts = contacts(&query, pairs);
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
    explain(how, &*engine);
    Ok(true)
}
