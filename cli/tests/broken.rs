//! Broken files through every command that reads any: refused in words that name the file, within bounds of
//! time and memory, whatever a file says of its own size.

#![cfg(unix)]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod capped;
#[path = "broken/large.rs"]
mod large;

use capped::{FEW, run, run_within};
use pfront_testkit::rng::{Rng, seeded};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const GOOD: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("good.obj"), GOOD).unwrap();
    folder
}

/// Text files that say more of themselves than there is, and two that are plainly wrong; `mesh.rs` has the others.
const TEXTS: [(&str, &str); 8] = [
    ("empty.obj", ""),
    ("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"),
    ("index-2^32.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4294967299\n"),
    ("index-10^30.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1000000000000000000000000000000\n"),
    ("many-vertices.off", "OFF\n4000000000 1 0\n0 0 0\n"),
    (
        "text.ply",
        "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
    ),
    ("many-faces.off", "OFF\n3 4000000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    ("10^7-sides.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n10000000 0 1 2\n"),
];

/// Binary files that say more of themselves than there is.
fn binaries() -> Vec<(String, Vec<u8>)> {
    let ply = |vertices: &str, count: &str, rest: &[u8]| {
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
             property float y\nproperty float z\nelement face 1\n\
             property list {count} int vertex_indices\nend_header\n"
        );
        [header.as_bytes(), rest].concat()
    };
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
    let face = |sides: u32| [&corners[..], &sides.to_le_bytes(), &[0; 12]].concat();
    let nan = [&[0xff; 36][..], &3_u32.to_le_bytes(), &[0; 12]].concat();
    let stl = |count: u32, rest: &[u8]| [&[0; 80][..], &count.to_le_bytes(), rest].concat();
    let glb = |length: u32, chunk: u32| {
        let words = [0x4654_6c67, 2, length, chunk, 0x4e4f_534a].map(u32::to_le_bytes).concat();
        [&words[..], b"{}  "].concat()
    };
    let gltf = |count: &str, bytes: &str| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": {count}, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 1]}}], "bufferViews": [{{"buffer": 0, "byteLength": {bytes}}}],
            "buffers": [{{"byteLength": {bytes}, "uri": "data:application/octet-stream;base64,AAAA"}}]}}"#
        )
        .into_bytes()
    };
    let named = [
        ("deep.gltf", vec![b'['; 100_000]),
        ("vertices.ply", ply("4000000000", "uchar", &corners)),
        ("2^64-vertices.ply", ply("18446744073709551615", "uchar", &corners)),
        ("too-many-vertices.ply", ply("99999999999999999999", "uchar", &corners)),
        ("10^7-sides.ply", ply("3", "uint", &face(10_000_000))),
        ("2^32-sides.ply", ply("3", "uint", &face(u32::MAX))),
        ("nan.ply", ply("3", "uint", &nan)),
        ("triangles.stl", stl(u32::MAX, &[0; 50])),
        ("none.stl", stl(0, &[])),
        ("nan.stl", stl(1, &[0xff; 50])),
        ("long.glb", glb(u32::MAX, 4)),
        ("long-chunk.glb", glb(24, u32::MAX)),
        ("short.glb", glb(24, 4)[..15].to_vec()),
        ("accessor.gltf", gltf("4000000000", "3")),
        ("buffer.gltf", gltf("1", "1000000000000000000")),
    ];
    let mut files: Vec<_> = named.map(|(name, bytes)| (name.to_owned(), bytes)).into();
    let mut rng = seeded(6);
    for format in pfront_files::FORMATS {
        for length in [1, 84, 4096] {
            let mut garbage = vec![0; length];
            rng.fill_bytes(&mut garbage);
            files.push((format!("garbage-{length}.{format}"), garbage));
        }
    }
    files
}

#[test]
fn broken_meshes_are_refused_by_every_command() {
    let folder = folder();
    let at = folder.path();
    let texts = TEXTS.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    for (name, bytes) in texts.into_iter().chain(binaries()) {
        fs::write(at.join(&name), bytes).unwrap();
        refused(at, &name);
        fs::remove_file(at.join(&name)).unwrap();
    }
    fs::create_dir(at.join("folder.obj")).unwrap();
    refused(at, "folder.obj");
    refused(at, "missing.obj");
    assert!(!at.join("hits.ply").exists() && !at.join("hits.pfb").exists());
}

