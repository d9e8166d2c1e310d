//! The command as a script sees it: standard output, standard error, exit codes.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "command/bake.rs"]
mod bake;
#[path = "command/check.rs"]
mod check;
#[path = "command/gpu.rs"]
mod gpu;
#[path = "command/impacts.rs"]
mod impacts;
#[path = "command/input.rs"]
mod input;
#[path = "command/names.rs"]
mod names;
#[path = "command/output.rs"]
mod output;
#[path = "command/outside.rs"]
mod outside;
#[path = "command/scene.rs"]
mod scene;
#[path = "command/within.rs"]
mod within;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
/// Pierces the faces x + y + z = 1 and z = 0 of the tetrahedron.
const BLADE: &str = "v 0.2 0.2 -1\nv 0.2 0.3 -1\nv 0.2 0.2 3\nf 1 2 3\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), TETRAHEDRON).unwrap();
    fs::write(folder.path().join("b.obj"), BLADE).unwrap();
    folder
}

fn pfront(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().unwrap()
}

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pfront"));
    command.current_dir(folder).args(arguments.split_whitespace());
    // As on a machine where nobody is logged in, of which drivers would complain on standard error.
    command.env_remove("XDG_RUNTIME_DIR");
    command
}

/// Standard output of a run that must end well and say nothing else.
fn out(folder: &Path, arguments: &str) -> String {
    let Output { status, stdout, stderr } = pfront(folder, arguments);
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(status.success() && stderr.is_empty(), "pfront {arguments}: {status}, {stderr}");
    String::from_utf8(stdout).unwrap()
}

/// Standard error of a run that must be refused and print nothing.
fn refused(folder: &Path, arguments: &str) -> String {
    let Output { status, stdout, stderr } = pfront(folder, arguments);
    assert_eq!(status.code(), Some(2), "pfront {arguments}");
    assert!(stdout.is_empty(), "pfront {arguments}");
    String::from_utf8(stderr).unwrap()
}

#[test]
fn the_demonstration() {
    let folder = folder();
    let help = out(folder.path(), "");
    assert!(help.contains("pfront demo") && help.contains("Exit codes"), "{help}");
    let text = out(folder.path(), "demo");
    for part in ["129600 triangles, 120 frames", "3772 to 5376 pairs", "MiB", "one thread"] {
        assert!(text.contains(part), "no '{part}' in:\n{text}");
    }
}

#[test]
fn pairs_in_every_format() {
    let folder = folder();
    let at = folder.path();
    assert_eq!(
        out(at, "pairs a.obj b.obj"),
        "         a          b\n         0          0\n         3          0\n2 pairs\n"
    );
    assert_eq!(out(at, "pairs a.obj b.obj --csv"), "a,b\n0,0\n3,0\n");
    let json = "{\"version\":1,\"files\":[{\"name\":\"a.obj\",\"vertices\":4,\"triangles\":4},\
        {\"name\":\"b.obj\",\"vertices\":3,\"triangles\":1}],\"pairs\":[[0,0],[3,0]],\"count\":2}\n";
    assert_eq!(out(at, "pairs a.obj b.obj --json"), json);
    let version_1 = json;
    let csv = out(at, "pairs a.obj b.obj --csv --contacts");
    assert!(csv.starts_with("a,b,kind,x0,y0,z0,x1"), "{csv}");
    assert!(csv.lines().nth(1).unwrap().starts_with("0,0,crossing,0.2,"), "{csv}");
    let json = out(at, "pairs a.obj b.obj --json --contacts");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["contacts"][1]["a"], 3);
    assert_eq!(json["contacts"][0]["normals"][0], serde_json::json!([0.0, 0.0, -1.0]));
    // The extension tells the format, unless an option does.
    for (options, file, text) in [
        ("", "found.CSV", "a,b\n0,0\n3,0\n"),
        ("", "found.json", version_1),
        ("--csv", "found.txt", "a,b\n0,0\n3,0\n"),
    ] {
        assert_eq!(out(at, &format!("pairs a.obj b.obj {options} --out {file}")), "");
        assert_eq!(fs::read_to_string(at.join(file)).unwrap(), text);
    }
    assert_eq!(out(at, "pairs a.obj b.obj --csv -o -"), "a,b\n0,0\n3,0\n");
    assert!(!at.join("-").exists());
    for threads in 1..4 {
        let found = out(at, &format!("pairs a.obj b.obj --csv --threads {threads}"));
        assert_eq!(found, "a,b\n0,0\n3,0\n");
    }
}

