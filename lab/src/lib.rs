//! Measurements of what pfront is worth: speed against accuracy, stability where methods fail, and the regret of plans.
//!
//! - [`workload`], [`pairs`]: recorded motion, and the answers to it, as files.
//! - [`recorded`]: recorded meshes in contact.
//! - [`suite`]: triangle pairs with their truth, generated from a seed or harvested from real contacts, as a
//!   file that any implementation can be judged by.
//! - [`chart`]: speed against accuracy of the test of pfront, of inexact ones and of the textbook.
//! - [`judge`]: how many answers of whom are wrong.
//! - [`textbook`]: the triangle tests of the literature, as printed, to compare with.
//! - [`player`]: a query about a workload, whatever moves in it.
//! - [`regret`]: what a plan costs that was chosen, against the best of all fixed ones.
//! - [`stability`]: scenes in which a p-partition front could fail, and the paper's equations as printed.

pub mod chart;
mod format;
pub mod judge;
pub mod pairs;
pub mod player;
pub mod plot;
pub mod recorded;
pub mod recording;
pub mod regret;
pub mod stability;
pub mod suite;
pub mod tally;
pub mod textbook;
pub mod workload;

/// The middle one of some values, or of two the upper; sorts them.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
