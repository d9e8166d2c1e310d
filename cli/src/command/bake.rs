//! `pfront bake MESH`

use super::{advised, check_files, fits};
use crate::args::{Bake, Build};
use anyhow::{Context, Result, ensure};
use pfront::pfront_blob::{self, Counts};
use pfront::pfront_core::bvh::node_bound;
use pfront::pfront_core::bvh::{self, BuildOptions, BvhStorage};
use pfront::{Mesh, Node, threads};
use pfront_cli::json::{VERSION as JSON, write_json};
use pfront_cli::output::{Draft, out};
use pfront_files::escape::shown_path;
use pfront_files::{MeshFile, TriangleMesh};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

pub(crate) fn run(bake: &Bake) -> Result<bool> {
    let here = || Path::new(bake.mesh.file_name().unwrap_or_default()).with_extension("pfb");
    let path = bake.out.clone().unwrap_or_else(here);
    ensure!(path != Path::new("-"), "--out - is no file: bake writes one");
    check_files(&[&bake.mesh], Some(&path))?;
    let mesh = super::read(&bake.mesh, &bake.reading)?;
    let MeshFile { mesh, .. } = mesh.into_mesh(&bake.mesh).map_err(advised)?;
    let (bytes, counts) = baked(mesh, bake).with_context(|| shown_path(&bake.mesh))?;
    let mut to = Draft::new(&path)?;
    to.write_all(&bytes).with_context(|| format!("cannot write {}", path.display()))?;
    to.finish()?;

    let Counts { nodes, vertices, triangles, positions_f64 } = counts;
    let header = Counts { nodes: 0, vertices: 0, triangles: 0, positions_f64: 0 }.bytes();
    let mut sections = vec![
        ("header", header),
        ("nodes", nodes * size_of::<Node>()),
        ("positions", vertices * size_of::<[f32; 3]>()),
        ("triangles", triangles * size_of::<[u32; 3]>()),
        ("order", triangles * size_of::<u32>()),
    ];
    if positions_f64 > 0 {
        sections.push(("in f64", (1 + positions_f64) * size_of::<[f64; 3]>()));
    }
    sections.push(("all", bytes.len()));
    let mut out = out();
    if bake.json {
        let bytes: BTreeMap<_, _> = sections.into_iter().collect();
        let counts = json!({ "triangles": triangles, "vertices": vertices, "nodes": nodes });
        let file = path.to_string_lossy();
        write_json(
            &mut out,
            &json!({ "version": JSON, "file": file, "counts": counts, "bytes": bytes }),
        )?;
        return Ok(true);
    }
    writeln!(
        out,
        "{}: {triangles} triangles, {vertices} vertices, {nodes} nodes; see {}",
        shown_path(&bake.mesh),
        shown_path(&path)
    )?;
    for (section, bytes) in sections {
        let each = bytes as f64 / triangles as f64;
        writeln!(out, "  {section:<9} {bytes:>11} bytes {each:>7.1} per triangle")?;
    }
    Ok(true)
}

fn baked(file: TriangleMesh, bake: &Bake) -> Result<(Vec<u8>, Counts)> {
    let (positions, in_f32, mut shadow);
    let mesh = if file.beyond_f32() > 0 {
        shadow = vec![[0.0; 3]; file.positions.len()];
        positions = file;
        Mesh::from_f64(&positions.positions, &positions.triangles, &mut shadow)?
    } else {
        in_f32 = file.into_f32();
        Mesh::new(&in_f32.positions, &in_f32.triangles)?
    };
    let n = mesh.triangles().len();
    let scratch =
        n * if bake.build == Build::Sah { size_of::<Node>() } else { 2 * size_of::<u32>() };
    let arrays = node_bound(n) * size_of::<Node>() + n * size_of::<u32>();
    let has_room = |more| fits(format!("baking {n} triangles"), arrays + more, &bake.reading);
    has_room(scratch)?;
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let options = BuildOptions { leaf_size: bake.leaf_size, join: Some(&threads::join) };
    let bvh = match bake.build {
        Build::Sah => {
            let mut scratch = vec![Node::EMPTY; n];
            bvh::sah(mesh, &options, storage, &mut scratch)
        }
        Build::Morton => {
            let mut scratch = vec![0; 2 * n];
            bvh::morton(mesh, &options, storage, &mut scratch)
        }
    }?;
    let counts = Counts::of(&bvh);
    has_room(counts.bytes())?;
    let mut bytes = vec![0; counts.bytes()];
    pfront_blob::write(&bvh, &mut bytes)?;
    Ok((bytes, counts))
}
