//! Files that are not as their format says: read with a note where nothing is lost, and refused where something is.

use super::samples::*;
use super::text;
use pfront::Model;
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
    // A solid in one line, or a facet.
    let named = ascii.replacen("solid\n", "solid a facet\n", 1);
    let split = |text: &str| {
        text.replacen("endsolid\n", "endsolid@", 1).replace('\n', " ").replace('@', "\n")
    };
    let (whole, in_lines) = (read("stl", &named).unwrap(), read("stl", split(&named)).unwrap());
    assert_eq!((&in_lines.mesh, in_lines.source.bodies()), (&whole.mesh, whole.source.bodies()));
    assert_eq!(whole.source.bodies()[0], "a facet");
    assert!(read("stl", named.replace('\n', " ")).unwrap_err().contains("where another ends"));
    assert!(read("stl", ascii.replacen("outer", "\0uter", 1)).is_err());
}

#[test]
fn off_beside_the_rule() {
    let off = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    let good = off.as_bytes();
    same("off", good, off.replace("OFF\n", "OFF"), "no space after OFF");
    same("off", good, off.replace("OFF\n", "  OFF").replace("4 2 0", "4 2 0 # two"), "no space");
    same("off", good, off.replace("OFF", "off"), "capitals");
    same("off", good, off.replace("OFF\n", ""), "the header OFF is missing");
    same("off", good, off.replace('\n', " "), "follow the counts");
    same("off", good, off.replace("0\n0 0 0\n", "0 0\n0\n0 "), "follow the counts");
    same("off", good, off.to_owned() + "\0", "NULs");
    assert!(read("off", off.replace("OFF\n", "nOFF 3\n")).unwrap_err().contains("n dimensions"));
    let rewrapped = off.replace("0\n1 1 0\n", "0 1 1\n0 ").replace("3 0 2 3", "3\n0\n2 3");
    same("off", good, rewrapped, "lines do not end where");
    assert!(read("off", off.replace('\n', " ") + "3 0 1 3").unwrap_err().contains("goes on"));
    assert!(read("off", off.replace('\n', " ").replace("3 0 2 3", "3 0 2")).is_err());
    // The numbers of colours cannot be told from others.
    assert!(read("off", off.replace("OFF", "COFF").replace('\n', " ")).is_err());
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

#[test]
fn obj_beside_the_rule() {
    let good = SQUARE.as_bytes();
    let units = SQUARE.encode_utf16();
    let [little, big] = [[0xff, 0xfe], [0xfe, 0xff]].map(|mark| mark.to_vec());
    let little =
        units.clone().fold(little, |text, unit| [text, unit.to_le_bytes().to_vec()].concat());
    let big = units.fold(big, |text, unit| [text, unit.to_be_bytes().to_vec()].concat());
    same("obj", good, &little, "UTF-16");
    same("obj", good, &big, "UTF-16");
    assert!(read("obj", &little[..little.len() - 1]).unwrap_err().contains("UTF-16"));
    for (lines, note) in [
        (
            "smooth 1\nmove 2\n",
            "no statements of OBJ are passed over: 2, the first is 'smooth' in line 6",
        ),
        (
            "p 1\nl 1 2\n",
            "points, lines, surfaces and other files are passed over: 2, the first is 'p' in line 6",
        ),
        ("call other.obj\n", "the first is 'call' in line 6"),
    ] {
        same("obj", good, SQUARE.to_owned() + lines, note);
    }
    let usual = SQUARE.to_owned() + "vt 0 0\nvn 0 0 1\nusemtl a\nmtllib b\ns off\n";
    assert!(read("obj", usual).unwrap().notes.is_empty());
}

#[test]
fn headers_of_ply_may_have_other_lines_before_their_elements() {
    let ply = text(ply("ascii", None));
    let odd = ply.replace("comment a square", "Made by hand");
    same("ply", ply.as_bytes(), &odd, "lines of the header that are no statements");
    // After an element it could be a property.
    let later = ply.replace("element face", "Made by hand\nelement face");
    assert!(read("ply", later).unwrap_err().contains("line 11: 'Made' is no statement of PLY"));
    for (from, to, what) in [
        (
            "uchar int vertex_indices",
            "uchar word vertex_indices",
            "line 12: 'word' is no type of PLY",
        ),
        ("format ascii", "format utf8", "line 2: 'utf8' is no format"),
        ("end_header", "the end", "no statement"),
        (
            "property list uchar int vertex_indices\n",
            "property list uchar int vertex_indices\nproperty list uchar int vertex_index\n",
            "same name",
        ),
    ] {
        assert!(ply.contains(from));
        let error = read("ply", ply.replace(from, to)).unwrap_err();
        assert!(error.contains(what), "{error}");
    }
    let mac = ply.replace('\n', "\r");
    assert_eq!(read("ply", mac).unwrap().mesh, read("ply", ply).unwrap().mesh);
}

#[test]
fn rounding_to_f32_is_counted() {
    let rounded = |format: &str, bytes: &[u8]| {
        let format = Some(format.to_owned());
        let options = ReadOptions { format, in_f32: true, ..ReadOptions::default() };
        let Contents::Mesh(file) = read_bytes(bytes, &options).unwrap() else { panic!("baked") };
        assert_eq!(file.mesh.beyond_f32(), 0);
        file.notes.concat()
    };
    let third = f64::from(1.0_f32 / 3.0);
    let obj = format!("v 0.1 {third} 0.333333333333\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(rounded("obj", obj.as_bytes()).starts_with("1 of 9 coordinates were rounded"));
    // A node that moves by 1/10 rounds what it places.
    let moved = text(gltf()).replace("{\"mesh\":0}", "{\"mesh\":0,\"translation\":[0.1,0,0]}");
    assert!(rounded("gltf", moved.as_bytes()).starts_with("1 of 21 coordinates"));
    let model =
        Model::from_f64(vec![[0.1, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let blob = model.unwrap().to_blob().unwrap();
    assert!(rounded("pfb", &blob).starts_with("1 of 9 coordinates"));
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
    for nan in ["-nan(ind)", "NaN(0x1)", "-inf", "1.#IND", "-1.#IND00", "1.#QNAN", "-1.#INF"] {
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
    let other = ply_strips().replace("element tristrips", "element trifans");
    let with_face = other
        .replace("end_header", "element face 1\nproperty list int int vertex_index\nend_header");
    let other = read("ply", with_face + "3 0 1 2\n").unwrap();
    assert_eq!(other.notes, ["elements trifans are passed over: 1"]);
    let over = with("3 0 1 2\n3 0 1 2").unwrap();
    assert!(over.notes[0].contains("lines after the last element"), "{:?}", over.notes);
}

#[test]
fn gltf_is_read_as_it_is_used() {
    let good = text(gltf());
    let required = |name| {
        good.replace("{\"asset\"", &format!("{{\"extensionsRequired\":[\"{name}\"],\"asset\""))
    };
    for name in ["KHR_texture_transform", "EXT_texture_webp", "KHR_technique_webgl"] {
        same("gltf", good.as_bytes(), required(name), name);
    }
    let first = "{\"asset\":{\"version\":\"1.0\"},\"meshes\":{\"a\":{}}}";
    for (format, bytes) in [("gltf", first.as_bytes()), ("glb", b"glTF\x01\0\0\0\x40\0\0\0")] {
        assert!(read(format, bytes).unwrap_err().contains("glTF 1 is not read"));
    }
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_unheard_of"] {
        assert!(read("gltf", required(name)).unwrap_err().contains(name));
    }
    // Beside geometry, a document may be as it likes.
    for (from, to) in [
        (r#""POSITION":1}"#, r#""POSITION":1,"BATCHID":7,"COLOR":0}"#),
        (r#""accessors":["#, r#""materials":[{"alphaMode":"so"}],"accessors":["#),
        (
            r#""max":[1,1,0]}]"#,
            r#""max":[1,1,0]},{"bufferView":7,"componentType":5130,"count":1,"type":"VEC5"}]"#,
        ),
        (r#""byteLength":48}],"#, r#""byteLength":48,"target":0}],"#),
        (r#""scenes":[{"nodes":[0,1]}]"#, r#""scenes":[{"nodes":[0,1]},{"name":"empty"}]"#),
    ] {
        assert!(good.contains(from), "{from}");
        let odd = read("gltf", good.replace(from, to)).unwrap_or_else(|e| panic!("{to}: {e}"));
        assert_eq!((odd.mesh, odd.notes), (read("gltf", &good).unwrap().mesh, Vec::new()), "{to}");
    }
    for (from, to) in [
        (r#""accessors":["#, r#""animations":[{"channels":[],"samplers":9}],"accessors":["#),
        (r#"{"asset":{"version":"2.0"},"#, "{"),
    ] {
        same("gltf", good.as_bytes(), good.replacen(from, to, 1), "no geometry");
    }
    for list in ["[]", "3", "{\"asset\":{}", "{\"meshes\":[{\"primitives\":4}]}"] {
        assert!(read("gltf", list).is_err(), "{list}");
        let json = format!("{list:40}");
        let length = (20 + json.len() as u32).to_le_bytes();
        let chunk = [&(json.len() as u32).to_le_bytes()[..], b"JSON", json.as_bytes()].concat();
        assert!(read("glb", [b"glTF\x02\0\0\0", &length[..], &chunk].concat()).is_err(), "{list}");
    }
    let mark = "\u{feff}".to_owned() + &good;
    assert_eq!(read("gltf", mark).unwrap().mesh, read("gltf", &good).unwrap().mesh);
    same("gltf", good.as_bytes(), good.clone() + "\0", "NULs");
    let nothing = good.replace("{\"mesh\":0}", "{\"mesh\":0,\"rotation\":[0,0,0,0]}");
    assert!(read("gltf", nothing).unwrap_err().contains("node 0: a rotation"));
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
