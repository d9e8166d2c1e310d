//! `pfront self MESH`

use super::{contacts, explain, model};
use crate::args::Within;
use crate::listing::Found;
use anyhow::Result;
use pfront::Adjacency;
use pfront::core::bvtt;
use pfront_study::engine::{Asked, Objects};

pub(crate) fn run(within: &Within) -> Result<bool> {
    let adjacency = match within.skip_neighbours {
        true => Adjacency::SkipNeighbours,
        false => Adjacency::SharedIndexRule,
    };
    let asked = Asked { adjacency, ..within.how.asked()? };
    let model = model(&within.mesh, within.weld)?;
    let mut engine = Objects::within(model.clone()).engine(asked)?;
    let pairs = engine.all()?;
    let with_contacts;
    let found = if within.listing.contacts {
        with_contacts = contacts(&bvtt::SelfBvtt::new(model.bvh()), pairs);
        Found::Contacts(&with_contacts)
    } else {
        Found::Pairs(pairs)
    };
    match within.listing.picture() {
        Some(path) => found.paint(path, &[model.mesh()])?,
        None => found.print(&within.listing)?,
    }
    explain(&within.how, &*engine);
    Ok(true)
}
