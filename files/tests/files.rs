//! Mesh files: order and coordinates are kept, faults are found where they are, nothing panics.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "files/bodies.rs"]
mod bodies;
#[path = "files/faces.rs"]
mod faces;
#[path = "files/gltf.rs"]
mod gltf;
#[path = "files/lenient.rs"]
mod lenient;
#[path = "files/samples.rs"]
mod samples;
#[path = "files/threemf.rs"]
mod threemf;

use pfront::Model;
use pfront_files::{
    Contents, PaintedMesh, ReadError, ReadOptions, Remedy, TriangleMesh, Weld, open, read_bytes,
    read_f32, write_painted,
};
use pfront_testkit::rng::{Rng, RngExt, seeded};
use samples::*;
use std::fs;
use tempfile::TempDir;

fn parse(name: &str, bytes: impl AsRef<[u8]>) -> Result<TriangleMesh<f32>, ReadError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_f32(&path)
}

fn fault(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = parse(name, bytes).unwrap_err().to_string();
    assert!(error.contains(name), "{error}");
    error
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap()
}

fn quad() -> TriangleMesh<f32> {
    TriangleMesh { positions: POSITIONS.to_vec(), triangles: QUAD.to_vec() }
}

#[test]
fn every_format_keeps_order_and_bits() {
    for (name, bytes) in [
        ("square.obj", obj()),
        ("square.OFF", off()),
        ("text.ply", ply("ascii", None)),
        ("little.ply", ply_little()),
        ("big.ply", ply_big()),
    ] {
        assert_eq!(parse(name, bytes).unwrap(), quad(), "{name}");
    }
    for (name, bytes) in [("text.stl", stl_text()), ("binary.STL", stl_binary())] {
        let mesh = parse(name, bytes).unwrap();
        // Corners at one place are one vertex.
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{name}");
        assert_eq!(mesh.positions, [2, 1, 3, 0].map(|v: usize| POSITIONS[v]), "{name}");
    }
}

/// In f64 nothing is rounded but to the nearest f64, in any format.
#[test]
fn decimals_and_doubles_are_kept_in_f64() {
    let folder = TempDir::new().unwrap();
    let load = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        open(&path, &ReadOptions::default()).unwrap().into_mesh(&path).unwrap().mesh
    };
    let exact = ["0.1", "-2.5000000000000004e10", "500000.123456789"];
    let written = exact.map(|x| x.parse::<f64>().unwrap());
    for (name, bytes) in
        [("a.obj", obj()), ("a.off", off()), ("a.ply", ply("ascii", None)), ("a.stl", stl_text())]
    {
        // The first vertex of the second face.
        let old = "1 0 -25000000000";
        let text = text(bytes).replace("-2.5e10", "-25000000000");
        assert!(text.contains(old), "{name}");
        let mesh = load(name, text.replace(old, &exact.join(" ")).into_bytes());
        let bits = |corner: &[f64; 3]| corner.map(f64::to_bits);
        assert!(mesh.positions.iter().any(|p| bits(p) == bits(&written)), "{name}");
        assert!(mesh.beyond_f32() >= 3, "{name}");
    }
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                  property double z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let three = [written; 3];
    let numbers = three.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let bytes = header.bytes().chain(numbers).chain([3, 0, 1, 2]).collect();
    assert_eq!(load("double.ply", bytes).positions, three);
    // Positions that f32 holds need no f64.
    for (name, bytes) in [("b.stl", stl_binary()), ("b.ply", ply_little())] {
        assert_eq!(load(name, bytes).beyond_f32(), 0, "{name}");
    }
}

/// The crates that read these formats refuse such text or take it for something else.
#[test]
fn unusual_text_is_read() {
    assert_eq!(
        parse("mac.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r").unwrap().triangles.len(),
        1
    );
    let square = text(ply("ascii", None));
    let half = parse("a.ply", square.replace("7 7 7", ".5 7. 7")).unwrap().positions[4];
    assert_eq!(half, [0.5, 7.0, 7.0]);
    // Rounded to f64 first this is half way, and goes to 1.
    let doubles = square.replace("float", "double").replace("7 7 7", "1.00000005960464477540 7 7");
    assert_eq!(parse("a.ply", doubles).unwrap().positions[4], [1.0 + f32::EPSILON, 7.0, 7.0]);
    let stl = text(stl_text()).to_uppercase().replace("SOLID\n", "SOLID a#1\n");
    assert_eq!(parse("a.stl", stl).unwrap().triangles.len(), 2);
}

