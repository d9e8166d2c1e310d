//! The commands, a module for each. `Ok(false)` says that something was measured and found wrong.

pub(crate) mod chart;
pub(crate) mod judge;
pub(crate) mod profile;
pub(crate) mod record;
pub(crate) mod regret;
pub(crate) mod replay;

use indicatif::{ProgressBar, ProgressStyle};

/// Progress over frames or the like, on a terminal's standard error; elsewhere nothing.
fn progress(of: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(of);
    let template = format!("{{bar:40}} {what} {{human_pos}} of {{human_len}}, {{msg}}{{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar
}
