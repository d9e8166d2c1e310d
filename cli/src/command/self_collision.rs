//! `pfront self MESH`

use super::{check_files, explain, hits, list_fits, model};
use crate::args::SelfCollision;
use crate::listing::{Found, Kind, Origin};
use crate::progress::shown;
use anyhow::Result;
use pfront::pfront_core::bvtt::SelfBvtt;
use pfront::{Adjacency, Pose, SelfQuery, TrianglePair};
use pfront_files::escape::shown_path;

pub(crate) fn run(asked: &SelfCollision) -> Result<bool> {
    let SelfCollision { mesh: path, weld, skip_neighbours, reading, listing, executor } = asked;
    let contacts = listing.needs_contacts()?;
    check_files(&[path], listing.file())?;
    let adjacency = match skip_neighbours {
        true => Adjacency::SkipNeighbours,
        false => Adjacency::SharedIndexRule,
    };
    let query = SelfQuery::new().with_adjacency(adjacency);
    let mut query = query.on(&executor.open()?);
    let (mut joined, mut vertices) = (0, 0);
    let (model, source) = model(path, *weld, reading, |mesh| {
        (joined, vertices) = (mesh.unwelded(), mesh.positions.len());
    })?;
    if joined > 0 && !weld {
        let path = shown_path(path);
        eprintln!(
            "{path}: no two triangles share a vertex, but {joined} of {vertices} vertices lie where another does, so \
             that neighbours meet: did you mean --weld?"
        );
    }
    let pairs = shown("asking which triangles meet".to_owned(), || {
        list_fits(query.count(&model)?, size_of::<TrianglePair>(), reading)?;
        anyhow::Ok(query.all(&model)?)
    })?;
    let bvtt = SelfBvtt::new(model.bvh());
    let found = Found {
        origins: &[Origin::of_file(&source)],
        kind: Kind::Pairs,
        hits: hits(pairs, [0, 0], contacts, model.is_f64(), &bvtt),
    };
    found.write(listing, &[(model.mesh(), Pose::IDENTITY.into())])?;
    explain(executor, query.plan());
    Ok(true)
}
