//! A sign of life on a terminal.

use indicatif::ProgressBar;
use pfront_files::escape::escaped;
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// Shorter work shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(100);

/// Runs `work`, and says on a terminal what is being done if that takes more than a second.
pub(crate) fn shown<T>(what: String, work: impl FnOnce() -> T) -> T {
    if !stderr().is_terminal() {
        return work();
    }
    thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        scope.spawn(move || {
            if waiting.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                let spinner = ProgressBar::new_spinner().with_message(escaped(&what).into_owned());
                spinner.enable_steady_tick(TICK);
                // Ends when `done` is dropped.
                let _ = waiting.recv();
                spinner.finish_and_clear();
            }
        });
        let worked = work();
        drop(done);
        worked
    })
}
