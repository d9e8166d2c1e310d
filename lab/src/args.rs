//! What can be typed.

use crate::command::passes::Passes;
use crate::command::replay::Replay;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use pfront_cli::executor::{Backend, parse_threads};
use pfront_lab::stability::ROWS;
use pfront_testkit::scenes::Scene;
use std::num::NonZero;
use std::path::PathBuf;

/// Measures pfront: speed against accuracy, balance, stability, and the regret of choices
#[derive(Debug, Parser)]
#[command(name = "pfront-lab", version)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a recorded workload; prints tab-separated lines
    ///
    /// BUILD ms cpu_ms; FRAME number update_ms query_ms pairs update_cpu_ms query_cpu_ms (with --mode any, pairs is 1 or
    /// 0); at the end RSS and the most bytes of memory that the process had. `update` is moving the objects and
    /// refitting, `query` is the rest; `cpu` is the time of all threads.
    Replay(Replay),
    /// Write a built-in scene as a workload
    Record(Record),
    /// Show how evenly p-partition fronts divide the work, for any number of workers
    ///
    /// Work is counted in box and triangle tests, not timed (but for the share of time that the front takes),
    /// so that the figures mean the same on every machine and p may be larger than its number of cores.
    Balance(Balance),
    /// Count wrong answers to triangle pairs whose truth is known
    ///
    /// Without a file, pairs are generated: random, nearly touching, coplanar, degenerate, of every scale, and
    /// harvested from meshes in contact. Exit code 1 if an answer is wrong that promises not to be.
    Judge(Judge),
    /// Chart speed against accuracy, of all that pfront offers and of tests from the literature
    ///
    /// Writes pairs.svg, contacts.svg, frames.svg and pareto.csv, for slow slides through contact flips.svg and
    /// flips.csv, and prints what Exact costs. With the meshes of the folder that PFRONT_DATA names, if it does.
    Chart(Chart),
    /// Show that fronts divide work evenly where they could fail, beside the paper's equations as printed
    ///
    /// Each row of the matrix plays its scenes with every number of workers; answers are compared with those of
    /// one core, small ones with an exact oracle too. Prints the figure nearest to its limit, or farthest
    /// beyond, in counted work; exit code 1 if one of pfront's own is beyond.
    Stability(Stability),
    /// Measure what --backend auto costs, against the best of all plans that never change
    ///
    /// Cases are generated from a seed, from one triangle to three million and from two bodies to ten thousand;
    /// everyone plays each of them in turn, and answers are compared. A/A is how far a plan is from itself.
    Regret(Regret),
    /// Show where a GPU spends its time: the median of each pass, by the device's own clock
    Passes(Passes),
}

#[derive(Debug, Args)]
pub(crate) struct Record {
    /// The scene
    #[arg(value_parser = PossibleValuesParser::new(Scene::NAMES))]
    pub(crate) scene: String,
    /// Where to
    pub(crate) file: PathBuf,
    /// About so many triangles, instead of the scene's own number
    #[arg(long, value_name = "TRIANGLES")]
    pub(crate) size: Option<usize>,
    /// So many frames, instead of the scene's own number
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
}

#[derive(Debug, Args)]
pub(crate) struct Balance {
    /// The name of a built-in scene, or a workload (.tcw)
    pub(crate) scene: String,
    /// Numbers of workers
    #[arg(short, long, value_delimiter = ',', default_values_t = [1, 2, 4, 8, 16, 32, 64])]
    #[arg(value_parser = RangedU64ValueParser::<usize>::new().range(1..=65_536))]
    pub(crate) p: Vec<usize>,
    /// Triangles of a built-in scene, several to compare
    #[arg(long, value_name = "TRIANGLES", value_delimiter = ',')]
    pub(crate) size: Vec<usize>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// Divide each frame as if it were the first
    #[arg(long)]
    pub(crate) no_coherence: bool,
    /// Beside it Algorithm 1, which knows the true costs: slow
    #[arg(long)]
    pub(crate) reference: bool,
    /// A table of all frames together, or one line for each frame
    #[arg(long, value_enum, default_value_t = BalanceFormat::Table)]
    pub(crate) format: BalanceFormat,
    /// Draw the charts of the paper
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BalanceFormat {
    Table,
    Csv,
}

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
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(crate) backend: Backend,
    /// Write one line for each case
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Few and small cases, to see that it works
    #[arg(long)]
    pub(crate) quick: bool,
}
