//! Bakes a mesh for the firmware, and lays out what is built for the device.

use pfront_core::bvh::node_bound;
use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
use pfront_core::{Mesh, Node};
use std::error::Error;
use std::path::Path;

#[path = "src/shape.rs"]
mod shape;

/// How much the tube swells and shrinks.
const BUMP: f32 = 0.3;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=src/shape.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    bake(&Path::new(&std::env::var("OUT_DIR")?).join("beads.pfb"))
}

/// As `pfront bake --build morton` does with a mesh file.
fn bake(path: &Path) -> Result<(), Box<dyn Error>> {
    const N: usize = shape::TRIANGLES;
    let (positions, triangles) = (shape::ring(BUMP), shape::grid());
    let mesh = Mesh::new(&positions, &triangles)?;
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(N)], vec![0; N]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let mut scratch = vec![0; 2 * N];
    let bvh = morton(mesh, &BuildOptions::default(), storage, &mut scratch)?;
    let mut bytes = vec![0; pfront_blob::Counts::of(&bvh).bytes()];
    Ok(std::fs::write(path, pfront_blob::write(&bvh, &mut bytes)?)?)
}
