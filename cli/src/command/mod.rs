//! The commands, a module for each. `Ok(false)` is only for a question whose answer is no.

pub(crate) mod any;
pub(crate) mod bake;
pub(crate) mod bench;
pub(crate) mod devices;
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
use pfront::{Model, TrianglePair};
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

/// Reads a mesh, welds it if asked to, and builds its BVH, unless it was baked with one. `inspect` sees the mesh as it
/// was read.
fn model(
    path: &Path,
    weld: bool,
    reading: &Reading,
    inspect: impl FnOnce(&TriangleMesh),
) -> Result<(Model, Source)> {
    shown(format!("reading {}", path.display()), || match read(path, reading)? {
        Contents::Baked(bytes) if !weld => Ok((baked(&bytes, path)?, Source::default())),
        contents => {
            let MeshFile { mesh, source, .. } = contents.into_mesh(path).map_err(advised)?;
            inspect(&mesh);
            let mesh = if weld { mesh.welded() } else { mesh };
            Ok((built(mesh, path, &source)?, source))
        }
    })
}

/// Reads the two meshes of a question, which the output must not replace.
fn two(meshes: &TwoMeshes, out: Option<&Path>) -> Result<[(Model, Source); 2]> {
    check_files(&[&meshes.a, &meshes.b], out)?;
    let read = |path: &Path| model(path, false, &meshes.reading, |_| ());
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

/// Builds a model, in f64 if f32 does not hold every coordinate. The error names the file, and the line of a coordinate that
/// is not finite.
fn built(mesh: TriangleMesh, path: &Path, source: &Source) -> Result<Model> {
    let model = if mesh.beyond_f32() > 0 {
        Model::from_f64(mesh.positions, mesh.triangles)
    } else {
        let TriangleMesh { positions, triangles } = mesh.into_f32();
        Model::new(positions, triangles)
    };
    model.map_err(|error| in_file(error.into(), path, source))
}

fn in_file(error: Error, path: &Path, source: &Source) -> Error {
    let path = path.display();
    match source.out_of_range {
        Some(line) => error.context(format!("{path}, line {line} (vertices count from 0)")),
        None => error.context(path.to_string()),
    }
}

/// Checks that a list of so many hits fits into memory, before it is asked for.
fn list_fits(hits: u64, bytes: usize, reading: &Reading) -> Result<()> {
    // A list grows to twice its length, while the old half is still there.
    let demand = usize::try_from(hits).unwrap_or(usize::MAX).saturating_mul(3 * bytes);
    fits(format!("{hits} pairs meet, whose list"), demand, reading)
}

/// Checks that what takes so many bytes fits into memory, before it is begun.
fn fits(what: String, demand: usize, reading: &Reading) -> Result<()> {
    let most = reading.memory.or_else(available).unwrap_or(usize::MAX);
    let megabytes = |bytes: usize| bytes.div_ceil(1_000_000);
    let has_room = || Vec::<u8>::new().try_reserve_exact(demand).is_ok();
    ensure!(
        demand <= most && has_room(),
        "{what} takes {} MB, and {} are allowed: see --memory",
        megabytes(demand),
        megabytes(most)
    );
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