/// By every command that reads a mesh.
fn refused(at: &Path, name: &str) {
    for command in ["self", "self --weld=0 --contacts", "any good.obj", "pairs good.obj"] {
        refuses(at, &format!("{command} {name} {FEW}"), name);
    }
    refuses(at, &format!("pairs {name} good.obj --out hits.ply {FEW}"), name);
    refuses(at, &format!("bake {name} --out hits.pfb"), name);
}

fn refuses(at: &Path, arguments: &str, name: &str) {
    match run(at, arguments) {
        Err(error) => assert!(error.contains(name), "'pfront {arguments}' says: {error}"),
        Ok(answer) => panic!("'pfront {arguments}' answers: {answer}"),
    }
}

/// Unusual, but meshes: what is said of them has to be right.
#[test]
fn extremes_are_answered() {
    let folder = folder();
    let at = folder.path();
    // A triangle as large as f32 can tell, one as small, one that is a point; each alone and the second through
    // the first.
    let huge = "v -3e38 -3e38 0\nv 3e38 -3e38 0\nv 0 3e38 0\nf 1 2 3\n";
    let tiny = "v 0 0 -1e-45\nv 1e-45 0 1e-45\nv 0 1e-45 1e-45\nf 1 2 3\n";
    let point = "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\nf 1 2 3\nf 1 1 1\n";
    for (name, text) in [("huge.obj", huge), ("tiny.obj", tiny), ("point.obj", point)] {
        fs::write(at.join(name), text).unwrap();
    }
    for (arguments, pairs) in [
        ("self huge.obj --f32", "a,b\n"),
        ("pairs huge.obj tiny.obj --f32", "a,b\n0,0\n"),
        ("pairs tiny.obj huge.obj --f32 --backend gpu", "a,b\n0,0\n"),
        ("pairs huge.obj point.obj --f32", "a,b\n0,0\n0,1\n0,2\n"),
        ("self point.obj", "a,b\n0,1\n0,2\n1,2\n"),
        ("self point.obj --skip-neighbours", "a,b\n"),
        ("pairs tiny.obj tiny.obj --translate 0,0,1", "a,b\n"),
    ] {
        assert_eq!(run(at, &format!("{arguments} --csv {FEW}")).unwrap(), pairs, "{arguments}");
    }
    let error = run(at, &format!("self huge.obj {FEW}")).unwrap_err();
    assert!(error.contains("huge.obj, line 1") && error.contains("beyond ±2^125"), "{error}");
    let moved = format!("any good.obj huge.obj --f32 --translate 0,1,0 {FEW}");
    let error = run(at, &moved).unwrap_err();
    assert!(error.contains("row 0 of the pose"), "{error}");
}

/// A buffer that a glTF names two thousand times, which would be 8 GB.
#[test]
fn a_file_that_is_named_often_is_read_once() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("data.bin"), vec![0; 4_000_000]).unwrap();
    let buffers = vec![r#"{"byteLength":4000000,"uri":"data.bin"}"#; 2000].join(",");
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,
        "count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}],"bufferViews":[{"buffer":1999,"byteLength":36}],"buffers":["#;
    fs::write(at.join("often.gltf"), format!("{gltf}{buffers}]}}")).unwrap();
    assert_eq!(run(at, &format!("self often.gltf --csv {FEW}")).unwrap(), "a,b\n");
}

/// Files of some hundred KB that ask for far more than 16 times as much and 64 MB: 3,000 nodes that place 3,000 vertices
/// each, and a header of 100,000 elements.
#[test]
fn small_files_are_refused_in_little_memory() {
    let folder = folder();
    let at = folder.path();
    let places = (0..3000).map(|node| node.to_string()).collect::<Vec<_>>().join(",");
    let nodes = vec![r#"{"mesh":0}"#; 3000].join(",");
    let zeros = "A".repeat(48_000);
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{places}]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[{{"bufferView":0,
        "componentType":5126,"count":3000,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36000}}],
        "buffers":[{{"byteLength":36000,"uri":"data:application/octet-stream;base64,{zeros}"}}]}}"#
    );
    fs::write(at.join("vertices.gltf"), gltf).unwrap();
    let element = |number| format!("element e{number} 0\nproperty uchar x\n");
    let elements: String = (0..100_000).map(element).collect();
    let ply = format!("ply\nformat ascii 1.0\n{elements}end_header\n");
    fs::write(at.join("elements.ply"), ply).unwrap();
    for (name, part) in [("vertices.gltf", "--memory"), ("elements.ply", "no triangle")] {
        let error = run_within(at, &format!("self {name} --threads 1"), 256).unwrap_err();
        assert!(error.contains(name) && error.contains(part), "{error}");
    }
}
