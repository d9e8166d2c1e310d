//! `pfront bake MESH`

use crate::args::{Bake, Build};
use anyhow::{Context, Result};
use pfront::core::blob::{self, Counts};
use pfront::core::bvh::node_bound;
use pfront::core::bvh::{self, BuildOptions, BvhStorage};
use pfront::{Mesh, Node, threads};
use pfront_cli::mesh::{self, MeshData};
use pfront_cli::output::{Draft, out};
use std::io::Write;
use std::path::Path;

pub(crate) fn run(bake: &Bake) -> Result<bool> {
    let named = || bake.mesh.display().to_string();
    let mesh = mesh::read(&bake.mesh)?;
    let mesh = if bake.weld { mesh.welded() } else { mesh };
    let (bytes, counts) = baked(&mesh, bake).with_context(named)?;
    let here = || Path::new(bake.mesh.file_name().unwrap_or_default()).with_extension("pfb");
    let path = bake.out.clone().unwrap_or_else(here);
    let mut to = Draft::new(&path)?;
    to.write_all(&bytes).with_context(|| format!("cannot write {}", path.display()))?;
    to.finish()?;

    let Counts { nodes, vertices, triangles } = counts;
    let mut out = out();
    writeln!(
        out,
        "{}: {triangles} triangles, {vertices} vertices, {nodes} nodes; see {}",
        bake.mesh.display(),
        path.display()
    )?;
    let header = Counts { nodes: 0, vertices: 0, triangles: 0 }.bytes();
    for (section, bytes) in [
        ("header", header),
        ("nodes", nodes * size_of::<Node>()),
        ("positions", vertices * size_of::<[f32; 3]>()),
        ("triangles", triangles * size_of::<[u32; 3]>()),
        ("order", triangles * size_of::<u32>()),
        ("all", bytes.len()),
    ] {
        let each = bytes as f64 / triangles as f64;
        writeln!(out, "  {section:<9} {bytes:>11} bytes {each:>7.1} per triangle")?;
    }
    Ok(true)
}

fn baked(mesh: &MeshData, bake: &Bake) -> Result<(Vec<u8>, Counts)> {
    let mesh = Mesh::new(&mesh.positions, &mesh.triangles)?;
    let n = mesh.triangles().len();
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
    let mut bytes = vec![0; counts.bytes()];
    blob::write(&bvh, &mut bytes)?;
    Ok((bytes, counts))
}
