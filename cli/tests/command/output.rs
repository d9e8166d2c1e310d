//! Where results go, and in what form.

use super::{command, folder, out, refused};
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Duration;

fn json(folder: &Path, arguments: &str) -> serde_json::Value {
    serde_json::from_str(&out(folder, &format!("{arguments} --json"))).unwrap()
}

#[test]
fn every_command_speaks_json() {
    let folder = folder();
    let at = folder.path();
    assert_eq!(json(at, "pairs a.obj b.obj")["pairs"][1], serde_json::json!([3, 0]));
    assert_eq!(json(at, "self a.obj")["pairs"], serde_json::json!([]));
    assert_eq!(json(at, "scene a.obj b.obj")["pairs"][1]["bodies"][1], "b.obj");
    assert_eq!(json(at, "any a.obj b.obj")["pair"][1], 0);
    let baked = json(at, "bake a.obj");
    assert_eq!(baked["bytes"]["all"], fs::metadata(at.join("a.pfb")).unwrap().len());
    assert_eq!(baked["counts"]["triangles"], 4);
    assert_eq!(json(at, "bench a.obj b.obj --frames 2")["frames"], 2);
    let no = command(at, "any a.obj b.obj --translate 9,9,9 --json").output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&no.stdout).unwrap();
    assert_eq!((no.status.code(), &json["pair"]), (Some(1), &serde_json::Value::Null));
    assert_eq!((&json["version"], &json["files"][0]["name"]), (&1.into(), &"a.obj".into()));
}

#[test]
fn curves_of_intersection() {
    let folder = folder();
    let at = folder.path();
    // The tetrahedron, cut by a plane of two triangles at z = 1/4 and by one that leaves it open.
    fs::write(at.join("plane.obj"), "v -9 -9 .25\nv 9 -9 .25\nv 9 9 .25\nv -9 9 .25\nf 1 2 3 4\n")
        .unwrap();
    assert_eq!(out(at, "pairs a.obj plane.obj --out curve.obj"), "1 polyline; see curve.obj\n");
    let curve = fs::read_to_string(at.join("curve.obj")).unwrap();
    let line: Vec<_> = curve.lines().last().unwrap().split(' ').collect();
    assert_eq!((line[0], line[1]), ("l", *line.last().unwrap()), "{curve}");
    // Three corners, and where the diagonal of the plane crosses: at the corner (0, 0) and the edge beyond.
    assert_eq!(curve.lines().filter(|line| line.starts_with("v ")).count(), 4, "{curve}");
    assert!(
        curve.lines().filter(|line| line.starts_with("v ")).all(|line| line.ends_with(" 0.25")),
        "{curve}"
    );
    // The blade enters by one face and leaves by another: two curves, neither closed.
    assert!(out(at, "pairs a.obj b.obj --out curve.obj").starts_with("2 polylines"));
    for options in ["--contacts", "--json", "--csv", "--source"] {
        for file in ["curve.obj", "hits.ply"] {
            let error = refused(at, &format!("pairs a.obj b.obj {options} --out {file}"));
            assert!(error.contains("is drawn"), "{error}");
        }
    }
}

#[test]
fn completions_know_the_commands() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = out(folder.path(), &format!("completions {shell}"));
        assert!(script.contains("scene") && script.contains("ignore"), "{shell}");
    }
}

#[test]
fn the_manual_has_every_command() {
    let folder = folder();
    let page = out(folder.path(), "man");
    for part in [".TH pfront", "PFRONT PAIRS", "PFRONT COMPLETIONS", "ignore", "Exit codes"] {
        assert!(page.contains(part), "no {part} in {page}");
    }
}

#[cfg(unix)]
#[test]
fn a_link_is_written_through() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("real.csv"), "old").unwrap();
    std::os::unix::fs::symlink(at.join("real.csv"), at.join("link.csv")).unwrap();
    out(at, "pairs a.obj b.obj --out link.csv");
    assert!(at.join("link.csv").symlink_metadata().unwrap().is_symlink());
    assert_eq!(fs::read_to_string(at.join("real.csv")).unwrap(), "a,b\n0,0\n3,0\n");
}

#[cfg(unix)]
#[test]
fn a_link_to_a_file_that_is_not_there_makes_it() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("sub")).unwrap();
    std::os::unix::fs::symlink("sub/real.csv", at.join("second.csv")).unwrap();
    std::os::unix::fs::symlink("second.csv", at.join("link.csv")).unwrap();
    out(at, "pairs a.obj b.obj --out link.csv");
    assert!(at.join("link.csv").symlink_metadata().unwrap().is_symlink());
    assert!(at.join("second.csv").symlink_metadata().unwrap().is_symlink());
    assert_eq!(fs::read_to_string(at.join("sub/real.csv")).unwrap(), "a,b\n0,0\n3,0\n");
    // Nor is a link replaced that leads nowhere, or to itself.
    for (target, link) in [("no/such/folder.csv", "nowhere.csv"), ("loop.csv", "loop.csv")] {
        std::os::unix::fs::symlink(target, at.join(link)).unwrap();
        refused(at, &format!("pairs a.obj b.obj --out {link}"));
        assert!(at.join(link).symlink_metadata().unwrap().is_symlink());
    }
}

