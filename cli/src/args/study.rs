//! The options of studies.

use clap::Args;
use std::num::NonZero;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Judge {
    /// Triangle pairs with their truth, as --out writes them
    pub(crate) file: Option<PathBuf>,
    /// Somebody's answers to the file, a byte for each pair: 1 if they meet, else 0 [default: ours]
    #[arg(long, value_name = "FILE", requires = "file")]
    pub(crate) answers: Option<PathBuf>,
    /// How many pairs to generate, equally many of each set
    #[arg(long, value_name = "N", default_value_t = 1_000_000, conflicts_with = "file")]
    pub(crate) pairs: u64,
    /// What they are generated from
    #[arg(long, value_name = "SEED", default_value_t = 1, conflicts_with = "file")]
    pub(crate) seed: u64,
    /// Write them here, with their truth
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub(crate) out: Option<PathBuf>,
    /// Ask a GPU too
    #[arg(long, conflicts_with = "answers")]
    pub(crate) gpu: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Chart {
    /// The folder to write into
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: PathBuf,
    /// How many triangle pairs of all sets together [default: 4 million, or 80,000]
    #[arg(long, value_name = "N")]
    pub(crate) pairs: Option<u64>,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    pub(crate) size: Option<usize>,
    /// What is random is generated from this
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) seed: u64,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZero<usize>>,
    /// Measure little, to see that it works
    #[arg(long)]
    pub(crate) quick: bool,
}
