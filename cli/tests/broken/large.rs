//! Files that are far larger than what is in them: refused or read in little memory. They are sparse, and take no disk.

use super::capped::run_within;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

/// MiB of address space, of which the program takes some 100 before it reads anything.
const MIB: u64 = 256;
const GB: u64 = 1_000_000_000;

/// A file that begins so and goes on with zeros.
fn sparse(at: &Path, name: &str, head: &[u8], bytes: u64) {
    let mut file = File::create(at.join(name)).unwrap();
    file.write_all(head).unwrap();
    file.set_len(bytes).unwrap();
}

#[test]
fn a_file_is_refused_by_its_head() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    for format in pfront_files::FORMATS {
        let name = format!("zeros.{format}");
        sparse(at, &name, &[], 2 * GB);
        let error = run_within(at, &format!("self {name} --threads 1"), MIB).unwrap_err();
        assert!(error.contains(&name), "{error}");
    }
    for (name, head) in [
        ("a.glb", &b"glTF\x02\0\0\0\xff\0\0\0"[..]),
        ("a.pfb", b"\x89PFB\r\n\x1a\n\x01\0\0\0\0\0\0\0\xff\0\0\0\0\0\0\0"),
        ("a.ply", b"ply\nformat ascii 1.0\n"),
        ("a.off", b"OFF\n"),
        ("a.obj", b"v 0 0 0\n"),
        ("a.gltf", b"{\"asset\":"),
        ("a.stl", b"solid\n"),
    ] {
        sparse(at, name, head, 2 * GB);
        let error = run_within(at, &format!("self {name} --threads 1"), MIB).unwrap_err();
        assert!(error.contains(name), "{error}");
    }
}

/// A file is refused whatever it begins with.
#[test]
fn a_file_beyond_the_memory_that_is_allowed_is_not_read() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let line = "v 0 0 0\n".repeat(10_000);
    let ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (name, head) in [("a.obj", line.as_bytes()), ("a.ply", ply), ("a.off", b"OFF BINARY\n")] {
        sparse(at, name, head, 2 * GB);
        let error = run_within(at, &format!("self {name} --memory 50 --threads 1"), MIB);
        let error = error.unwrap_err();
        assert!(error.contains(name) && error.contains("--memory"), "{error}");
    }
}

/// A glTF whose buffer has so many bytes, and names a file.
fn gltf(bytes: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[{{"bufferView":0,
        "componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":{bytes},"uri":"big.bin"}}]}}"#
    )
}

#[test]
fn of_a_buffer_no_more_is_read_than_it_has() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    sparse(at, "big.bin", &[], 3 * GB / 2);
    fs::write(at.join("a.gltf"), gltf("36")).unwrap();
    for options in ["--memory 50", ""] {
        let asked = format!("self a.gltf --csv --threads 1 {options}");
        assert_eq!(run_within(at, &asked, MIB).unwrap(), "a,b\n");
    }
    fs::write(at.join("a.gltf"), gltf("1500000000")).unwrap();
    let error = run_within(at, "self a.gltf --memory 50 --threads 1", MIB).unwrap_err();
    assert!(error.contains("needs more than 50 MB"), "{error}");
    fs::write(at.join("a.gltf"), gltf("1500000001")).unwrap();
    let error = run_within(at, "self a.gltf --threads 1", MIB).unwrap_err();
    assert!(error.contains("has 1500000000 bytes, and 1500000001"), "{error}");
}

/// A face of a text has two bytes a corner, and takes many times as much.
#[test]
fn a_long_face_is_counted_before_it_is_triangulated() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let face = "v 0 0 0\n".repeat(3) + "f" + &" 1".repeat(4_000_000) + "\n";
    fs::write(at.join("face.obj"), face).unwrap();
    let error = run_within(at, "self face.obj --memory 30 --threads 1", 160).unwrap_err();
    assert!(error.contains("needs more than 30 MB"), "{error}");
}
