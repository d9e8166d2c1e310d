//! `pfront self MESH…`

use super::{check_files, explain, hits, list_fits, model, unshared};
use crate::args::SelfCollision;
use crate::listing::{FileRow, Found, Kind, Origin};
use crate::progress::shown;
use anyhow::Result;
use pfront::pfront_core::bvtt::SelfBvtt;
use pfront::{Adjacency, Pose, SelfQuery, TrianglePair};
use pfront_files::escape::shown_path;
use std::path::PathBuf;

pub(crate) fn run(asked: &SelfCollision) -> Result<bool> {
    let SelfCollision { meshes, skip_neighbours, near, reading, listing, executor } = asked;
    let contacts = listing.needs_contacts()?;
    check_files(&meshes.iter().map(PathBuf::as_path).collect::<Vec<_>>(), listing.file())?;
    let adjacency = match skip_neighbours {
        true => Adjacency::SkipNeighbours,
        false => Adjacency::SharedIndexRule,
    };
    let query = SelfQuery::new().with_adjacency(adjacency).within(near.distance())?;
    let mut query = query.on(&executor.open()?);
    let mut read = Vec::new();
    for path in meshes {
        let (model, source) = model(path, reading)?;
        let what = format!("asking which triangles of {} meet", path.display());
        let pairs = shown(what, || query.all(&model).map(<[_]>::to_vec))?;
        list_fits(pairs.len(), size_of::<TrianglePair>(), reading)?;
        let alone = unshared(model.mesh(), &pairs);
        if 2 * alone > pairs.len() {
            eprintln!(
                "{}: in {alone} of {} pairs the triangles share a position, but no vertex: did you mean --weld?",
                shown_path(path),
                pairs.len()
            );
        }
        read.push((model, source, pairs));
    }
    let name = |path: &PathBuf| path.display().to_string();
    let origins: Vec<_> = (read.iter().zip(meshes))
        .map(|((_, source, _), path)| Origin { name: name(path), ..Origin::of_file(source) })
        .collect();
    let bvtts: Vec<_> = read.iter().map(|(model, ..)| SelfBvtt::new(model.bvh())).collect();
    let of_files = read.iter().zip(&bvtts).enumerate().map(|(file, ((model, _, pairs), bvtt))| {
        hits(pairs, [file; 2], contacts, model.is_f64(), bvtt)
    });
    let found = Found {
        files: read
            .iter()
            .zip(meshes)
            .map(|((model, ..), path)| FileRow::new(path, [model]))
            .collect(),
        origins: &origins,
        kind: if meshes.len() > 1 { Kind::Files } else { Kind::Pairs },
        within: near.within,
        hits: Box::new(of_files.flatten()),
    };
    let is_clear = !listing.fail || read.iter().all(|(.., pairs)| pairs.is_empty());
    let posed: Vec<_> =
        read.iter().map(|(model, ..)| (model.mesh(), Pose::IDENTITY.into())).collect();
    found.write(listing, &posed)?;
    explain(executor, query.plan());
    Ok(is_clear)
}
