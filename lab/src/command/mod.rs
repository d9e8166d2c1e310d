//! What each command does. `Ok(false)` says that something was measured and found wrong.

pub(crate) mod balance;
pub(crate) mod chart;
pub(crate) mod judge;
pub(crate) mod passes;
pub(crate) mod record;
pub(crate) mod regret;
pub(crate) mod replay;
pub(crate) mod stability;

use indicatif::{ProgressBar, ProgressStyle};

/// Progress over frames, on a terminal's standard error; elsewhere nothing.
fn progress(frames: u64) -> ProgressBar {
    let bar = ProgressBar::new(frames);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} frame {pos} of {len}, {eta} left") {
        bar.set_style(style);
    }
    bar
}
