//! The commands, a module for each. `Ok(false)` is only for a question whose answer is no.

pub(crate) mod any;
pub(crate) mod bake;
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod devices;
pub(crate) mod distance;
pub(crate) mod impacts;
mod knot;
pub(crate) mod pairs;
pub(crate) mod scene;
pub(crate) mod self_collision;

use crate::args::{Reading, TwoMeshes};
use crate::curve::AnyContact;
use crate::listing::Hit;
use crate::progress::shown;
use anyhow::{Context, Error, Result, anyhow, ensure};
use pfront::executor::{Plan, Reason};
use pfront::pfront_core::bvtt::Query;
use pfront::{Mesh, Model, TrianglePair};
use pfront_cli::executor::ExecutorArgs;
use pfront_files::escape::{escaped, shown_path};
use pfront_files::{Contents, MeshFile, ReadError, Remedy, Source, TriangleMesh, available, open};
use std::path::Path;

/// Checks that at most one of the meshes is standard input, and that the output replaces none of them.
fn check_files(meshes: &[&Path], out: Option<&Path>) -> Result<()> {
    let is_stdin = |path: &&&Path| **path == Path::new("-");
    ensure!(
        meshes.iter().filter(is_stdin).count() <= 1,
        "- is given twice: standard input can be only one of the meshes"
    );
    let Some(target) = out.and_then(|out| out.canonicalize().ok()) else { return Ok(()) };
    // A link to the file that a shell redirects, where there is such a link.
    let stdin = Path::new("/dev/stdin");
    let mut files = meshes.iter().map(|path| if is_stdin(&path) { stdin } else { path });
    ensure!(
        !files.any(|path| path.canonicalize().is_ok_and(|path| path == target)),
        "the output {} would replace a mesh that is read: choose another name",
        target.display()
    );
    Ok(())
}

/// Reads a mesh and builds its BVH, unless it was baked with one.
fn model(path: &Path, reading: &Reading) -> Result<(Model, Source)> {
    shown(format!("reading {}", path.display()), || match read(path, reading)? {
        Contents::Baked(bytes) => Ok((baked(&bytes, path)?, Source::default())),
        Contents::Mesh(MeshFile { mesh, source, .. }) => Ok((built(mesh, path)?, source)),
    })
}

/// Reads the two meshes of a question, which the output must not replace.
fn two(meshes: &TwoMeshes, out: Option<&Path>) -> Result<[(Model, Source); 2]> {
    check_files(&[&meshes.a, &meshes.b], out)?;
    let read = |path: &Path| model(path, &meshes.reading);
    Ok([read(&meshes.a)?, read(&meshes.b)?])
}

/// Reads a mesh file, whose notes go to standard error.
fn read(path: &Path, reading: &Reading) -> Result<Contents> {
    let contents = open(path, &reading.options()).map_err(advised)?;
    if let Contents::Mesh(MeshFile { notes, .. }) = &contents {
        let path = shown_path(path);
        notes.iter().for_each(|note| eprintln!("{path}: {}", escaped(note)));
    }
    Ok(contents)
}

/// The error with the option that may help.
fn advised(error: ReadError) -> Error {
    let advice = match error.remedy() {
        None => return error.into(),
        Some(Remedy::Format) => "see --input-format if its format is another",
        Some(Remedy::Memory) => "--memory lets it take more",
        Some(Remedy::OutsideFiles) => "see --allow-outside-files",
    };
    anyhow!("{error}; {advice}")
}

/// A baked model.
fn baked(bytes: &[u8], path: &Path) -> Result<Model> {
    Model::from_blob(bytes).with_context(|| shown_path(path))
}

/// Builds a model, in f64 if f32 does not hold every coordinate.
fn built(mesh: TriangleMesh, path: &Path) -> Result<Model> {
    let model = if mesh.beyond_f32() > 0 {
        Model::from_f64(mesh.positions, mesh.triangles)
    } else {
        let TriangleMesh { positions, triangles } = mesh.into_f32();
        Model::new(positions, triangles)
    };
    model.with_context(|| path.display().to_string())
}

/// Checks that a list of so many hits, which is there already, takes no more memory than is allowed.
fn list_fits(hits: usize, bytes: usize, reading: &Reading) -> Result<()> {
    let Some(most) = reading.memory else { return Ok(()) };
    // A list grows to twice its length, while the old half is still there.
    let demand = hits.saturating_mul(3 * bytes);
    ensure!(demand <= most, too_much(&format!("{hits} pairs meet, whose list"), demand, most));
    Ok(())
}

fn too_much(what: &str, demand: usize, most: usize) -> String {
    let [demand, most] = [demand, most].map(|bytes| bytes.div_ceil(1_000_000));
    format!("{what} takes {demand} MB, and {most} are allowed: see --memory")
}

/// Checks that what takes so many bytes fits into memory, before it is begun.
fn fits(what: String, demand: usize, reading: &Reading) -> Result<()> {
    let most = reading.memory.or_else(available).unwrap_or(usize::MAX);
    let has_room = || Vec::<u8>::new().try_reserve_exact(demand).is_ok();
    ensure!(demand <= most && has_room(), too_much(&what, demand, most));
    Ok(())
}

/// The triangles of a pair as a hit, with their contact if the listing needs it. A pair that is only near, as other
/// accuracies than exact report, has no contact, and is then none to list.
fn hits<'f>(
    pairs: &'f [TrianglePair],
    origins: [usize; 2],
    contacts: bool,
    is_f64: bool,
    query: &'f impl Query,
) -> Box<dyn Iterator<Item = Hit> + 'f> {
    let hit = move |&pair| {
        let contact = match (contacts, is_f64) {
            (false, _) => None,
            (true, false) => Some(AnyContact::F32(query.contact(pair)?)),
            (true, true) => Some(AnyContact::F64(query.contact_f64(pair)?)),
        };
        Some(Hit { origins, pair, contact })
    };
    Box::new(pairs.iter().filter_map(hit))
}

/// Says on standard error who has answered, and why, if there was a choice.
fn explain(executor: &ExecutorArgs, plan: Option<&Plan>) {
    if let Some(plan) = plan.filter(|plan| executor.is_auto() || plan.reason == Reason::CpuOnly) {
        match plan.reason {
            Reason::NoChoice => eprintln!("{}: there is no GPU to choose", plan.backend),
            _ => eprintln!("{}", escaped(&plan.to_string())),
        }
    }
}

/// How many pairs of triangles share a position, and no vertex.
fn unshared(mesh: Mesh<'_>, pairs: &[TrianglePair]) -> usize {
    let triangles = mesh.triangles();
    let place = |v: u32| match mesh.positions_f64() {
        Some(positions) => positions[v as usize],
        None => mesh.shadow()[v as usize].map(f64::from),
    };
    let is_unshared = |pair: &&TrianglePair| {
        let [a, b] = [pair.a, pair.b].map(|t| triangles[t as usize]);
        a.iter().all(|v| !b.contains(v)) && {
            let [a, b] = [a, b].map(|t| t.map(place));
            a.iter().any(|p| b.contains(p))
        }
    };
    pairs.iter().filter(is_unshared).count()
}
