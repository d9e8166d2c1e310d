//! `pfront scene`: bodies of several files, and of the nodes of one.

use super::{folder, out, refused};
use std::fs;

/// Three nodes that place one triangle: upright through the second is the first, the third is apart.
pub(super) const ROOM: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2,3]}],
    "nodes":[{"mesh":0,"name":"Door"},{"mesh":0,"rotation":[0.70710678,0,0,0.70710678],"translation":[0.1,0.1,-0.5],
    "name":"Wall, old"},{"name":"Empty"},{"mesh":0,"translation":[0,0,9],"name":"Door"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

#[test]
fn bodies_of_files_are_told_by_name() {
    let folder = folder();
    let at = folder.path();
    assert_eq!(
        out(at, "scene a.obj b.obj --csv"),
        "body_a,body_b,a,b\na.obj,b.obj,0,0\na.obj,b.obj,3,0\n"
    );
    let table = out(at, "scene a.obj b.obj");
    assert!(table.starts_with("body_a body_b          a          b\na.obj  b.obj  "), "{table}");
    assert!(table.ends_with("  3          0\n2 pairs\n"), "{table}");
    let names = out(at, "scene b.obj b.obj b.obj --csv");
    assert!(
        names.starts_with("body_a,body_b,a,b\nb.obj,b.obj (2),0,0\n") && names.lines().count() == 4,
        "{names}"
    );
}

#[test]
fn nodes_are_bodies() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("room.gltf"), ROOM).unwrap();
    let csv = "body_a,body_b,a,b\nDoor,\"Wall, old\",0,0\n";
    assert_eq!(out(at, "scene room.gltf --csv"), csv);
    let json: serde_json::Value = serde_json::from_str(&out(at, "scene room.gltf --json")).unwrap();
    assert_eq!(
        json["pairs"],
        serde_json::json!([{"bodies": ["Door", "Wall, old"], "a": 0, "b": 0}])
    );
    let json = out(at, "scene room.gltf --json --contacts --source");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let hit = &json["contacts"][0];
    assert_eq!((&hit["kind"], &hit["bodies"][1]), (&"crossing".into(), &"Wall, old".into()));
    let y = hit["segment"][0][1].as_f64().unwrap();
    assert!((y - 0.1).abs() < 1e-6, "{json}");
    assert!(out(at, "scene room.gltf --out room.ply").starts_with("1 pair;"));
    let marks = fs::read(at.join("room.ply")).unwrap();
    let red = marks.windows(3).filter(|colour| *colour == [214, 40, 40]).count();
    assert_eq!(
        (red, pfront_files::read_f32(&at.join("room.ply")).unwrap().triangles.len()),
        (6, 3)
    );
    assert_eq!(out(at, "scene room.gltf --csv --backend cpu --threads 2"), csv);
    // The wall is turned, and then rounded.
    let run = super::pfront(at, "scene room.gltf --csv --backend gpu --f32");
    assert_eq!(String::from_utf8(run.stdout).unwrap(), csv);
    let told = String::from_utf8(run.stderr).unwrap();
    assert!(told.contains("room.gltf: 3 of 27 coordinates were rounded to f32"), "{told}");
    let error = refused(at, "scene room.gltf --ignore Door Floor");
    assert!(error.contains("no body Floor") && error.contains("Door (2)"), "{error}");
    refused(at, "scene");
}

#[test]
fn two_bodies_are_ignored() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("room.gltf"), ROOM.replace("Wall, old", "Wall")).unwrap();
    assert_eq!(out(at, "scene room.gltf --csv").lines().count(), 2);
    assert_eq!(out(at, "scene room.gltf --csv --ignore Wall Door"), "body_a,body_b,a,b\n");
    let both = out(at, "scene room.gltf a.obj b.obj --csv --ignore Wall Door --ignore a.obj b.obj");
    assert!(
        both.lines().skip(1).all(|line| line.contains("obj") && !line.contains("a.obj,b.obj")),
        "{both}"
    );
}

#[test]
fn bodies_are_ignored_by_patterns_and_by_a_file() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("room.gltf"), ROOM).unwrap();
    for ignored in ["--ignore Do* Wall*", "--ignore * *", "--ignore ?oor Wall,?old"] {
        let rest = out(at, &format!("scene room.gltf --csv {ignored}"));
        assert_eq!(rest, "body_a,body_b,a,b\n", "{ignored}");
    }
    assert!(refused(at, "scene room.gltf --ignore Do* Floor*").contains("no body Floor*"));
    // A list of what meets now is one of what to leave out.
    out(at, "scene room.gltf a.obj b.obj --bodies --out known.csv");
    let rest = out(at, "scene room.gltf a.obj b.obj --csv --ignore-file known.csv");
    assert_eq!(rest, "body_a,body_b,a,b\n");
    fs::write(at.join("known.csv"), "Door\n").unwrap();
    let error = refused(at, "scene room.gltf --ignore-file known.csv");
    assert!(error.contains("known.csv: a line does not name two bodies"), "{error}");
    assert!(refused(at, "scene room.gltf --ignore-file no.csv").contains("cannot read no.csv"));
}

