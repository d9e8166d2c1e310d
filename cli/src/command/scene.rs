//! `pfront scene MESH…`

use super::{explain, in_file, list_fits, read};
use crate::args::Scene;
use crate::listing::{Found, Hit, Origin};
use crate::progress::shown;
use anyhow::{Context, Result};
use pfront::{Contact, Model, Pose, SceneHit, SceneQuery};
use pfront_cli::mesh::{Loaded, Source};
use pfront_testkit::MeshData;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// A body before it is in a scene.
struct Part {
    name: String,
    model: Model,
    /// Number of its file, and the first of its triangles there.
    file: usize,
    first: u32,
}

pub(crate) fn run(asked: &Scene) -> Result<bool> {
    let Scene { meshes, ignore, reading, listing, executor } = asked;
    let contacts = listing.needs_contacts()?;
    let mut scene = SceneQuery::new().with_accuracy(executor.accuracy()).on(&executor.open()?);
    let (mut parts, mut sources) = (Vec::new(), Vec::new());
    for path in meshes {
        let loaded = shown(format!("reading {}", path.display()), || read(path, reading))?;
        sources.push(split(loaded, path, sources.len(), &mut parts)?);
    }
    name_apart(&mut parts);
    let (mut ids, mut origins) = (Vec::new(), Vec::new());
    for Part { name, model, file, first } in parts {
        ids.push(scene.add(Arc::new(model), Pose::IDENTITY).with_context(|| name.clone())?);
        origins.push(Origin { name, source: &sources[file], first });
    }
    let named = |name: &String| {
        let place = origins.iter().position(|origin| origin.name == *name);
        let names = || origins.iter().map(|origin| &origin.name[..]).collect::<Vec<_>>().join(", ");
        place
            .map(|place| ids[place])
            .with_context(|| format!("there is no body {name}; there are {}", names()))
    };
    for two in ignore.chunks_exact(2) {
        scene.ignore(named(&two[0])?, named(&two[1])?, true)?;
    }

    let of_hit =
        size_of::<SceneHit>() + if contacts { size_of::<(SceneHit, Contact)>() } else { 0 };
    shown("asking which bodies meet".to_owned(), || {
        list_fits(scene.count()?, of_hit, reading)?;
        if contacts { scene.contacts().map(drop) } else { scene.update() }
            .map_err(anyhow::Error::from)
    })?;
    let with_contacts = if contacts { scene.contacts()?.to_vec() } else { Vec::new() };
    let place = |id| ids.binary_search(&id).unwrap_or_else(|place| place);
    let hit =
        |hit: &SceneHit, contact| Hit { origins: hit.bodies.map(place), pair: hit.pair, contact };
    let found = Found {
        origins: &origins,
        is_scene: true,
        hits: match contacts {
            true => Box::new(with_contacts.iter().map(|(of, contact)| hit(of, Some(*contact)))),
            false => Box::new(scene.hits().iter().map(|of| hit(of, None))),
        },
    };
    let meshes: Vec<_> = scene.bodies().map(|body| body.model().mesh()).collect();
    found.write(listing, &meshes)?;
    explain(executor, scene.plan());
    Ok(true)
}

/// Adds the bodies of a file.
fn split(loaded: Loaded, path: &Path, file: usize, parts: &mut Vec<Part>) -> Result<Source> {
    let name = path.display().to_string();
    let (mesh, source) = match loaded {
        Loaded::Baked(model) => {
            parts.push(Part { name, model: *model, file, first: 0 });
            return Ok(Source::default());
        }
        Loaded::Mesh(mesh, source) => (mesh, source),
    };
    let mut nodes: Vec<_> = source.nodes().map(|(name, first)| (name.to_owned(), first)).collect();
    if nodes.is_empty() {
        nodes.push((name, 0));
    }
    let ends = nodes.iter().skip(1).map(|(_, first)| *first as usize).collect::<Vec<_>>();
    let ends = ends.into_iter().chain([mesh.triangles.len()]);
    for ((name, first), end) in nodes.iter().zip(ends) {
        let MeshData { positions, triangles } = mesh.part(*first as usize..end);
        let model = Model::new(positions, triangles)
            .map_err(|error| in_file(error.into(), path, &source))?;
        parts.push(Part { name: name.clone(), model, file, first: *first });
    }
    Ok(source)
}

/// Numbers all but the first of those that have one name.
fn name_apart(parts: &mut [Part]) {
    let mut names = HashSet::new();
    for part in parts {
        let name = part.name.clone();
        let mut number = 2;
        while !names.insert(part.name.clone()) {
            part.name = format!("{name} ({number})");
            number += 1;
        }
    }
}
