//! glTF documents that reach a node twice, ask for more than they have, or leave something out.

use super::bodies::{NODES, PIN, gltf, meshes};
use super::lenient::read;
use pfront_files::MeshFile;

const SCENES: &str = r#""scenes":[{"nodes":[0,1]}],"#;

/// Reads a binary file, with a part of its text replaced by another of the same length.
fn changed(bytes: &[u8], from: &str, to: &str) -> Result<MeshFile, String> {
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
    let mut bytes = bytes.to_vec();
    bytes[at..][..from.len()]
        .copy_from_slice(format!("{to:width$}", width = from.len()).as_bytes());
    read("glb", bytes)
}

#[test]
fn a_node_is_reached_once() {
    let refused = |nodes: &str, what: &str| {
        let error = read("glb", gltf(nodes, &meshes("", ""), &[])).unwrap_err();
        assert!(error.contains(what), "{error}");
    };
    // The last node of four is in no scene.
    refused(
        r#"{"children":[2]},{"children":[2]},{"mesh":1},{"mesh":0}"#,
        "node 2 is reached twice",
    );
    let zeros = vec!["2"; 10_000].join(",");
    refused(&format!(r#"{{"mesh":0}},{{"children":[{zeros}]}},{{}}"#), "node 2 is reached twice");
    refused(r#"{"mesh":0},{"mesh":1,"children":[0]},{}"#, "node 0 is reached twice");

    let cycle = r#"{"mesh":0},{"mesh":1,"children":[2]},{"children":[1]}"#;
    let error = changed(&gltf(cycle, &meshes("", ""), &[]), SCENES, "").unwrap_err();
    assert!(error.contains("node 1 is below itself"), "{error}");
    let file = changed(&gltf(NODES, &meshes("", ""), &[]), SCENES, "").unwrap();
    assert_eq!(file.mesh.triangles.len(), 2);
}

/// Number of vertices of the meshes that a document asks to be moved many times.
const VERTICES: usize = 60_000;

/// The accessors of positions that are all 0, of joints that are 0, and of weights that are 1, in [`zeros_and_ones`].
fn accessors() -> String {
    let count = VERTICES;
    format!(
        r#",{{"bufferView":2,"componentType":5121,"count":{count},"type":"VEC3","min":[0,0,0],"max":[0,0,0]}},
        {{"bufferView":2,"componentType":5121,"count":{count},"type":"VEC4"}},
        {{"bufferView":2,"byteOffset":{},"componentType":5121,"normalized":true,"count":{count},"type":"VEC4"}}"#,
        4 * VERTICES
    )
}

fn zeros_and_ones() -> Vec<u8> {
    [[0; 4 * VERTICES], [255; 4 * VERTICES]].concat()
}

#[test]
fn sets_of_joints_take_of_the_budget() {
    let nodes = r#"{"mesh":0},{"mesh":1,"skin":0,"children":[2]},{"translation":[5,0,0]}"#;
    let skinned = |sets: usize| {
        let set = |set| format!(r#","JOINTS_{set}":3,"WEIGHTS_{set}":4"#);
        let sets: String = (0..sets).map(set).collect();
        let rest = meshes(&sets, &accessors()).replace("\"POSITION\":1", "\"POSITION\":2");
        let skin = r#""skins":[{"joints":[2]}],"#;
        read("glb", gltf(nodes, &(rest + skin), &zeros_and_ones()))
    };
    // Sets add up: each weighs as much as the others.
    let file = skinned(2).unwrap();
    assert_eq!(file.mesh.positions.last(), Some(&[5.0, 0.0, 0.0]));
    assert!(skinned(100).unwrap_err().contains("needs more than"));
}

#[test]
fn morph_targets_with_a_weight_take_of_the_budget() {
    let morphed = |weight: &str| {
        let targets = vec![r#"{"POSITION":2}"#; 200].join(",");
        let weights = vec![weight; 200].join(",");
        let rest = meshes("", &accessors()).replace(
            r#""POSITION":1}}]}"#,
            &format!(r#""POSITION":2}},"targets":[{targets}]}}],"weights":[{weights}]}}"#),
        );
        read("glb", gltf(NODES, &rest, &zeros_and_ones()))
    };
    assert!(morphed("0").is_ok());
    assert!(morphed("0.5").unwrap_err().contains("needs more than"));
}

#[test]
fn joints_are_whole_numbers() {
    let nodes = r#"{"mesh":0},{"mesh":1,"skin":0,"children":[2]},{"translation":[5,0,0]}"#;
    let skinned = |joints: &str| {
        let accessors = format!(
            r#",{{"bufferView":2,{joints},"count":3,"type":"VEC4"}},
            {{"bufferView":2,"byteOffset":48,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}}"#
        );
        let rest = meshes(r#","JOINTS_0":2,"WEIGHTS_0":3"#, &accessors);
        let more = [[0; 48].as_slice(), &[255, 0, 0, 0].repeat(3)].concat();
        read("glb", gltf(nodes, &(rest + r#""skins":[{"joints":[2]}],"#), &more))
    };
    for unsigned in ["\"componentType\":5121", "\"componentType\":5123"] {
        let file = skinned(unsigned).unwrap();
        assert_eq!(file.mesh.positions[3], [f64::from(PIN[0][0]) + 5.0, 0.25, -1.0]);
    }
    for (joints, what) in [
        ("\"componentType\":5126", "JOINTS_0: accessor 2: Vec4 of F32"),
        ("\"componentType\":5120", "JOINTS_0: accessor 2: Vec4 of I8"),
        ("\"componentType\":5122", "JOINTS_0: accessor 2: Vec4 of I16"),
        ("\"componentType\":5121,\"normalized\":true", "JOINTS_0: accessor 2 is normalized"),
    ] {
        let error = skinned(joints).unwrap_err();
        assert!(error.contains(what), "{error}");
    }
}

#[test]
fn what_is_left_out_is_noted() {
    let text = String::from_utf8(super::samples::gltf()).unwrap();
    let scene = r#""scenes":[{"nodes":[0,1]}],"#;
    assert!(text.contains(scene));
    for (scenes, notes, triangles) in [
        (r#""scenes":[{"nodes":[0,1]},{"nodes":[0]}],"#, &[][..], 3),
        (
            r#""scenes":[{"nodes":[0]},{"nodes":[0,1]}],"#,
            &["nodes with a mesh outside of the scene are passed over: 1"],
            1,
        ),
    ] {
        let file = read("gltf", text.replace(scene, scenes)).unwrap();
        assert_eq!(
            (&file.notes[..], file.mesh.triangles.len()),
            (&notes.iter().map(|note| note.to_string()).collect::<Vec<_>>()[..], triangles)
        );
    }
    let rest = meshes("", "");
    let nowhere = rest.replace(r#"{"POSITION":1}"#, r#"{"NORMAL":1}"#);
    let error = read("glb", gltf(NODES, &nowhere, &[])).unwrap_err();
    assert!(error.contains("POSITION"), "{error}");
}
