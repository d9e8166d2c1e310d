//! The options of studies, and of what else measures.

use crate::gpus::Gpus;
use crate::how::parse_threads;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser};
use clap::{Args, Subcommand};
use pfront_study::stability::ROWS;
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
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<NonZero<usize>>,
    /// Measure little, to see that it works
    #[arg(long)]
    pub(crate) quick: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Stability {
    /// Only these rows
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    #[arg(value_parser = PossibleValuesParser::new(ROWS.map(|row| row.name)))]
    pub(crate) row: Vec<String>,
    /// Numbers of workers
    #[arg(short, long, value_delimiter = ',', default_values_t = [1, 2, 7, 64, 1024])]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=65_536))]
    pub(crate) p: Vec<usize>,
    /// Shorter scenes, and a smaller twin
    #[arg(long)]
    pub(crate) quick: bool,
    /// Draw the frames, and time the schedules on all threads
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write one line for each frame
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Regret {
    /// What the cases are generated from
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) seed: u64,
    /// How many of them [default: 48, or 8]
    #[arg(long, value_name = "N")]
    pub(crate) cases: Option<NonZero<usize>>,
    /// How often everyone plays a case; short ones are played more often [default: 5, or 1]
    #[arg(long, value_name = "N")]
    pub(crate) rounds: Option<NonZero<usize>>,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<NonZero<usize>>,
    /// What else there is to choose from
    #[arg(long, value_enum, default_value_t = Gpus::Auto)]
    pub(crate) backend: Gpus,
    /// Write one line for each case
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Few and small cases, to see that it works
    #[arg(long)]
    pub(crate) quick: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Bench {
    /// Show where a GPU spends its time, and how long the CPU takes for the same frames
    ///
    /// Passes are timed on the device, frames from outside: from the question to the pairs in the memory of
    /// the host. A frame moves the objects (update: upload and refit where a mesh deforms) and asks (query).
    /// The answers are compared.
    Gpu(BenchGpu),
}

#[derive(Debug, Args)]
pub(crate) struct BenchGpu {
    /// Built-in scenes, or workloads (.tcw)
    #[arg(default_values_t = ["worm-gear", "torus-knots", "sheet"].map(str::to_owned))]
    pub(crate) workloads: Vec<String>,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    pub(crate) size: Option<usize>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// CPU threads to compare with, beside one [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<NonZero<usize>>,
    /// How many levels a pass descends [default: what suits the device]
    #[arg(long, value_name = "LEVELS")]
    pub(crate) depth: Option<u32>,
    /// Device memory for fronts and lists
    #[arg(long, value_name = "BYTES")]
    pub(crate) budget: Option<u64>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Draw the passes on top of each other
    #[arg(long, value_name = "FILE")]
    pub(crate) chart: Option<PathBuf>,
}