#[test]
fn gltf_places_its_nodes() {
    let mesh = parse("scene.gltf", gltf()).unwrap();
    assert_eq!(parse("scene.glb", glb()).unwrap(), mesh);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5], [5, 4, 6]]);
    assert_eq!(mesh.positions[..3], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.positions[6], [1.0, 3.0, 5.0]);
}

#[test]
fn faults_of_obj_and_off() {
    let obj = text(obj());
    assert!(fault("a.obj", obj.replace("1e-7", "1e--7")).contains("line 4: '1e--7'"));
    assert!(fault("b.obj", obj.replace("-2.5e10", "")).contains("line 5"));
    // A face that goes on in the next line, and one that names a vertex of the future's future.
    assert!(fault("c.obj", obj.replace("4/1 -4", "0")).contains("line 11: there is no vertex 0"));
    assert!(fault("d.obj", obj.replace("4/1 -4", "-9")).contains("line 11: there is no vertex -9"));
    assert!(fault("e.obj", obj.replace("4/1 -4", "6")).contains("line 11: vertex 6 of 5"));
    assert!(fault("f.obj", "v 0 0 0\nf 1 1\n").contains("no triangle"));
    let off = text(off());
    assert!(fault("a.off", off.replace("COFF", "4OFF")).contains("line 1"));
    assert!(
        fault("b.off", off.replace("4 2 1 3 0 ", "4 2 1 3 5 "))
            .contains("line 9: there is no vertex 5")
    );
    assert!(fault("c.off", off.replace("5 1 0", "6 1 0")).contains("the file ends before"));
    assert!(fault("d.off", "OFF BINARY\n").contains("convert"));
    assert!(fault("a.txt", "words").contains("known are obj, ply, stl, off, gltf, glb"));
    assert!(fault("b.txt", "").ends_with("b.txt: is empty"));
}

#[test]
fn faults_of_ply() {
    let ply = text(ply("ascii", None));
    assert!(fault("a.ply", ply.replace("float z", "float w")).contains("no z"));
    assert!(fault("b.ply", ply.replace("vertex_indices", "corners")).contains("no vertex_indices"));
    assert!(fault("c.ply", ply.replace("4 2 1 3 0", "2 2 1")).contains("no triangle"));
    assert!(
        fault("d.ply", ply.replace("4 2 1 3 0", "4 2 1 3 -1"))
            .contains("line 20: face 0: -1 is no index")
    );
    assert!(fault("f.ply", ply.replace("\n7 7 7 1", "")).contains("the file ends in face 0 of 1"));
    assert!(fault("g.ply", ply.replace("element note", "elephant note")).contains("line 5"));
    assert!(fault("h.ply", ply.replace("float confidence", "float x")).contains("the same name"));
    let strips = ply.replace("element note", "element tristrips");
    assert!(fault("i.ply", strips).contains("tristrips has no vertex_indices"));
    let (little, end) = (ply_little(), ply_little().len());
    let face = format!("byte {}: ", end - 17);
    assert!(fault("j.ply", &little[..end - 1]).contains(&format!("{face}the file ends in face 0")));
    let negative = [&little[..end - 1], &[0xff]].concat();
    assert!(fault("k.ply", negative).contains(&format!("{face}face 0: -16777216 is no index")));
    assert!(
        fault("e.ply", ply.replace("element note 1", "element none 4000000000\nelement note 1"))
            .contains("none")
    );
}

#[test]
fn faults_of_stl() {
    let mut stl = stl_binary();
    stl[..80].fill(0);
    assert!(fault("a.stl", &stl[..150]).contains("184 bytes, not 150"));
    stl[..5].copy_from_slice(b"solid");
    assert!(fault("b.stl", &stl[..150]).contains("184 bytes, not 150"));
    let remedy = |bytes: &[u8]| parse("b.stl", bytes).unwrap_err().remedy();
    assert_eq!(remedy(&stl[..150]), Some(Remedy::Format));
    assert_eq!(remedy(b"hello"), Some(Remedy::Format));
    let stl = text(stl_text());
    assert_eq!(remedy(stl.replacen("outer", "inner", 1).as_bytes()), Some(Remedy::Format));
    let cut = stl.trim_end_matches("endfacet\nendsolid\n");
    assert!(fault("c.stl", cut).contains("ends within a facet"));
    assert!(fault("d.stl", stl.replacen("vertex", "vertex x", 1)).contains("line 4: 'x'"));
    assert!(fault("e.stl", stl.replacen("endloop\n", "", 1)).contains("line 15: a facet of 6"));
    assert!(fault("f.stl", stl.replacen("outer", "inner", 1)).contains("line 3: 'inner'"));
}

