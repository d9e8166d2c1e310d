//! Input: standard input, formats, digits that f32 does not hold, faces and nodes, bounds of memory.

use super::scene::ROOM;
use super::{TETRAHEDRON, command, folder, out, pfront, refused};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// Standard output and standard error, with a file as standard input.
fn fed(folder: &Path, arguments: &str, file: &str) -> [String; 2] {
    let file = fs::File::open(folder.join(file)).unwrap();
    let ended = command(folder, arguments).stdin(Stdio::from(file)).output().unwrap();
    [ended.stdout, ended.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
}

#[test]
fn standard_input_is_a_mesh() {
    let folder = folder();
    let at = folder.path();
    let expected = ["a,b\n0,0\n3,0\n".to_owned(), String::new()];
    for arguments in ["pairs - b.obj --csv", "pairs - b.obj --csv --input-format obj"] {
        assert_eq!(fed(at, arguments, "a.obj"), expected);
    }
    out(at, "bake a.obj");
    assert_eq!(fed(at, "pairs - b.obj --csv", "a.pfb"), expected);
    fs::write(at.join("room.gltf"), ROOM).unwrap();
    assert_eq!(fed(at, "self - --csv", "room.gltf")[0], "a,b\n0,1\n");
    fs::rename(at.join("a.obj"), at.join("a.txt")).unwrap();
    assert_eq!(out(at, "pairs a.txt b.obj --csv --input-format obj"), expected[0]);
    fs::write(at.join("words"), "hello, this is no mesh").unwrap();
    assert!(fed(at, "self -", "words")[1].contains("--input-format"));
    if cfg!(target_os = "linux") {
        assert!(fed(at, "self - --out b.obj", "b.obj")[1].contains("would replace a mesh"));
    }
    fs::write(at.join("nothing"), "").unwrap();
    assert_eq!(fed(at, "self -", "nothing")[1], "error: -: is empty\n");
    assert!(refused(at, "self a.obj --input-format docx").contains("input-format"));
}

#[cfg(unix)]
#[test]
fn a_device_without_end_is_refused() {
    let folder = folder();
    assert!(refused(folder.path(), "self /dev/zero").contains("unknown format"));
    let error = refused(folder.path(), "self /dev/zero --input-format stl --memory 1");
    assert!(error.contains("goes on after 1000000 bytes"), "{error}");
    for format in ["obj", "off", "ply", "gltf", "glb", "3mf", "pfb"] {
        let error = refused(folder.path(), &format!("self /dev/zero --input-format {format}"));
        assert!(error.contains("/dev/zero"), "{error}");
    }
}

#[test]
fn digits_that_are_lost_are_counted() {
    let folder = folder();
    let at = folder.path();
    // Nine digits of an f32, more zeros than it needs, and what any f32 is nearest to: nothing is lost.
    for kept in
        ["0.100000001", "1.0000000000", "0.2", "123456", "16777216", "1e-7", "3.40282347e38"]
    {
        fs::write(at.join("a.obj"), TETRAHEDRON.replace("v 0 0 1\n", &format!("v 0 0 {kept}\n")))
            .unwrap();
        out(at, "self a.obj --f32");
    }
    for lost in ["0.10000000000000001", "0.123456789", "16777217", "1e-60", "1.00000001"] {
        fs::write(
            at.join("a.obj"),
            TETRAHEDRON.replace("v 0 0 1\n", &format!("v {lost} 0 {lost}\n")),
        )
        .unwrap();
        // In f64 they are not lost.
        out(at, "self a.obj");
        let told = String::from_utf8(pfront(at, "self a.obj --f32").stderr).unwrap();
        assert!(told.contains("a.obj: 2 of 12 coordinates were rounded to f32"), "{lost}: {told}");
    }
    let double = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                  property double z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let numbers = [0.1, 0.5, 0.25, 1.0, 0.0, 0.0, 0.0, 1.0, 1e-300].map(f64::to_le_bytes).concat();
    fs::write(at.join("double.ply"), [double.as_bytes(), &numbers, &[3, 0, 1, 2]].concat())
        .unwrap();
    out(at, "self double.ply");
    out(at, "bake double.ply");
    for file in ["double.ply", "double.pfb"] {
        let told = String::from_utf8(pfront(at, &format!("self {file} --f32")).stderr).unwrap();
        assert!(told.contains("2 of 9"), "{told}");
    }
}

/// A floor of squares of a metre somewhere on earth, and a blade that ends a micrometre above or below it.
#[test]
fn decimals_decide_as_they_are_written() {
    let folder = folder();
    let at = folder.path();
    let floor = "v 500000.1 5000000.2 300.3\nv 500001.1 5000000.2 300.3\nv 500000.1 5000001.2 300.3\nf 1 2 3\n";
    let blade = |z: &str| {
        let foot = format!("v 500000.3 5000000.4 {z}\n");
        format!("{foot}v 500000.3 5000000.4 301\nv 500000.4 5000000.4 301\nf 1 2 3\n")
    };
    fs::write(at.join("floor.obj"), floor).unwrap();
    fs::write(at.join("over.obj"), blade("300.300001")).unwrap();
    fs::write(at.join("under.obj"), blade("300.299999")).unwrap();
    let none = "a,b\n";
    for (asked, found) in [
        ("pairs floor.obj over.obj", none),
        ("pairs floor.obj under.obj", "a,b\n0,0\n"),
        ("pairs floor.obj over.obj --translate 0,0,-0.000002", "a,b\n0,0\n"),
        ("pairs floor.obj under.obj --translate 0,0,0.000002", none),
        ("pairs floor.obj under.obj --pose 1,0,0,0,0,1,0,0,0,0,1,2e-6", none),
        ("pairs floor.obj under.obj --backend gpu", "a,b\n0,0\n"),
        ("scene floor.obj over.obj", "body_a,body_b,a,b\n"),
        ("scene floor.obj under.obj", "body_a,body_b,a,b\nfloor.obj,under.obj,0,0\n"),
    ] {
        assert_eq!(out(at, &format!("{asked} --csv")), found, "{asked}");
    }
    // Baked, it is in f64 still.
    for name in ["floor", "under"] {
        let told = out(at, &format!("bake {name}.obj"));
        assert!(told.contains("in f64"), "{told}");
    }
    assert_eq!(out(at, "pairs floor.pfb under.pfb --csv"), "a,b\n0,0\n");
    assert_eq!(out(at, "pairs floor.pfb over.obj --csv"), none);
    // Contacts and curves have all digits.
    let contacts = out(at, "pairs floor.obj under.obj --csv --contacts");
    assert!(
        contacts.contains("0,0,crossing,500000.3") && contacts.contains(",300.3"),
        "{contacts}"
    );
    out(at, "pairs floor.obj under.obj --out curve.obj");
    let curve = fs::read_to_string(at.join("curve.obj")).unwrap();
    assert!(curve.lines().filter(|line| line.ends_with(" 300.3")).count() == 2, "{curve}");
    out(at, "pairs floor.obj under.obj --out hits.ply");
    let picture = fs::read(at.join("hits.ply")).unwrap();
    assert!(picture.windows(17).any(|line| line == b"property double x"));
    // To the GPU of a scene nobody in f64 goes.
    let told =
        String::from_utf8(pfront(at, "scene floor.obj over.obj --backend gpu").stderr).unwrap();
    assert!(
        told.contains("about f64, and within a distance, a GPU answers for two models only"),
        "{told}"
    );
}

#[test]
fn faces_and_nodes_are_named() {
    let folder = folder();
    let at = folder.path();
    // A square, a triangle, a square; the second triangle of the last is the fifth.
    let faces = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\nf 1 2 3 4\n";
    fs::write(at.join("faces.obj"), faces).unwrap();
    let blade = "v 0.1 0.5 -1\nv 0.2 0.5 -1\nv 0.1 0.5 1\nf 1 2 3\n";
    fs::write(at.join("blade.obj"), blade).unwrap();
    assert_eq!(
        out(at, "pairs faces.obj blade.obj --csv --source"),
        "a,b,face_a,face_b\n1,0,0,0\n4,0,2,0\n"
    );
    fs::write(at.join("room.gltf"), ROOM).unwrap();
    assert_eq!(
        out(at, "self room.gltf --csv --source"),
        "body_a,body_b,a,b,face_a,face_b\nDoor,\"Wall, old\",0,1,0,0\n"
    );
    fs::write(at.join("doors.gltf"), ROOM.replace("Wall, old", "Door")).unwrap();
    assert_eq!(
        out(at, "self doors.gltf --csv --source"),
        "body_a,body_b,a,b,face_a,face_b\nDoor,Door (2),0,1,0,0\n"
    );
    assert_eq!(out(at, "scene doors.gltf --csv"), "body_a,body_b,a,b\nDoor,Door (2),0,0\n");
    assert!(out(at, "self room.gltf --json --source").contains(
        "\"pairs\":[{\"bodies\":[\"Door\",\"Wall, old\"],\"a\":0,\"b\":1,\"faces\":[0,0]}],\"count\":1}"
    ));
}

/// A small file that says that it is large, as often as it likes.
#[test]
fn readers_have_one_budget() {
    let folder = folder();
    let at = folder.path();
    // Two thousand nodes of a thousand triangles, of three indices each: 72 MB and what it takes to get there.
    let indices = "AAABAAIA".repeat(1000);
    let bomb = ROOM
        .replace("{\"nodes\":[0,1,2,3]}", &format!("{{\"nodes\":{:?}}}", (0..2000).collect::<Vec<_>>()))
        .replace("\"POSITION\":0}", "\"POSITION\":0},\"indices\":1")
        .replace("\"max\":[1,1,0]}", "\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,\"count\":3000,\"type\":\"SCALAR\"}")
        .replace("\"byteLength\":36}],", "\"byteLength\":36},{\"buffer\":1,\"byteLength\":6000}],")
        .replace("AAAAAAAAgD8AAAAA\"}", &format!("AAAAAAAAgD8AAAAA\"}},{{\"byteLength\":6000,\"uri\":\"data:application/octet-stream;base64,{indices}\"}}"));
    let (head, rest) = bomb.split_once("\"nodes\":[{").unwrap();
    let tail = rest.split_once("],\n    \"meshes\"").unwrap().1;
    let nodes = vec!["{\"mesh\":0}"; 2000].join(",");
    fs::write(at.join("bomb.gltf"), format!("{head}\"nodes\":[{nodes}],\n    \"meshes\"{tail}"))
        .unwrap();
    let error = refused(at, "bake bomb.gltf");
    assert!(
        error.contains("bomb.gltf: needs more than 6") && error.contains("--memory"),
        "{error}"
    );
    // Baking counts too, after reading.
    let error = refused(at, "bake bomb.gltf --memory 150 --build morton");
    assert!(
        error.contains("baking 2000000 triangles takes 152 MB, and 150 are allowed"),
        "{error}"
    );
    assert!(out(at, "bake bomb.gltf --memory 300 --build morton").contains("2000000 triangles"));
}

/// Files below the bound, whose triangles are not.
#[test]
fn memory_bounds_every_reader() {
    let folder = folder();
    let at = folder.path();
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    let faces = "3 0 1 2\n".repeat(25_000);
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 25000\nproperty list uchar int vertex_indices\nend_header\n";
    let facet = "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let binary = [&[0; 80][..], &15_000_u32.to_le_bytes(), &vec![0; 15_000 * 50]].concat();
    for (file, bytes) in [
        ("m.obj", ("v 0 0 0\n".repeat(3) + &"f 1 2 3\n".repeat(25_000)).into_bytes()),
        ("m.off", format!("OFF\n3 25000 0\n{corners}{faces}").into_bytes()),
        ("m.ply", format!("{header}{corners}{faces}").into_bytes()),
        ("text.stl", format!("solid\n{}endsolid\n", facet.repeat(8000)).into_bytes()),
        ("binary.stl", binary),
    ] {
        assert!(bytes.len() < 1_000_000);
        fs::write(at.join(file), bytes).unwrap();
        let error = refused(at, &format!("bake {file} --memory 1"));
        assert!(error.contains("needs more than 1 MB") && error.contains("--memory"), "{error}");
        out(at, &format!("bake {file} --memory 20"));
    }
    for file in ["a.obj", "m.pfb"] {
        assert!(refused(at, &format!("self {file} --memory 0")).contains("goes on after 0 bytes"));
    }
}

#[test]
fn an_answer_that_does_not_fit_is_an_error() {
    let folder = folder();
    let at = folder.path();
    // A face of 2,000 corners in one place: its 1,998 triangles meet each other.
    let face: String = (1..=2000).map(|i| format!(" {i}")).collect();
    fs::write(at.join("face.obj"), "v 0 0 0\n".repeat(2000) + "f" + &face + "\n").unwrap();
    for (command, pairs) in [
        ("self face.obj", "1993006"),
        ("pairs face.obj face.obj", "3992004"),
        ("scene face.obj face.obj", "3992004"),
    ] {
        let error = refused(at, &format!("{command} --memory 40"));
        assert!(
            error.contains(&format!("{pairs} pairs")) && error.contains("40 are allowed"),
            "{error}"
        );
    }
    let rows = String::from_utf8(pfront(at, "self face.obj --memory 48 --csv").stdout).unwrap();
    assert_eq!(rows.lines().count(), 1_993_007);
}
