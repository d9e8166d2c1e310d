//! The meshes that move, and where to.

use super::{Reading, matrix, near, numbers, rows_of};
use clap::Args;
use pfront::Pose64;
use pfront_cli::executor::ExecutorArgs;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Impacts {
    /// The first mesh at time 0
    pub(crate) a: PathBuf,
    /// The second; without it, the first is asked about itself
    pub(crate) b: Option<PathBuf>,
    /// The first mesh at time 1, with the same triangles; without it, it stays
    #[arg(long, value_name = "FILE")]
    pub(crate) end_a: Option<PathBuf>,
    /// The second mesh at time 1
    #[arg(long, value_name = "FILE", requires = "b", conflicts_with_all = ["pose_end", "translate_end"])]
    pub(crate) end_b: Option<PathBuf>,
    /// Pose of the second mesh at time 1: 12 numbers separated by commas, a 3×4 matrix row by row
    #[arg(
        long,
        value_name = "M",
        allow_hyphen_values = true,
        requires = "b",
        conflicts_with = "translate_end"
    )]
    #[arg(value_parser = matrix)]
    pose_end: Option<[f64; 12]>,
    /// Move the second mesh by this until time 1
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "b")]
    #[arg(value_parser = numbers::<3>)]
    translate_end: Option<[f64; 3]>,
    /// Only the pair that meets first
    #[arg(long)]
    pub(crate) first: bool,
    /// Only some pair, and stop at the first that certainly meets; executors may find different ones
    #[arg(long, conflicts_with = "first")]
    pub(crate) any: bool,
    /// Only how many pairs meet: from how many certainly do to how many do or are open
    #[arg(long, conflicts_with_all = ["first", "any"])]
    pub(crate) count: bool,
    /// Ask for pairs that come at most so far apart on the way in place of those that meet; rounded up to f32, so that no pair is missed.
    /// Triangles of one mesh that share a vertex are decided as without
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, value_parser = near)]
    pub(crate) within: Option<f32>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) executor: ExecutorArgs,
}

impl Impacts {
    /// The pose of the second mesh at time 1.
    pub(crate) fn pose(&self) -> Pose64 {
        let [x, y, z] = self.translate_end.unwrap_or_default();
        let m = self.pose_end.unwrap_or([1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z]);
        Pose64::new(rows_of(m))
    }
}