/// A limit on the size of files, as a quota is, fails what writes and ends no process.
#[cfg(unix)]
#[test]
fn a_failed_write_leaves_nothing() {
    let folder = folder();
    let at = folder.path();
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(300);
    fs::write(at.join("many.obj"), faces).unwrap();
    let files = || fs::read_dir(at).unwrap().count();
    let before = files();
    for arguments in [
        "pairs many.obj many.obj --out all.csv",
        "pairs many.obj many.obj --out all.json",
        "pairs many.obj many.obj --out all.ply",
        "bake many.obj",
    ] {
        let caps = "ulimit -f 4 && exec \"$0\" \"$@\"";
        let run = std::process::Command::new("sh")
            .args(["-c", caps, env!("CARGO_BIN_EXE_pfront")])
            .args(arguments.split(' '))
            .current_dir(at)
            .output()
            .unwrap();
        let error = String::from_utf8(run.stderr).unwrap();
        let is_named = error.contains("cannot write") && error.contains("File too large");
        assert!(run.status.code() == Some(2) && is_named, "{arguments}: {error}");
        assert_eq!(files(), before, "{arguments}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    let folder = folder();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let run = command(folder.path(), "pairs a.obj b.obj").stdout(full).output().unwrap();
    let error = String::from_utf8(run.stderr).unwrap();
    assert!(
        run.status.code() == Some(2) && error.contains("standard output: No space left"),
        "{error}"
    );
}

/// The text of a run on standard error if that is a terminal, when standard input brings a mesh after so long.
#[cfg(unix)]
fn on_a_terminal(folder: &Path, wait: Duration) -> String {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let terminal = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let terminal = fs::File::options().read(true).write(true).open(terminal).unwrap();
    let mut asked = command(folder, "self -");
    let mut run = asked
        .env("TERM", "xterm")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(terminal)
        .spawn()
        .unwrap();
    let mut input = run.stdin.take().unwrap();
    std::thread::sleep(wait);
    input.write_all(super::TETRAHEDRON.as_bytes()).unwrap();
    drop(input);
    drop(asked);
    assert!(run.wait().unwrap().success());
    let mut said = Vec::new();
    // Fails once nobody holds the other end.
    let _ = fs::File::from(master).read_to_end(&mut said);
    String::from_utf8(said).unwrap()
}

#[cfg(unix)]
#[test]
fn a_terminal_shows_what_takes_more_than_a_second_and_nothing_else() {
    let folder = folder();
    let long = on_a_terminal(folder.path(), Duration::from_millis(2500));
    assert!(long.contains("reading -"), "{long:?}");
    assert_eq!(on_a_terminal(folder.path(), Duration::ZERO), "");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_half_written() {
    let folder = folder();
    let at = folder.path();
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(1500);
    fs::write(at.join("many.obj"), faces).unwrap();
    let mut asked = command(at, "pairs many.obj many.obj --contacts --out all.csv");
    let mut run = asked.stderr(Stdio::piped()).spawn().unwrap();
    let files =
        || fs::read_dir(at).unwrap().map(|file| file.unwrap().file_name()).collect::<Vec<_>>();
    let before = 3;
    while files().len() == before {
        assert!(run.try_wait().unwrap().is_none(), "it ended before it wrote anything");
        std::thread::sleep(Duration::from_millis(1));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(kill.unwrap().success());
    let Output { status, stderr, .. } = run.wait_with_output().unwrap();
    assert_eq!(status.code(), Some(130));
    assert_eq!(String::from_utf8(stderr).unwrap(), "interrupted; no file written\n");
    assert_eq!(files().len(), before, "{:?}", files());
}

#[test]
fn variables_that_choose_a_gpu_are_checked() {
    let folder = folder();
    for (name, value, part) in [
        (
            "WGPU_ADAPTER_NAME",
            "no such GPU",
            "no adapter matches WGPU_ADAPTER_NAME=no such GPU; there are ",
        ),
        ("WGPU_BACKEND", "nonsense", "nonsense names no backend; there are vulkan, metal and dx12"),
        ("WGPU_BACKEND", "gl", "WGPU_BACKEND=gl admits no other backend"),
    ] {
        for arguments in ["devices", "pairs a.obj b.obj --backend gpu"] {
            let run = command(folder.path(), arguments).env(name, value).output().unwrap();
            let error = String::from_utf8(run.stderr).unwrap();
            assert!(run.status.code() == Some(2) && error.contains(part), "{arguments}: {error}");
            assert!(!error.contains("Install"), "the variable is wrong, not the driver: {error}");
        }
    }
}
