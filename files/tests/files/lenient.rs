//! Files that are not as their format says: read with a note where nothing is lost, and refused where something is.

use super::samples::*;
use super::text;
use pfront_files::{Contents, MeshFile, ReadOptions, Weld, read_bytes};

/// Reads bytes of a format.
pub(super) fn read(format: &str, bytes: impl AsRef<[u8]>) -> Result<MeshFile, String> {
    read_as(format, bytes, Weld::Split)
}

fn read_as(format: &str, bytes: impl AsRef<[u8]>, weld: Weld) -> Result<MeshFile, String> {
    let options = ReadOptions { format: Some(format.to_owned()), weld, ..ReadOptions::default() };
    match read_bytes(bytes.as_ref(), &options) {
        Ok(Contents::Mesh(file)) => Ok(file),
        Ok(Contents::Baked(_)) => Err("baked".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

/// Checks that both are the same mesh, and that the second has one note, with a part of it.
fn same(format: &str, good: &[u8], odd: impl AsRef<[u8]>, note: &str) {
    let (good, odd) = (read(format, good).unwrap(), read(format, odd).unwrap());
    assert_eq!(good.mesh, odd.mesh, "{note}");
    assert!(good.notes.is_empty(), "{:?}", good.notes);
    assert!(odd.notes.len() == 1 && odd.notes[0].contains(note), "{note}: {:?}", odd.notes);
}

#[test]
fn stl_beside_the_rule() {
    let (binary, ascii) = (stl_binary(), text(stl_text()));
    for over in [&b"\n"[..], &[1; 49], &[0; 512]] {
        same("stl", &binary, [&binary, over].concat(), "bytes after the last triangle");
    }
    // Another triangle that the header does not count would be lost.
    assert!(read("stl", [&binary[..], &[1; 50]].concat()).unwrap_err().contains("not 234"));
    let mut none = binary.clone();
    none[80..84].fill(0);
    same("stl", &binary, &none, "counts 0 triangles");
    assert!(read("stl", &none[..none.len() - 1]).unwrap_err().contains("0 triangles has 84 bytes"));
    same("stl", ascii.as_bytes(), ascii.replace("endsolid", "end solid"), "end solid");
    same("stl", ascii.as_bytes(), ascii.replace("endloop", "END LOOP"), "end solid");
    same("stl", ascii.as_bytes(), ascii.trim_end_matches("endsolid\n"), "before its last endsolid");
    same("stl", ascii.as_bytes(), ascii.clone() + "\0\0\0", "NULs after the text");
    assert!(read("stl", ascii.replacen("outer", "\0uter", 1)).is_err());
}

#[test]
fn off_beside_the_rule() {
    let off = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    let good = off.as_bytes();
    same("off", good, off.replace("OFF\n", "OFF"), "no space after OFF");
    same("off", good, off.replace("OFF\n", "  OFF").replace("4 2 0", "4 2 0 # two"), "no space");
    same("off", good, off.replace("OFF", "off"), "capitals");
    same("off", good, off.replace('\n', " "), "follow the counts");
    same("off", good, off.replace("0\n0 0 0\n", "0 0\n0\n0 "), "follow the counts");
    same("off", good, off.to_owned() + "\0", "NULs");
    let rewrapped = off.replace("0\n1 1 0\n", "0 1 1\n0 ").replace("3 0 2 3", "3\n0\n2 3");
    same("off", good, rewrapped, "lines do not end where");
    assert!(read("off", off.replace('\n', " ") + "3 0 1 3").unwrap_err().contains("goes on"));
    assert!(read("off", off.replace('\n', " ").replace("3 0 2 3", "3 0 2")).is_err());
    // The numbers of colours cannot be told from others.
    assert!(read("off", off.replace("OFF", "COFF").replace('\n', " ")).is_err());
}

#[test]
fn faces_of_one_or_two_corners_are_passed_over() {
    let note = "faces of one or two corners are passed over: 2";
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    same("obj", obj.as_bytes(), obj.replace("f 1 2 3", "f 1 2\nf 1\nf 1 2 3"), note);
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
    let more = off.replace("3 1 0", "3 3 0").replace("3 0 1 2", "2 0 1\n3 0 1 2\n1 2");
    same("off", off.as_bytes(), &more, note);
    // Numbers of faces are those of the file.
    assert_eq!(read("off", more).unwrap().source.face(0), 1);
    let ply = text(ply("ascii", None));
    let more = ply.replace("face 1", "face 3").replace("4 2 1 3 0", "2 0 1\n4 2 1 3 0\n1 2");
    same("ply", ply.as_bytes(), more, note);
}

#[test]
fn vertices_that_no_face_uses_may_be_nan() {
    let square = text(ply("ascii", None));
    let odd = read("ply", square.replace("7 7 7", "nan .5 -inf")).unwrap();
    assert_eq!(odd.mesh.triangles, QUAD);
    assert_eq!(odd.mesh.positions[4], odd.mesh.positions[2]);
    assert!(odd.notes[0].contains("not finite"), "{:?}", odd.notes);
    for nan in ["-nan(ind)", "NaN(0x1)", "-inf"] {
        assert!(read("ply", square.replace("7 7 7", &format!("7 7 {nan}"))).is_ok(), "{nan}");
    }
    let error = read("ply", square.replace("0 1 16777216", "0 nan 0")).unwrap_err();
    assert!(error.contains("line 18: vertex 3 has a NaN"), "{error}");
}

#[test]
fn strips_are_read() {
    let with = |list: &str| read("ply", ply_strips().replace("8 0 1 2 3 -1 2 3 4", list));
    assert_eq!(
        with("8 0 1 2 3 -1 2 3 4").unwrap().mesh.triangles,
        [[0, 1, 2], [2, 1, 3], [2, 3, 4]]
    );
    // Triangles with a corner twice only lead to the next.
    let stitched = with("7 0 1 2 2 2 3 4").unwrap();
    assert_eq!(stitched.mesh.triangles, [[0, 1, 2], [2, 3, 4]]);
    assert!(with("3 0 1 5").unwrap_err().contains("no vertex 5"));
    let over = with("3 0 1 2\n3 0 1 2").unwrap();
    assert!(over.notes[0].contains("lines after the last element"), "{:?}", over.notes);
}

#[test]
fn gltf_is_read_as_it_is_used() {
    let good = text(gltf());
    let required = |name| {
        good.replace("{\"asset\"", &format!("{{\"extensionsRequired\":[\"{name}\"],\"asset\""))
    };
    for name in ["KHR_texture_transform", "EXT_texture_webp", "KHR_materials_unlit"] {
        same("gltf", good.as_bytes(), required(name), name);
    }
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_unheard_of"] {
        assert!(read("gltf", required(name)).unwrap_err().contains(name));
    }
    let bounds = "\"min\":[0,0,0],\"max\":[1,1,0]";
    let bare = good.replacen(&format!(",\n                      {bounds}"), "", 1);
    assert_ne!(bare, good);
    same("gltf", good.as_bytes(), bare, "no min and max");
    let unused =
        good.replace("\"meshes\"", "\"materials\":[{\"normalTexture\":{\"index\":9}}],\"meshes\"");
    assert_eq!(read("gltf", unused).unwrap().mesh, read("gltf", &good).unwrap().mesh);
    // Draco data without others is not taken for zeros.
    let draco = good.replace(
        "{\"POSITION\":0}}",
        "{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":{}}}",
    );
    assert_eq!(read("gltf", &draco).unwrap().mesh, read("gltf", &good).unwrap().mesh);
    let empty = draco.replacen("\"bufferView\":0,", "", 1);
    let error = read("gltf", empty).unwrap_err();
    assert!(error.contains("KHR_draco_mesh_compression"), "{error}");
}

#[test]
fn trailing_bytes_of_a_glb_are_passed_over() {
    same("glb", &glb(), [&glb()[..], b"\n"].concat(), "bytes of the header");
}

#[test]
fn vertices_are_joined_as_the_format_needs() {
    let two = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 1e-7\nf 1 2 3\nf 4 5 6\n";
    let vertices = |text: &str, weld| read_as("obj", text, weld).unwrap().mesh.positions.len();
    let with_normals = two.replace("f 4 5 6", "f 4//1 5//1 6//1");
    for (text, weld, expected) in [
        (two, Weld::Split, 6),
        (&with_normals, Weld::Split, 5),
        (&with_normals, Weld::Never, 6),
        (two, Weld::Within(0.0), 5),
        (two, Weld::Within(1e-6), 4),
        (two, Weld::Within(f64::MAX), 1),
    ] {
        assert_eq!(vertices(text, weld), expected, "{weld:?}");
    }
    let near = read_as("obj", two, Weld::Within(1e-6)).unwrap();
    assert_eq!(near.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
    assert!(near.notes[0].contains("nearby: 1"), "{:?}", near.notes);
}
