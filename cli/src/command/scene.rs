//! `pfront scene MESH…`

use super::{baked, built, check_files, explain, list_fits, read};
use crate::args::Scene;
use crate::curve::AnyContact;
use crate::listing::{FileRow, Found, Hit, Kind, Origin};
use crate::progress::shown;
use anyhow::{Context, Result, anyhow, bail, ensure};
use pfront::{Model, Pose, SceneHit, SceneQuery};
use pfront_files::escape::{escaped, shown_path};
use pfront_files::{Contents, MeshFile, Source, TriangleMesh, name_apart};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wildmatch::WildMatch;

/// A body before it is in a scene.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) model: Model,
    /// Number of its file, and its triangles there, unless it has all.
    pub(super) file: usize,
    pub(super) triangles: Option<Vec<u32>>,
}

pub(crate) fn run(asked: &Scene) -> Result<bool> {
    let Scene { meshes, ignore, ignore_file, bodies, near, reading, listing, executor } = asked;
    let contacts = listing.needs_contacts()?;
    if *bodies {
        let format = listing.format()?;
        ensure!(!format.is_drawn(), "--bodies is text: leave it out, or write .json or .csv");
    }
    check_files(&meshes.iter().map(PathBuf::as_path).collect::<Vec<_>>(), listing.file())?;
    let mut scene = SceneQuery::new().on(&executor.open()?);
    scene.within(near.distance())?;
    let (mut parts, mut sources) = (Vec::new(), Vec::new());
    // Bodies that are near each other stay apart.
    let (of_files, distance) = reading.bodies_apart();
    for path in meshes {
        let loaded = shown(format!("reading {}", path.display()), || read(path, &of_files))?;
        let name = body_name(path, meshes);
        sources.push(split(loaded, path, name, sources.len(), distance, &mut parts)?);
    }
    name_apart(parts.iter_mut().map(|part| &mut part.name));
    if let [only] = &parts[..] {
        eprintln!(
            "there is one body, {}, which has nothing to meet: for that see pfront self",
            escaped(&only.name)
        );
    }
    let (mut ids, mut origins, mut files) = (Vec::new(), Vec::new(), Vec::new());
    let mut rows: Vec<_> = meshes.iter().map(|path| FileRow::new(path, [])).collect();
    for Part { name, model, file, triangles } in parts {
        rows[file].add(&model);
        ids.push(scene.add(Arc::new(model), Pose::IDENTITY).with_context(|| name.clone())?);
        origins.push(Origin { name, source: &sources[file], triangles });
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
        if found.is_empty() && name.contains(['*', '?']) {
            let pattern = WildMatch::new(name);
            let is_alike = |body: &usize| pattern.matches(&origins[*body].name);
            found = all.iter().copied().filter(is_alike).collect();
            if !found.is_empty() {
                return Ok(found);
            }
        }
        match found[..] {
            [body] => Ok(vec![body]),
            [] => bail!("there is no body {name}; there are {}", names(&all)),
            _ => bail!("{name} can be any of {}", names(&found)),
        }
    };
    let mut ignored: Vec<_> =
        ignore.chunks_exact(2).map(|two| [&two[0], &two[1]].map(String::clone)).collect();
    if let Some(path) = ignore_file {
        ignored.extend(ignored_by(path)?);
    }
    for [first, second] in &ignored {
        let [a, b] = [named(first)?, named(second)?];
        ensure!(
            a.len() > 1 || a != b,
            "--ignore {first} {second}: that is one body, and two are needed"
        );
        for two in a.iter().flat_map(|&a| b.iter().map(move |&b| [a, b])) {
            if two[0] != two[1] {
                scene.ignore(ids[two[0]], ids[two[1]], true)?;
            }
        }
    }

    let is_f64 = scene.bodies().any(|body| body.model().is_f64());
    let of_hit =
        size_of::<SceneHit>() + if contacts { size_of::<(SceneHit, AnyContact)>() } else { 0 };
    let with_contacts: Vec<(SceneHit, AnyContact)> =
        shown("asking which bodies meet".to_owned(), || {
            scene.update()?;
            list_fits(scene.hits().len(), of_hit, reading)?;
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
    let is_clear = !listing.fail || scene.hits().is_empty();
    let found = Found {
        files: rows,
        origins: &origins,
        kind: if *bodies { Kind::Bodies } else { Kind::Scene },
        within: near.within,
        hits: match contacts {
            true => Box::new(with_contacts.iter().map(|(of, contact)| hit(of, Some(*contact)))),
            false => Box::new(scene.hits().iter().map(|of| hit(of, None))),
        },
    };
    let posed: Vec<_> = scene.bodies().map(|body| (body.model().mesh(), body.pose())).collect();
    found.write(listing, &posed)?;
    explain(executor, scene.plan());
    Ok(is_clear)
}

/// The bodies that the first two columns of a CSV file name, without its titles.
fn ignored_by(path: &Path) -> Result<Vec<[String; 2]>> {
    let named = || format!("cannot read {}", path.display());
    let mut file = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_path(path);
    let rows = file.as_mut().map_err(|error| anyhow!("{}: {error}", named()))?.records();
    let mut all = Vec::new();
    for row in rows {
        let row = row.with_context(named)?;
        match (row.get(0), row.get(1)) {
            (Some("body_a"), Some("body_b")) => {}
            (Some(a), Some(b)) => all.push([a.to_owned(), b.to_owned()]),
            _ => bail!("{}: a line does not name two bodies", path.display()),
        }
    }
    Ok(all)
}

/// The name of a file, with its folder if another of the files has the same.
pub(super) fn body_name(path: &Path, files: &[PathBuf]) -> String {
    let is_alike = |other: &&PathBuf| other.file_name() == path.file_name();
    let is_ambiguous = files.iter().filter(is_alike).any(|other| other != path);
    let name = path.file_name().filter(|_| !is_ambiguous).map(Path::new);
    name.unwrap_or(path).display().to_string()
}

/// Adds the bodies of a file, which has the name if it is one body; vertices of a body within a distance become one.
pub(super) fn split(
    loaded: Contents,
    path: &Path,
    name: String,
    file: usize,
    distance: Option<f64>,
    parts: &mut Vec<Part>,
) -> Result<Source> {
    let (mesh, source) = match loaded {
        Contents::Baked(bytes) => {
            parts.push(Part { name, model: baked(&bytes, path)?, file, triangles: None });
            return Ok(Source::default());
        }
        Contents::Mesh(MeshFile { mesh, source, .. }) => (mesh, source),
    };
    let mut push = |name: String, mut mesh: TriangleMesh, triangles| {
        let joined = distance.map_or(0, |distance| mesh.weld_within(distance));
        if joined > 0 {
            let body = format!("{}: {}", shown_path(path), escaped(&name));
            eprintln!("{body}: vertices that were joined with others nearby: {joined}");
        }
        parts.push(Part { name, model: built(mesh, path)?, file, triangles });
        anyhow::Ok(())
    };
    let bodies = source.bodies();
    if bodies.len() < 2 {
        push(name, mesh, None)?;
        return Ok(source);
    }
    for (name, triangles) in bodies.iter().zip(source.triangles(mesh.triangles.len())) {
        push(name.clone(), mesh.part(&triangles), Some(triangles))?;
    }
    Ok(source)
}