#[test]
fn poses() {
    let folder = folder();
    let at = folder.path();
    let none = "a,b\n";
    for moved in [
        "--translate 5,0,0",
        "--translate -5,-5,-5",
        "--pose 1,0,0,5,0,1,0,0,0,0,1,0",
        "--rotate 0,0,1,180",
        "--rotate 0,0,1,360 --translate 5,0,0",
    ] {
        assert_eq!(out(at, &format!("pairs a.obj b.obj --csv {moved}")), none, "{moved}");
    }
    // A quarter turn about z takes (0.2, 0.2) to (-0.2, 0.2); the move takes it back.
    let back = "pairs a.obj b.obj --csv --rotate 0,0,2,90 --translate 0.5,0,0";
    assert_eq!(out(at, back), "a,b\n0,0\n3,0\n");
    for bad in [
        "--translate 1,2",
        "--pose 1,2,3",
        "--translate 1,2,x",
        "--translate 1,,2,3",
        "--translate 1,2,nan",
    ] {
        let error = refused(at, &format!("pairs a.obj b.obj {bad}"));
        assert!(error.contains("number") && error.contains("separated by commas"), "{error}");
    }
    for (bad, why) in [
        ("--rotate 0,0,0,30", "the axis has no length"),
        ("--pose 0,0,0,5,0,0,0,0,0,0,0,0", "shrink B to a point"),
    ] {
        assert!(refused(at, &format!("pairs a.obj b.obj {bad}")).contains(why), "{bad}");
    }
    refused(at, "pairs a.obj b.obj --pose 1,0,0,5,0,1,0,0,0,0,1,0 --translate 1,0,0");
}

#[test]
fn pictures() {
    let folder = folder();
    let at = folder.path();
    assert!(out(at, "pairs a.obj b.obj --out hits.ply").starts_with("2 pairs"));
    let picture = pfront_files::read_f32(&at.join("hits.ply")).unwrap();
    assert_eq!((picture.positions.len(), picture.triangles.len()), (15, 5));
    assert!(out(at, "self a.obj --out hits.ply").starts_with("0 pairs"));
}

#[test]
fn any_tells_by_its_exit_code() {
    let folder = folder();
    let yes = out(folder.path(), "any a.obj b.obj");
    assert!(yes.starts_with("triangles ") && yes.ends_with(" meet\n"), "{yes}");
    let no = pfront(folder.path(), "any a.obj b.obj --translate 9,9,9");
    assert_eq!((no.status.code(), &no.stdout[..]), (Some(1), &b"nothing meets\n"[..]));
}

#[test]
fn within_one_mesh() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("both.obj"), TETRAHEDRON.to_owned() + &BLADE.replace("f 1 2 3", "f 5 6 7"))
        .unwrap();
    assert_eq!(out(at, "self both.obj --csv"), "a,b\n0,4\n3,4\n");
    // As a soup, neighbours touch; welded, they are neighbours again.
    let soup = "solid s\n".to_owned()
        + &[[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0], [0, 1, 0]]]
            .map(|facet| {
                let corner = |v: [i32; 3]| format!("vertex {} {} {}\n", v[0], v[1], v[2]);
                format!(
                    "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n",
                    facet.map(corner).concat()
                )
            })
            .concat()
        + "endsolid s\n";
    fs::write(at.join("soup.stl"), soup).unwrap();
    let run = pfront(at, "self soup.stl --csv --no-weld");
    assert_eq!(run.stdout, b"a,b\n0,1\n");
    let hint = String::from_utf8(run.stderr).unwrap();
    assert!(hint.contains("in 1 of 1 pairs") && hint.contains("--weld"), "{hint}");
    for options in ["", "--weld", "--weld=0.1", "--weld 0.1"] {
        let run = pfront(at, &format!("self {options} soup.stl --csv"));
        assert!(run.status.success() && run.stdout == b"a,b\n", "{options}");
    }
    assert!(refused(at, "self soup.stl --weld=near").contains("not a distance"));
    assert!(refused(at, "self soup.stl --weld --no-weld").contains("--no-weld"));
    // Several files, each by itself.
    assert_eq!(out(at, "self both.obj a.obj --csv"), "file,a,b\nboth.obj,0,4\nboth.obj,3,4\n");
    let json = out(at, "self a.obj both.obj --json");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["pairs"][1], serde_json::json!({"file": "both.obj", "a": 3, "b": 4}));
    assert_eq!((&json["count"], &json["files"][1]["triangles"]), (&2.into(), &5.into()));
}

#[test]
fn a_script_may_ask_for_failure() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("both.obj"), TETRAHEDRON.to_owned() + &BLADE.replace("f 1 2 3", "f 5 6 7"))
        .unwrap();
    for (asked, code) in [
        ("pairs a.obj b.obj", 1),
        ("pairs a.obj b.obj --translate 9,9,9", 0),
        ("self both.obj", 1),
        ("self a.obj both.obj", 1),
        ("self a.obj", 0),
        ("scene a.obj b.obj", 1),
        ("scene a.obj b.obj --ignore a b", 0),
    ] {
        let clear = pfront(at, asked);
        assert_eq!(clear.status.code(), Some(0), "{asked}");
        let run = pfront(at, &format!("{asked} --fail"));
        assert_eq!(run.status.code(), Some(code), "{asked}");
        assert_eq!(run.stdout, clear.stdout, "{asked}");
    }
}

