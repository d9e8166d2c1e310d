//! A glTF names files of its own folder, and no others unless they are asked for.

use super::{command, folder, out, refused};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// A triangle whose 36 bytes are in a file that a URI names.
fn gltf(uri: &str) -> String {
    let uri = serde_json::to_string(uri).unwrap();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[{{"bufferView":0,
        "componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":{uri}}}]}}"#
    )
}

const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

fn write(path: &Path) {
    fs::write(path, CORNERS.map(f32::to_le_bytes).as_flattened()).unwrap();
}

#[test]
fn a_gltf_names_files_of_its_own_folder_only() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir_all(at.join("upload/sub")).unwrap();
    write(&at.join("secret.bin"));
    let absolute = at.join("secret.bin").to_str().unwrap().to_owned();
    let ways = [
        "../secret.bin",
        "sub/../../secret.bin",
        "..%2Fsecret.bin",
        "%2e%2e/secret.bin",
        "./../upload/../secret.bin",
        &absolute,
        &absolute.replace('/', "%2F"),
    ];
    for uri in ways {
        fs::write(at.join("upload/a.gltf"), gltf(uri)).unwrap();
        for command in ["self upload/a.gltf", "bake upload/a.gltf", "scene upload/a.gltf"] {
            let error = refused(at, command);
            let names = error.contains(&format!("'{uri}'")) && error.contains("upload/a.gltf");
            assert!(names && error.contains("--allow-outside-files"), "{error}");
        }
        assert_eq!(out(at, "self upload/a.gltf --csv --allow-outside-files"), "a,b\n");
    }
    for uri in [&format!("file://{absolute}"), &format!("file:{absolute}"), "file:../secret.bin"] {
        fs::write(at.join("upload/a.gltf"), gltf(uri)).unwrap();
        assert!(refused(at, "self upload/a.gltf").contains(&format!("'{uri}'")), "{uri}");
    }
    fs::write(at.join("upload/a.gltf"), gltf("..\\secret.bin")).unwrap();
    refused(at, "self upload/a.gltf");
    write(&at.join("upload/sub/own.bin"));
    for uri in ["sub/own.bin", "./sub/own.bin", "sub/../sub/own.bin", "sub%2Fown.bin"] {
        fs::write(at.join("upload/a.gltf"), gltf(uri)).unwrap();
        assert_eq!(out(at, "self upload/a.gltf --csv"), "a,b\n", "{uri}");
        assert_eq!(out(&at.join("upload"), "self a.gltf --csv"), "a,b\n", "{uri}");
    }
}

/// It has no folder.
#[test]
fn a_gltf_of_standard_input_names_no_files() {
    let folder = folder();
    let at = folder.path();
    write(&at.join("own.bin"));
    fs::write(at.join("a.gltf"), gltf("own.bin")).unwrap();
    let fed = |arguments: &str| {
        let file = fs::File::open(at.join("a.gltf")).unwrap();
        command(at, arguments).stdin(Stdio::from(file)).output().unwrap()
    };
    let error = String::from_utf8(fed("self -").stderr).unwrap();
    assert!(error.contains("'own.bin'") && error.contains("--allow-outside-files"), "{error}");
    assert_eq!(fed("self - --csv --allow-outside-files").stdout, b"a,b\n");
}

#[cfg(unix)]
#[test]
fn links_are_resolved_before_a_folder_is_compared() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let at = folder.path();
    fs::create_dir_all(at.join("upload/sub")).unwrap();
    write(&at.join("secret.bin"));
    write(&at.join("upload/sub/own.bin"));
    symlink(at.join("secret.bin"), at.join("upload/link.bin")).unwrap();
    symlink(at, at.join("upload/up")).unwrap();
    symlink("sub/own.bin", at.join("upload/inner.bin")).unwrap();
    for uri in ["link.bin", "up/secret.bin", "sub/../link.bin"] {
        fs::write(at.join("upload/a.gltf"), gltf(uri)).unwrap();
        assert!(refused(at, "self upload/a.gltf").contains(&format!("'{uri}'")), "{uri}");
        out(at, "self upload/a.gltf --allow-outside-files");
    }
    for uri in ["inner.bin", "up/upload/sub/own.bin"] {
        fs::write(at.join("upload/a.gltf"), gltf(uri)).unwrap();
        assert_eq!(out(at, "self upload/a.gltf --csv"), "a,b\n", "{uri}");
    }
    // A folder that is itself reached by a link.
    symlink(at.join("upload"), at.join("other")).unwrap();
    fs::write(at.join("upload/a.gltf"), gltf("sub/own.bin")).unwrap();
    assert_eq!(out(at, "self other/a.gltf --csv"), "a,b\n");
}

/// A device never ends, and a pipe that nobody writes never begins.
#[cfg(unix)]
#[test]
fn a_gltf_names_no_devices_and_no_pipes() {
    let folder = folder();
    let at = folder.path();
    assert!(std::process::Command::new("mkfifo").arg(at.join("pipe")).status().unwrap().success());
    for uri in ["/dev/zero", "/dev/stdin", "pipe", "."] {
        fs::write(at.join("a.gltf"), gltf(uri)).unwrap();
        let error = refused(at, "self a.gltf --allow-outside-files");
        assert!(error.contains("there is no file"), "{error}");
    }
}
