//! What can be typed.

mod bake;
mod study;

pub(crate) use bake::{Bake, Build};
pub(crate) use study::{Bench, BenchGpu, Chart, Judge, Regret, Stability};

use crate::how::How;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use pfront::Pose;
use pfront_scenes::Scene;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  pfront                                          the built-in demonstration
  pfront pairs a.obj b.stl --translate 0.1,0,0    every intersecting triangle pair
  pfront pairs a.obj b.stl --out hits.ply         the same, to look at
  pfront any a.obj b.stl && echo they touch
  pfront self cloth.ply --format csv > folds.csv
  pfront bake gear.obj && pfront self gear.pfb    with the BVH that was built once
  pfront record epicyclic gears.tcw && pfront replay gears.tcw --pairs gears.tcp

Exit codes:
  0  done; for any: something meets
  1  for any: nothing meets; for stability: a row fails
  2  the command line or a file was refused; standard error says why";

/// Every intersecting triangle pair of two meshes, or within one, exactly
#[derive(Debug, Parser)]
#[command(name = "pfront", version, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the triangle pairs of two meshes that meet
    Pairs {
        #[command(flatten)]
        meshes: TwoMeshes,
        #[command(flatten)]
        listing: Listing,
        #[command(flatten)]
        how: How,
    },
    /// Say whether two meshes meet, and name one pair of triangles; exit code 1 if they do not
    Any {
        #[command(flatten)]
        meshes: TwoMeshes,
        #[command(flatten)]
        how: How,
    },
    /// List the triangle pairs within one mesh that meet
    #[command(name = "self")]
    Within(Within),
    /// Run a recorded workload; prints tab-separated lines
    ///
    /// BUILD ms; FRAME number update_ms query_ms pairs (with --mode any: 1 or 0); at the end RSS bytes, the
    /// most memory the process had. `update` is moving the objects and refitting, `query` is the rest.
    Replay(Replay),
    /// Write a built-in scene as a workload
    Record(Record),
    /// Write a mesh with its BVH as one blob, for programs and firmware to borrow
    ///
    /// Wherever a mesh is read, a baked one is too. Prints the bytes of each section.
    Bake(Bake),
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
    /// Measure a backend
    Bench {
        #[command(subcommand)]
        what: Bench,
    },
    /// List what a GPU query could run on, and which it would
    Devices {
        /// Print one JSON array
        #[arg(long)]
        json: bool,
    },
}

#[derive(Debug, Args)]
pub(crate) struct TwoMeshes {
    /// The first mesh: obj, ply, stl, off, gltf, glb, or pfb from bake
    pub(crate) a: PathBuf,
    /// The second mesh
    pub(crate) b: PathBuf,
    /// Pose of B in the frame of A: 12 numbers, a 3×4 matrix row by row
    #[arg(long, value_name = "M", allow_hyphen_values = true, conflicts_with_all = ["translate", "rotate"])]
    #[arg(value_parser = numbers::<12>)]
    pose: Option<[f32; 12]>,
    /// Move B
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    translate: Option<[f32; 3]>,
    /// First turn B about an axis through its origin, in degrees
    #[arg(long, value_name = "X,Y,Z,DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = numbers::<4>)]
    rotate: Option<[f32; 4]>,
}

impl TwoMeshes {
    /// `a_from_b`; an axis of length 0 does not turn.
    pub(crate) fn a_from_b(&self) -> Pose {
        if let Some(m) = self.pose {
            return Pose::new([0, 4, 8].map(|i| [m[i], m[i + 1], m[i + 2], m[i + 3]]));
        }
        let [x, y, z, degrees] = self.rotate.unwrap_or_default().map(f64::from);
        let axis = glam::DVec3::new(x, y, z).normalize_or_zero();
        let turn = glam::DQuat::from_scaled_axis(axis * degrees.to_radians());
        let [tx, ty, tz] = self.translate.unwrap_or_default();
        let matrix = glam::DMat3::from_quat(turn).as_mat3();
        let row = |i: usize, t: f32| [matrix.col(0)[i], matrix.col(1)[i], matrix.col(2)[i], t];
        Pose::new([row(0, tx), row(1, ty), row(2, tz)])
    }
}

/// Numbers between commas.
fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let parsed = text.split(',').map(|part| match part.trim().parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("'{part}' is not a finite number")),
    });
    let parsed: Vec<f32> = parsed.collect::<Result<_, _>>()?;
    let found = parsed.len();
    parsed.try_into().map_err(|_| format!("needs {N} numbers, separated by commas, not {found}"))
}

#[derive(Debug, Args)]
pub(crate) struct Within {
    /// The mesh
    pub(crate) mesh: PathBuf,
    /// First join vertices at exactly the same place; STL needs it, or neighbours count as contacts
    #[arg(long)]
    pub(crate) weld: bool,
    /// Leave out every pair that shares a vertex
    #[arg(long)]
    pub(crate) skip_neighbours: bool,
    #[command(flatten)]
    pub(crate) listing: Listing,
    #[command(flatten)]
    pub(crate) how: How,
}

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// The workload (.tcw), or the name of a built-in scene
    pub(crate) file: String,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    pub(crate) size: Option<usize>,
    /// Find all pairs of a frame, or stop at the first
    #[arg(long, value_enum, default_value_t = Mode::All)]
    pub(crate) mode: Mode,
    /// Write the pairs of every frame here
    #[arg(long, value_name = "FILE")]
    pub(crate) pairs: Option<PathBuf>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    #[command(flatten)]
    pub(crate) how: How,
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
pub(crate) struct Listing {
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    pub(crate) format: Format,
    /// Also where they meet: a segment and the normals of both triangles, in the frame of A
    #[arg(long)]
    pub(crate) contacts: bool,
    /// Print into a file; one that ends in .ply gets the meshes, with the triangles that meet in red
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

impl Listing {
    /// Where a picture is asked for.
    pub(crate) fn picture(&self) -> Option<&Path> {
        let is_ply = |path: &&Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
        self.out.as_deref().filter(is_ply)
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Format {
    /// Aligned columns, then the number of pairs
    Table,
    /// One object: pairs, or contacts
    Json,
    /// Comma-separated, with a line of names
    Csv,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Mode {
    All,
    Any,
}