#[test]
fn refusals_say_what_and_where() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("nan.obj"), "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n").unwrap();
    fs::write(at.join("short.tcw"), b"TRICOLW1\0\0").unwrap();
    fs::write(at.join("text.obj"), "v 0 0 0\nhello, this is no mesh\n").unwrap();
    fs::write(at.join("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    for (arguments, parts) in [
        ("pairs a.obj missing.obj", vec!["missing.obj"]),
        ("pairs a.obj nan.obj", vec!["nan.obj, line 3", "vertex 2 has a NaN"]),
        ("pairs a.obj bad.obj", vec!["bad.obj", "line 4"]),
        ("pairs a.obj short.tcw", vec!["short.tcw", "obj"]),
        ("pairs a.obj b.obj --threads 0", vec!["--threads", "must be 1 to", "at once"]),
        ("pairs a.obj b.obj --threads 100000", vec!["--threads", "must be 1 to", "at once"]),
        ("pairs a.obj b.obj --threads 99999999999999999999", vec!["must be 1 to"]),
        ("bench --threads 100000", vec!["--threads", "must be 1 to"]),
        ("bench a.obj", vec!["2 values"]),
        ("pairs a.obj b.obj --out no/such/folder.csv", vec!["no/such/folder.csv", "o such"]),
        ("pairs a.obj b.obj --out a.obj", vec!["a.obj", "would replace a mesh"]),
        ("pairs a.obj b.obj --out ./b.obj", vec!["b.obj", "would replace a mesh"]),
        ("self b.obj --out b.obj", vec!["b.obj", "would replace a mesh"]),
        ("scene a.obj b.obj -o b.obj", vec!["b.obj", "would replace a mesh"]),
        ("bake a.obj -o a.obj", vec!["a.obj", "would replace a mesh"]),
        ("bake a.obj -o -", vec!["--out -"]),
        ("pairs a.obj b.obj --out z.stl", vec!["z.stl", ".json, .csv, .ply or .obj"]),
        ("pairs a.obj b.obj --out z", vec![".json, .csv, .ply or .obj"]),
        ("pairs a.obj b.obj --out z.json --csv", vec!["z.json", "--csv"]),
        ("self a.obj --out z.csv --json", vec!["z.csv", "--json"]),
        ("pairs - -", vec!["standard input can be only one"]),
        ("scene - a.obj -", vec!["standard input can be only one"]),
        ("bench - -", vec!["standard input can be only one"]),
        ("self text.obj", vec!["text.obj, line 2: 'hello,'", "--input-format"]),
        ("nonsense", vec!["nonsense"]),
    ] {
        let error = refused(at, arguments);
        for part in parts {
            assert!(error.contains(part), "no '{part}' in what 'pfront {arguments}' said: {error}");
        }
    }
    fs::write(at.join("old.csv"), "as it was").unwrap();
    refused(at, "pairs a.obj bad.obj --out old.csv");
    assert_eq!(fs::read(at.join("old.csv")).unwrap(), b"as it was");
    let left = fs::read_dir(at).unwrap().count();
    assert_eq!(left, 7, "a.obj, b.obj, nan.obj, bad.obj, text.obj, short.tcw and old.csv");
    assert_eq!(fs::read(at.join("a.obj")).unwrap(), TETRAHEDRON.as_bytes());
    assert_eq!(fs::read(at.join("b.obj")).unwrap(), BLADE.as_bytes());
}

#[test]
fn help_says_what_is_meant() {
    let folder = folder();
    for (command, part) in [
        ("pairs", "Triangles count from 0"),
        ("pairs", "12 numbers separated by commas"),
        ("pairs", "-o, --out <FILE>"),
        ("self", "Triangles count from 0"),
        ("self", "in the frame of the first mesh"),
        ("scene", "Triangles count from 0"),
        ("scene", "One body alone has nothing to meet"),
        ("bench", "bench [OPTIONS] [A B]"),
    ] {
        let help = out(folder.path(), &format!("{command} --help"));
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(help.contains(part), "no '{part}' in the help of {command}: {help}");
    }
}

/// Runs with nobody reading standard output.
fn unheard(folder: &Path, arguments: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_pfront"))
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    child.wait_with_output().unwrap()
}

#[test]
fn a_closed_pipe_does_not_change_the_exit_code() {
    let folder = folder();
    let at = folder.path();
    // Enough lines that the pipe cannot hold them all.
    let mut soup = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    soup.extend((0..200).map(|_| "f 1 2 3\n"));
    fs::write(at.join("many.obj"), soup).unwrap();
    for (arguments, code) in
        [("pairs many.obj many.obj", 0), ("any a.obj b.obj --translate 9,9,9", 1)]
    {
        let Output { status, stderr, .. } = unheard(at, arguments);
        let stderr = String::from_utf8(stderr).unwrap();
        assert!(
            status.code() == Some(code) && stderr.is_empty(),
            "{arguments}: {status}, {stderr}"
        );
    }
}
