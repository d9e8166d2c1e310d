//! Names that files bring along, on a terminal.

use super::scene::ROOM;
use super::{command, folder, out};
use std::fs;
use std::path::Path;
use std::process::Output;

/// Clears a terminal, begins a line, turns the direction, and is C1's beginning of a sequence.
const NAME: &str = "\x1b[2J\x1b]0;owned\x07\nforged \u{202e}\u{9b}1m\u{7f}\r\u{2028}";
const ESCAPED: &str = r"\u{1b}[2J\u{1b}]0;owned\u{7}\nforged \u{202e}\u{9b}1m\u{7f}\r\u{2028}";

fn is_harmless(text: &str) -> bool {
    let is_strange = |c: char| c.is_control() && c != '\n' || "\u{202e}\u{2028}".contains(c);
    !text.contains(is_strange)
}

fn room(at: &Path) {
    let name = serde_json::to_string(NAME).unwrap();
    fs::write(at.join("room.gltf"), ROOM.replace("\"Door\"", &name)).unwrap();
}

#[test]
fn names_of_nodes_are_escaped() {
    let folder = folder();
    let at = folder.path();
    room(at);
    let table = out(at, "scene room.gltf");
    assert!(is_harmless(&table) && table.contains(ESCAPED), "{table:?}");
    assert_eq!(table.lines().count(), 3, "a title, one pair and their number: {table:?}");
    // Columns are as wide as what is shown.
    let widths: Vec<_> = table.lines().take(2).map(|line| line.chars().count()).collect();
    assert_eq!(widths[0], widths[1], "{table}");
    for arguments in ["scene room.gltf --bodies", "self room.gltf --source"] {
        let table = out(at, arguments);
        assert!(is_harmless(&table) && table.contains(ESCAPED), "{table:?}");
    }
    // JSON says the same in other characters.
    for arguments in ["scene room.gltf --json", "scene room.gltf --bodies --json"] {
        let json = out(at, arguments);
        assert!(is_harmless(&json), "{json:?}");
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let bodies = json.get("pairs").unwrap_or(&json["bodies"])[0]["bodies"].clone();
        assert!(bodies.as_array().unwrap().iter().any(|name| name == NAME), "{bodies}");
    }
    for arguments in ["scene room.gltf --csv", "self room.gltf --csv --source"] {
        let csv = out(at, arguments);
        assert!(is_harmless(&csv) && csv.contains(ESCAPED), "{csv:?}");
    }
    let Output { stderr, .. } =
        command(at, "scene room.gltf --ignore nothing room.gltf").output().unwrap();
    let error = String::from_utf8(stderr).unwrap();
    assert!(is_harmless(&error) && error.contains(ESCAPED), "{error:?}");
}

#[cfg(unix)]
#[test]
fn names_of_files_are_escaped() {
    let folder = folder();
    let at = folder.path();
    let [mesh, missing] = [".obj", "?.obj"].map(|end| NAME.replace('/', "") + end);
    fs::copy(at.join("a.obj"), at.join(&mesh)).unwrap();
    fs::write(at.join("bad.obj"), format!("v 0 0 {NAME}\nf 1 1 1\n")).unwrap();
    let run = |words: &[&str]| {
        let Output { stdout, stderr, .. } = command(at, "").args(words).output().unwrap();
        [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap())
    };
    for words in [
        &["scene", &mesh, "b.obj"][..],
        &["bake", &mesh],
        &["pairs", &mesh, "b.obj", "--out", "hits.ply", "--f32"],
        &["pairs", "a.obj", "b.obj", "--out", &mesh.replace("obj", "ply")],
        &["bench", &mesh, "b.obj", "--frames", "1", "--threads", "1", "--backend", "cpu"],
        &["self", &missing],
        &["self", "bad.obj"],
        &["self", &mesh, "-o", &mesh],
        &["self", "a.obj", "-o", &format!("{NAME}.docx")],
        &["self", "a.obj", &mesh],
    ] {
        let [said, error] = run(words);
        assert!(is_harmless(&said) && is_harmless(&error), "{words:?}: {said:?}, {error:?}");
    }
}
