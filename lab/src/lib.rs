//! Measurements of what pfront is worth: speed against accuracy of triangle tests, where frames spend their time, and the
//! regret of what an executor chooses.
//!
//! - [`workload`], [`pairs`]: recorded motion, and the answers to it, as files; [`recording`] plays them, built-in scenes and
//!   meshes.
//! - [`suite`]: triangle pairs with their truth, generated from a seed or harvested from the contacts of scenes.
//! - [`judge`]: how many answers of whom are wrong; [`chart`]: and how long they take.
//! - [`textbook`]: the triangle tests of the literature, as printed, to compare with.
//! - [`player`]: a query about a workload, whatever moves in it.

pub mod chart;
mod format;
pub mod judge;
pub mod pairs;
pub mod player;
pub mod recording;
pub mod suite;
pub mod textbook;
pub mod workload;

/// The middle one of some values, or of two the upper; sorts them.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
