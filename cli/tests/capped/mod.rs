//! Runs the command within bounds of time and memory, and tells a refusal from an answer.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;
use wait_timeout::ChildExt;

/// Longer, and it hangs.
const SECONDS: u64 = 30;
/// GiB of address space: a few times what the largest mesh here needs with two threads, far below what a
/// file can claim.
const GIB: u64 = 2;
/// A driver that computes on the CPU maps a lot more than it uses.
const GIB_WITH_DRIVER: u64 = 12;

/// Two threads: each maps an arena of its own.
pub(crate) const FEW: &str = "--threads 2";

/// Standard output of a run that answers with exit code 0 and no other word, or 1 and nothing wrong; or
/// the standard error of one that refuses, with 2.
///
/// # Panics
/// If it does neither, whatever that is: a panic, a signal, a hang.
pub(crate) fn run(folder: &Path, arguments: &str) -> Result<String, String> {
    let with_driver = ["gpu", "devices"].iter().any(|word| arguments.contains(word));
    run_within(folder, arguments, if with_driver { GIB_WITH_DRIVER } else { GIB } << 10)
}

/// [`run`] within so many MiB of address space.
pub(crate) fn run_within(folder: &Path, arguments: &str, mib: u64) -> Result<String, String> {
    // Not where the command may leave files.
    let words = TempDir::new().unwrap();
    let [out, err] = ["out", "err"].map(|name| words.path().join(name));
    let caps = format!("ulimit -v {} && ulimit -t {SECONDS} && exec \"$0\" \"$@\"", mib << 10);
    let mut child = Command::new("sh")
        .args(["-c", &caps, env!("CARGO_BIN_EXE_pfront")])
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .env_remove("XDG_RUNTIME_DIR")
        .stdin(Stdio::null())
        .stdout(File::create(&out).unwrap())
        .stderr(File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let ended = child.wait_timeout(Duration::from_secs(2 * SECONDS)).unwrap();
    if ended.is_none() {
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let [out, err] = [out, err].map(|path| fs::read(path).unwrap());
    let [out, err] = [out, err].map(|bytes| String::from_utf8(bytes).unwrap());
    match ended.and_then(|status| status.code()) {
        Some(0 | 1) if err.is_empty() => Ok(out),
        Some(2) if err.starts_with("error: ") => Err(err),
        _ => panic!("pfront {arguments}: {ended:?}, {err}"),
    }
}
