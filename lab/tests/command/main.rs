//! The command as a script sees it: standard output, standard error, exit codes.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod judge;
mod replay;

use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pfront-lab"));
    command.current_dir(folder).args(arguments.split_whitespace());
    // As on a machine where nobody is logged in, of which drivers would complain on standard error.
    command.env_remove("XDG_RUNTIME_DIR");
    command
}

/// Standard output of a run that must end well and say nothing else.
fn out(folder: &Path, arguments: &str) -> String {
    let Output { status, stdout, stderr } = command(folder, arguments).output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(status.success() && stderr.is_empty(), "pfront-lab {arguments}: {status}, {stderr}");
    String::from_utf8(stdout).unwrap()
}

/// Standard error of a run that must be refused.
fn refused(folder: &Path, arguments: &str) -> String {
    let Output { status, stderr, .. } = command(folder, arguments).output().unwrap();
    assert_eq!(status.code(), Some(2), "pfront-lab {arguments}");
    String::from_utf8(stderr).unwrap()
}

#[test]
fn refusals_say_what_and_where() {
    let folder = folder();
    let at = folder.path();
    std::fs::write(at.join("short.tcw"), b"TRICOLW1\0\0").unwrap();
    std::fs::write(at.join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(at.join("b.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 1\n").unwrap();
    std::fs::write(at.join("text"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for (arguments, part) in [
        ("replay short.tcw", "short.tcw: at byte 8"),
        ("profile short.tcw", "short.tcw: at byte 8"),
        ("regret short.tcw", "short.tcw: at byte 8"),
        ("replay text", "not a workload"),
        ("replay a.obj,b.obj", "a.obj,b.obj: not one mesh"),
        ("replay nothing", "built-in scenes: worm-gear"),
        ("replay a.obj --size 9", "--size is for built-in scenes"),
        ("record nothing x.tcw", "worm-gear"),
        ("chart no/such/folder.csv", "no/such/folder.csv"),
        ("replay sheet --threads 100000", "must be 1 to"),
        ("regret --threads 100000", "must be 1 to"),
        ("regret --rounds 0", "invalid value"),
    ] {
        let error = refused(at, arguments);
        assert!(error.contains(part), "no '{part}' in what 'pfront-lab {arguments}' said: {error}");
    }
}