#[test]
fn one_body_alone_is_told() {
    let folder = folder();
    let run = super::pfront(folder.path(), "scene a.obj --csv");
    let told = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.success() && told.contains("there is one body, a.obj"), "{told}");
}

#[test]
fn objects_of_one_file_are_bodies() {
    let folder = folder();
    let at = folder.path();
    let blade = super::BLADE.replace("f 1 2 3", "f 5 6 7");
    let both = format!("o cone\n{}o blade\n{blade}", super::TETRAHEDRON);
    fs::write(at.join("both.obj"), &both).unwrap();
    let rows = "body_a,body_b,a,b\ncone,blade,0,0\ncone,blade,3,0\n";
    assert_eq!(out(at, "scene both.obj --csv"), rows);
    // To others the file is one mesh.
    assert_eq!(out(at, "self both.obj --csv"), "a,b\n0,4\n3,4\n");
    let source = out(at, "scene both.obj --csv --source");
    assert_eq!(source.lines().nth(2), Some("cone,blade,3,0,3,4"));
}

#[test]
fn welding_joins_no_bodies() {
    let folder = folder();
    let at = folder.path();
    let near = "o left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1e-7 0\nv 1 1e-7 0\nf 1 2 3\nf 4 5 3\n\
        o right\nv -1e-7 0 0\nv -1 0 0\nv -1e-7 1 0\nf 6 7 8\n";
    fs::write(at.join("near.obj"), near).unwrap();
    let run = super::pfront(at, "scene near.obj --csv --weld 1e-6");
    assert_eq!(run.stdout, b"body_a,body_b,a,b\n");
    let told = String::from_utf8(run.stderr).unwrap();
    assert_eq!(told, "near.obj: left: vertices that were joined with others nearby: 2\n");
}

#[test]
fn files_are_bodies_by_any_name_that_is_clear() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("parts")).unwrap();
    fs::copy(at.join("a.obj"), at.join("parts/gear.obj")).unwrap();
    fs::copy(at.join("a.obj"), at.join("parts/a.obj")).unwrap();
    let rows = "body_a,body_b,a,b\ngear.obj,b.obj,0,0\ngear.obj,b.obj,3,0\n";
    assert_eq!(out(at, "scene parts/gear.obj b.obj --csv"), rows);
    for two in ["gear b", "gear.obj b.obj", "parts/gear.obj b"] {
        let rest = out(at, &format!("scene parts/gear.obj b.obj --csv --ignore {two}"));
        assert_eq!(rest, "body_a,body_b,a,b\n", "{two}");
    }
    // Files of the same name keep their folders.
    let both = "scene a.obj parts/a.obj b.obj --bodies --csv --ignore a.obj parts/a.obj";
    assert_eq!(out(at, both), "body_a,body_b,pairs\na.obj,b.obj,2\nparts/a.obj,b.obj,2\n");
    for (two, part) in [
        ("a b", "a can be any of a.obj, parts/a.obj"),
        ("b.obj b", "--ignore b.obj b: that is one body"),
        ("b c", "no body c; there are a.obj, parts/a.obj, b.obj"),
    ] {
        let error = refused(at, &format!("scene a.obj parts/a.obj b.obj --ignore {two}"));
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn bodies_that_meet_are_counted() {
    let folder = folder();
    let at = folder.path();
    assert_eq!(
        out(at, "scene a.obj b.obj --bodies"),
        "body_a body_b      pairs\na.obj  b.obj           2\n1 pair of bodies\n"
    );
    let json = out(at, "scene a.obj b.obj --bodies --json");
    assert!(
        json.ends_with(
            "\"bodies\":[{\"bodies\":[\"a.obj\",\"b.obj\"],\"pairs\":2}],\"count\":1}\n"
        )
    );
    for options in ["--out hits.ply", "--out curve.obj", "--contacts", "--source"] {
        let error = refused(at, &format!("scene a.obj b.obj --bodies {options}"));
        assert!(error.contains("--bodies"), "{error}");
    }
}
