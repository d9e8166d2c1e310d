//! `pfront self MESH`

use super::model;
use crate::args::Within;
use crate::listing::Found;
use anyhow::Result;
use pfront::Adjacency;

pub(crate) fn run(within: &Within) -> Result<bool> {
    let mut query = within.how.asked()?.self_query();
    if within.skip_neighbours {
        query = query.with_adjacency(Adjacency::SkipNeighbours);
    }
    let model = model(&within.mesh, |mesh| if within.weld { mesh.welded() } else { mesh })?;
    let found = if within.listing.contacts {
        Found::Contacts(query.contacts(&model))
    } else {
        Found::Pairs(query.all(&model))
    };
    match within.listing.picture() {
        Some(path) => found.paint(path, &[model.mesh()])?,
        None => found.print(&within.listing)?,
    }
    Ok(true)
}
