//! `pfront self MESH`

use super::{contacts, explain, model};
use crate::args::SelfCollision;
use crate::listing::Found;
use anyhow::Result;
use pfront::core::bvtt::SelfBvtt;
use pfront::{Adjacency, SelfQuery};

pub(crate) fn run(asked: &SelfCollision) -> Result<bool> {
    let SelfCollision { mesh, weld, skip_neighbours, listing, executor } = asked;
    let adjacency = match skip_neighbours {
        true => Adjacency::SkipNeighbours,
        false => Adjacency::SharedIndexRule,
    };
    let query = SelfQuery::new().with_accuracy(executor.accuracy()).with_adjacency(adjacency);
    let mut query = query.on(&executor.open()?);
    let model = model(mesh, *weld)?;
    let pairs = query.all(&model)?;
    let with_contacts;
    let found = if listing.contacts {
        with_contacts = contacts(&SelfBvtt::new(model.bvh()), pairs);
        Found::Contacts(&with_contacts)
    } else {
        Found::Pairs(pairs)
    };
    match listing.picture() {
        Some(path) => found.paint(path, &[model.mesh()])?,
        None => found.print(listing)?,
    }
    explain(executor, query.plan());
    Ok(true)
}
