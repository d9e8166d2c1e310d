//! `pfront scene MESH…`

use super::{baked, built, check_files, explain, list_fits, read};
use crate::args::Scene;
use crate::curve::AnyContact;
use crate::listing::{Found, Hit, Kind, Origin};
use crate::progress::shown;
use anyhow::{Context, Result, bail, ensure};
use pfront::{Model, Pose, SceneHit, SceneQuery};
use pfront_files::{Contents, MeshFile, Source, name_apart};
use std::path::{Path, PathBuf};
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
    let Scene { meshes, ignore, bodies, reading, listing, executor } = asked;
    let contacts = listing.needs_contacts()?;
    if *bodies {
        let format = listing.format()?;
        ensure!(!format.is_drawn(), "--bodies is text: leave it out, or write .json or .csv");
    }
    check_files(&meshes.iter().map(PathBuf::as_path).collect::<Vec<_>>(), listing.file())?;
    let mut scene = SceneQuery::new().on(&executor.open()?);
    let (mut parts, mut sources) = (Vec::new(), Vec::new());
    for path in meshes {
        let loaded = shown(format!("reading {}", path.display()), || read(path, reading))?;
        let name = body_name(path, meshes);
        sources.push(split(loaded, path, name, sources.len(), &mut parts)?);
    }
    name_apart(parts.iter_mut().map(|part| &mut part.name));
    let (mut ids, mut origins, mut files) = (Vec::new(), Vec::new(), Vec::new());
    for Part { name, model, file, first } in parts {
        ids.push(scene.add(Arc::new(model), Pose::IDENTITY).with_context(|| name.clone())?);
        origins.push(Origin { name, source: &sources[file], first });
        files.push(&meshes[file]);
    }
    // A body by its name, or else by the path, name or stem of its file.
    let named = |name: &String| {
        let names = |found: &[usize]| {
            found.iter().map(|&body| &origins[body].name[..]).collect::<Vec<_>>().join(", ")
        };
        let all: Vec<_> = (0..origins.len()).collect();
        let of = |path: &Path| {
            path == Path::new(name)
                || [path.file_name(), path.file_stem()].contains(&Some(name.as_ref()))
        };
        let mut found: Vec<_> = all.iter().copied().filter(|&body| of(files[body])).collect();
        if let Some(exact) = origins.iter().position(|origin| origin.name == *name) {
            found = vec![exact];
        }
        match found[..] {
            [body] => Ok(ids[body]),
            [] => bail!("there is no body {name}; there are {}", names(&all)),
            _ => bail!("{name} can be any of {}", names(&found)),
        }
    };
    for two in ignore.chunks_exact(2) {
        let [a, b] = [named(&two[0])?, named(&two[1])?];
        ensure!(a != b, "--ignore {} {}: that is one body, and two are needed", two[0], two[1]);
        scene.ignore(a, b, true)?;
    }

    let is_f64 = scene.bodies().any(|body| body.model().is_f64());
    let of_hit =
        size_of::<SceneHit>() + if contacts { size_of::<(SceneHit, AnyContact)>() } else { 0 };
    let with_contacts: Vec<(SceneHit, AnyContact)> =
        shown("asking which bodies meet".to_owned(), || {
            list_fits(scene.count()?, of_hit, reading)?;
            scene.update()?;
            anyhow::Ok(match (contacts, is_f64) {
                (false, _) => Vec::new(),
                (true, false) => {
                    let contacts = scene.contacts()?.iter();
                    contacts.map(|&(hit, contact)| (hit, AnyContact::F32(contact))).collect()
                }
                (true, true) => {
                    let contacts = scene.contacts_f64()?.into_iter();
                    contacts.map(|(hit, contact)| (hit, AnyContact::F64(contact))).collect()
                }
            })
        })?;
    let place = |id| ids.binary_search(&id).unwrap_or_else(|place| place);
    let hit =
        |hit: &SceneHit, contact| Hit { origins: hit.bodies.map(place), pair: hit.pair, contact };
    let found = Found {
        origins: &origins,
        kind: if *bodies { Kind::Bodies } else { Kind::Scene },
        hits: match contacts {
            true => Box::new(with_contacts.iter().map(|(of, contact)| hit(of, Some(*contact)))),
            false => Box::new(scene.hits().iter().map(|of| hit(of, None))),
        },
    };
    let posed: Vec<_> = scene.bodies().map(|body| (body.model().mesh(), body.pose())).collect();
    found.write(listing, &posed)?;
    explain(executor, scene.plan());
    Ok(true)
}

/// The name of a file, with its folder if another of the files has the same.
fn body_name(path: &Path, files: &[PathBuf]) -> String {
    let is_alike = |other: &&PathBuf| other.file_name() == path.file_name();
    let is_ambiguous = files.iter().filter(is_alike).any(|other| other != path);
    let name = path.file_name().filter(|_| !is_ambiguous).map(Path::new);
    name.unwrap_or(path).display().to_string()
}

/// Adds the bodies of a file, which has the name if it is one body.
fn split(
    loaded: Contents,
    path: &Path,
    name: String,
    file: usize,
    parts: &mut Vec<Part>,
) -> Result<Source> {
    let (mesh, source) = match loaded {
        Contents::Baked(bytes) => {
            parts.push(Part { name, model: baked(&bytes, path)?, file, first: 0 });
            return Ok(Source::default());
        }
        Contents::Mesh(MeshFile { mesh, source, .. }) => (mesh, source),
    };
    let mut nodes: Vec<_> = source.nodes().map(|(name, first)| (name.to_owned(), first)).collect();
    if nodes.is_empty() {
        nodes.push((name, 0));
    }
    let ends = nodes.iter().skip(1).map(|(_, first)| *first as usize).collect::<Vec<_>>();
    let ends = ends.into_iter().chain([mesh.triangles.len()]);
    for ((name, first), end) in nodes.iter().zip(ends) {
        let model = built(mesh.part(*first as usize..end), path, &source)?;
        parts.push(Part { name: name.clone(), model, file, first: *first });
    }
    Ok(source)
}