/// At the first six `gltf` by itself panics, reads what is no position, or never ends.
#[test]
fn faults_of_gltf() {
    let gltf = text(gltf());
    let (data, indices) = (r#""uri":"data:application/octet-stream;base64,"#, r#"},"indices":1}"#);
    for (from, to, what) in [
        (r#""byteLength":48}],"#, r#""byteLength":48,"byteStride":4}],"#, "overlaps itself"),
        (r#""count":3,"type":"VEC3""#, r#""count":3,"type":"VEC4""#, "accessor 0: Vec4"),
        (r#""POSITION":0}}"#, &format!(r#""POSITION":0{indices}"#), "accessor 1: Vec3 of F32"),
        (r#""count":4"#, r#""count":0"#, "accessor 1 is empty"),
        (data, r#""uri":"%FF","was":""#, "no file"),
        (data, r#""uri":"/dev/zero","was":""#, "names the file '/dev/zero'"),
        (data, r#""uri":"http://localhost/","was":""#, "buffer 0: unsupported URI"),
        (r#""count":4"#, r#""count":5"#, "accessor 1 is empty, overlaps itself or leaves"),
        (r#""count":3"#, r#""count":2"#, "triangles of 2 corners"),
        (r#""children":[2]"#, r#""children":[1]"#, "node 1 is reached twice"),
        (r#""scenes":[{"nodes":[0,1]}],"#, "", "glTF"),
    ] {
        assert!(gltf.contains(from), "{from}");
        let error = fault("a.gltf", gltf.replacen(from, to, 1));
        assert!(error.contains(what), "{error}");
    }
    let no_scene = gltf.replace(r#""scene":0,"scenes":[{"nodes":[0,1]}],"#, "");
    assert_eq!(parse("b.gltf", no_scene).unwrap(), parse("c.gltf", gltf).unwrap());
    assert!(fault("a.glb", &glb()[..400]).contains("by its header"));
    assert_eq!(fault("empty.glb", "").split(": ").last(), Some("is empty"));
    assert!(fault("b.glb", [b"glTF\x02\0\0\0", &[0; 4][..]].concat()).contains("0 bytes"));
}

#[test]
fn gltf_reads_the_file_beside() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("scene.gltf");
    let scene = text(gltf());
    let (json, data) = scene.split_once("data:").unwrap();
    let rest = data.split_once('"').unwrap().1;
    fs::write(&path, format!("{json}my%20b%C3%BCffer.bin\"{rest}")).unwrap();
    fs::write(folder.path().join("my büffer.bin"), glb().split_last_chunk::<48>().unwrap().1)
        .unwrap();
    assert_eq!(read_f32(&path).unwrap(), parse("scene.gltf", scene).unwrap());
}

/// Changed files are read or refused; `PFRONT_MUTATIONS` says how many of each format, if not some thousands.
#[test]
fn changed_bytes_never_panic() {
    let times = std::env::var("PFRONT_MUTATIONS").map_or(3000, |times| times.parse().unwrap());
    let mut random = seeded(3);
    let samples = [
        ("obj", obj()),
        ("obj", bodies::obj("o").into_bytes()),
        ("off", off()),
        ("off", b"OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2".to_vec()),
        ("ply", ply("ascii", None)),
        ("ply", ply_little()),
        ("ply", ply_big()),
        ("ply", ply_strips().into_bytes()),
        ("stl", stl_text()),
        ("stl", stl_binary()),
        ("gltf", gltf()),
        ("glb", glb()),
        ("glb", bodies::skinned()),
        ("glb", bodies::instanced()),
        ("glb", bodies::sparse()),
        ("3mf", bodies::three_mf()),
    ];
    for (format, bytes) in samples {
        for weld in [Weld::Split, Weld::Within(0.5)] {
            let format = Some(format.to_owned());
            let options = ReadOptions { format, weld, ..ReadOptions::default() };
            for _ in 0..times {
                let mut changed = bytes.clone();
                for _ in 0..random.random_range(1..4) {
                    let at = random.random_range(0..changed.len());
                    changed[at] = match random.random_range(0..3) {
                        0 => random.next_u32() as u8,
                        1 => b"0123456789-.e \n/{}[]\"<>"[random.random_range(0..23)],
                        _ => changed[random.random_range(0..changed.len())],
                    };
                }
                changed.truncate(random.random_range(0..2 * changed.len()));
                let Ok(Contents::Mesh(file)) = read_bytes(&changed, &options) else { continue };
                // The mesh may be nonsense, but it is one.
                let TriangleMesh { positions, triangles } = file.mesh;
                let count = triangles.len();
                assert!(triangles.as_flattened().iter().all(|&v| (v as usize) < positions.len()));
                assert!(positions.as_flattened().iter().all(|x| x.is_finite()));
                let bodies = file.source.triangles(count);
                let of_bodies: usize = bodies.iter().map(Vec::len).sum();
                assert!(bodies.is_empty() || of_bodies == count, "{of_bodies} of {count}");
            }
        }
    }
}

#[test]
fn painted_meshes_come_back() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("painted.ply");
    let mesh = PaintedMesh {
        positions: &POSITIONS.map(|p| p.map(f64::from)),
        triangles: &QUAD,
        marks: &[0, 9],
        colours: &[[1, 2, 3], [4, 5, 6]],
    };
    write_painted(&mut fs::File::create(&path).unwrap(), &[mesh, mesh]).unwrap();
    let read = read_f32(&path).unwrap();
    assert_eq!(read.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]);
    assert_eq!(read.positions[9..], QUAD[1].map(|v| POSITIONS[v as usize]));
    let bytes = fs::read(&path).unwrap();
    let vertices = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    assert_eq!(bytes[vertices + 12..][..3], [1, 2, 3]);
    assert_eq!(bytes[vertices + 3 * 15 + 12..][..3], [4, 5, 6]);
}

/// A file that is not understood does not pass for a mesh that meets nothing.
#[test]
fn a_file_without_triangles_is_refused() {
    for (name, bytes, what, remedy) in [
        (
            "lfs.obj",
            &b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"[..],
            ", line 1: 'version' is no statement of OBJ",
            Some(Remedy::Format),
        ),
        (
            "cloud.obj",
            b"v 0 0 0\nvn 1 0 0\np 1\n",
            ": there is no triangle in it, but vertices: 1; \
             points, lines, surfaces and other files are passed over: 1, the first is 'p' in line 3",
            Some(Remedy::Format),
        ),
        ("empty.off", b"OFF\n0 0 0\n", ": there is no triangle in it", Some(Remedy::Format)),
        ("empty.obj", b"", ": is empty", None),
    ] {
        let error = parse(name, bytes).unwrap_err();
        assert_eq!(error.remedy(), remedy, "{error}");
        assert!(error.to_string().ends_with(&format!("{name}{what}")), "{error}");
    }
    assert!(fault("more.off", text(off()) + "3 0 1 2\n").contains("goes on after its 1 faces"));
}

#[test]
fn solids_of_one_file_are_all_read() {
    let solids = [stl_text(), stl_text()].concat();
    assert_eq!(parse("two.stl", solids).unwrap().triangles.len(), 4);
}

#[test]
fn baked_meshes_come_back_with_their_bvh() {
    let TriangleMesh { positions, triangles } = quad();
    let model = Model::new(positions, triangles).unwrap();
    let bytes = model.to_blob().unwrap();
    // A file is known by how it begins, whatever it is called.
    for name in ["square.pfb", "square.PFB", "square.obj", "square"] {
        assert_eq!(parse(name, &bytes).unwrap(), quad(), "{name}");
    }
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("square.pfb");
    fs::write(&path, &bytes).unwrap();
    let Contents::Baked(loaded) = open(&path, &ReadOptions::default()).unwrap() else {
        panic!("a mesh without its BVH")
    };
    let loaded = Model::from_blob(&loaded).unwrap();
    assert_eq!(loaded.bvh().nodes(), model.bvh().nodes());
    assert_eq!(loaded.bvh().order(), model.bvh().order());
}

#[test]
fn faults_of_baked_meshes() {
    let TriangleMesh { positions, triangles } = quad();
    let bytes = Model::new(positions, triangles).unwrap().to_blob().unwrap();
    let mut changed = bytes.clone();
    changed[100] ^= 4;
    assert!(fault("changed.pfb", changed).contains("checksum"));
    assert!(fault("short.pfb", &bytes[..99]).contains("99"));
    assert!(fault("text.pfb", obj()).contains("pfront bake"));
    let nothing = Model::new(Vec::new(), Vec::new()).unwrap().to_blob().unwrap();
    assert!(fault("nothing.pfb", nothing).contains("no triangle"));
}
