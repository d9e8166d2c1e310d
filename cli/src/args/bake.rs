//! What can be typed after `pfront bake`.

use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use pfront::core::bvh::MAX_LEAF_SIZE;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Bake {
    /// The mesh
    pub(crate) mesh: PathBuf,
    /// Where to [default: beside the mesh, as .pfb]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// How the BVH is built
    #[arg(long, value_enum, default_value_t = Build::Sah)]
    pub(crate) build: Build,
    /// The most triangles a leaf may hold
    #[arg(long, value_name = "N", default_value_t = MAX_LEAF_SIZE)]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=MAX_LEAF_SIZE as u64))]
    pub(crate) leaf_size: u32,
    /// First join vertices at exactly the same place; STL needs it, or neighbours count as contacts
    #[arg(long)]
    pub(crate) weld: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Build {
    /// With the surface area heuristic: walked fastest
    Sah,
    /// Along a Morton curve, as a device without much memory would
    Morton,
}
