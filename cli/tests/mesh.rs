//! Mesh files: order and coordinates are kept, faults are found where they are, nothing panics.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront_cli::mesh::{MeshData, PaintedMesh, read, write_painted};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fs;
use tempfile::TempDir;

/// A square whose second vertex is not used first, and a vertex that is not used at all.
const POSITIONS: [[f32; 3]; 5] =
    [[0.1, 0.0, 0.0], [1.0, 1.0, 1e-7], [1.0, 0.0, -2.5e10], [0.0, 1.0, 16_777_217.0], [7.0; 3]];
const QUAD: [[u32; 3]; 2] = [[2, 1, 3], [2, 3, 0]];

fn parse(name: &str, bytes: impl AsRef<[u8]>) -> Result<MeshData, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read(&path).map_err(|e| e.to_string())
}

fn fault(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = parse(name, bytes).unwrap_err();
    assert!(error.contains(name), "{error}");
    error
}

fn quad() -> MeshData {
    MeshData { positions: POSITIONS.to_vec(), triangles: QUAD.to_vec() }
}

fn obj() -> Vec<u8> {
    b"# a square\no first\nv 0.1 0 0\nv 1 1 1e-7 0.5 0.5 nan\r\nv 1 0 -2.5e10\nvt 0 0\nvn 0 0 1\n\
      g a b\nusemtl none\nv 0 1 16777217\nf 3/1/1 2//1 \\\n  4/1 -4\ncstype bezier\nv 7 7 7\n"
        .to_vec()
}

fn off() -> Vec<u8> {
    b"COFF # with colours\n5 1 0\n0.1 0 0 255 0 0 255\n1 1 1e-7 0 0 0 0\n\n1 0 -2.5e10 0 0 0 0\n\
      0 1 16777217 0 0 0 0\n7 7 7 0 0 0 0\n4 2 1 3 0 0.5 0.5 0.5\n"
        .to_vec()
}

/// How a number is written, as float and as int.
type Binary = [fn(f32) -> [u8; 4]; 2];

fn ply(format: &str, binary: Option<Binary>) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment a square\nelement note 1\nproperty uchar what\n\
         element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
         property float confidence\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut file = header.into_bytes();
    let Some([float, int]) = binary else {
        let vertices = POSITIONS.map(|[x, y, z]| format!("{x} {y} {z} 1\n")).concat();
        file.extend(format!("9\n{vertices}4 2 1 3 0\n").bytes());
        return file;
    };
    file.push(9);
    file.extend(POSITIONS.iter().flat_map(|p| [p[0], p[1], p[2], 1.0]).flat_map(float));
    file.push(4);
    file.extend([2.0, 1.0, 3.0, 0.0].into_iter().flat_map(int));
    file
}

fn ply_little() -> Vec<u8> {
    ply("binary_little_endian", Some([f32::to_le_bytes, |x| (x as i32).to_le_bytes()]))
}

fn ply_big() -> Vec<u8> {
    ply("binary_big_endian", Some([f32::to_be_bytes, |x| (x as i32).to_be_bytes()]))
}

fn stl_text() -> Vec<u8> {
    let facet = |t: &[u32; 3]| {
        let corner = |&v: &u32| {
            let [x, y, z] = POSITIONS[v as usize];
            format!("vertex {x} {y} {z}\n")
        };
        let corners: String = t.iter().map(corner).collect();
        format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid s\n{}endsolid s\n", QUAD.iter().map(facet).collect::<String>()).into_bytes()
}

/// Its header begins like a text file.
fn stl_binary() -> Vec<u8> {
    let mut file = b"solid but not text".to_vec();
    file.resize(80, b' ');
    file.extend(2_u32.to_le_bytes());
    for t in QUAD {
        file.extend([0; 12]);
        file.extend(t.iter().flat_map(|&v| POSITIONS[v as usize]).flat_map(f32::to_le_bytes));
        file.extend([0; 2]);
    }
    file
}

/// A triangle, and a strip of two moved by its node and that above. The buffer holds (0, 0, 0),
/// (1, 0, 0), (0, 1, 0), (1, 1, 0).
fn gltf() -> Vec<u8> {
    br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
        "nodes":[{"mesh":0},{"translation":[0,0,5],"children":[2]},{"mesh":1,"translation":[0,2,0]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]},
                  {"primitives":[{"attributes":{"POSITION":1},"mode":5}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                      "min":[0,0,0],"max":[1,1,0]},
                     {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
                      "min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":48}],
        "buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAA"}]}"#
        .to_vec()
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
        let soup = parse(name, bytes).unwrap();
        assert_eq!(soup.triangles, [[0, 1, 2], [3, 4, 5]], "{name}");
        let corners = QUAD.as_flattened().iter().map(|&v| POSITIONS[v as usize]);
        assert_eq!(soup.positions, corners.collect::<Vec<_>>(), "{name}");
        assert_eq!(soup.welded().triangles, [[0, 1, 2], [0, 2, 3]], "{name}");
    }
}

#[test]
fn gltf_places_its_nodes() {
    let mesh = parse("scene.gltf", gltf()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5], [5, 4, 6]]);
    assert_eq!(mesh.positions[..3], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.positions[6], [1.0, 3.0, 5.0]);
}

#[test]
fn faults_say_where() {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let obj = text(obj());
    assert!(fault("a.obj", obj.replace("1e-7", "1e--7")).contains("line 4: '1e--7'"));
    assert!(fault("b.obj", obj.replace("-2.5e10", "")).contains("line 5"));
    // A face that goes on in the next line, and one that names a vertex of the future's future.
    assert!(fault("c.obj", obj.replace("4/1 -4", "0")).contains("line 11: there is no vertex 0"));
    assert!(fault("d.obj", obj.replace("4/1 -4", "-9")).contains("line 11: there is no vertex -9"));
    assert!(fault("e.obj", obj.replace("4/1 -4", "6")).contains("line 11: vertex 6 of 5"));
    assert!(fault("f.obj", "v 0 0 0\nf 1 1\n").contains("line 2: a face of 2 corners"));
    let off = text(off());
    assert!(fault("a.off", off.replace("COFF", "4OFF")).contains("line 1"));
    assert!(
        fault("b.off", off.replace("4 2 1 3 0 ", "4 2 1 3 5 "))
            .contains("line 9: there is no vertex 5")
    );
    assert!(fault("c.off", off.replace("5 1 0", "6 1 0")).contains("the file ends before"));
    assert!(fault("d.off", "OFF BINARY\n").contains("convert"));
    let ply = text(ply("ascii", None));
    assert!(fault("a.ply", ply.replace("float z", "float w")).contains("no z"));
    assert!(fault("b.ply", ply.replace("vertex_indices", "corners")).contains("no vertex_indices"));
    assert!(fault("c.ply", ply.replace("4 2 1 3 0", "2 2 1")).contains("face 0 has 2 corners"));
    assert!(fault("d.ply", ply.replace("4 2 1 3 0", "4 2 1 3 -1")).contains("vertex_indices"));
    assert!(
        fault("e.ply", ply.replace("element note 1", "element none 4000000000\nelement note 1"))
            .contains("none")
    );
    let mut stl = stl_binary();
    stl[..80].fill(0);
    assert!(fault("a.stl", &stl[..150]).contains("184 bytes, not 150"));
    assert!(
        fault("b.stl", stl_text().split_last_chunk::<30>().unwrap().0)
            .contains("after 1 triangles")
    );
    assert!(fault("a.txt", "").contains("known are obj, ply, stl, off, gltf, glb"));
    let gltf = text(gltf());
    assert!(fault("a.gltf", gltf.replace("\"count\":4", "\"count\":5")).contains("accessor 1"));
}

/// Counts in headers are not believed: no memory is asked for on their word, and reading ends at once.
#[test]
fn lying_counts_are_refused() {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    fault("a.off", text(off()).replace("5 1 0", "4000000000 1 0"));
    fault("b.off", text(off()).replace("4 2 1 3 0", "4000000000 2 1 3 0"));
    for vertices in ["vertex 4000000000", "vertex 18446744073709551615"] {
        fault("a.ply", text(ply("ascii", None)).replace("vertex 5", vertices));
        let little = String::from_utf8_lossy(&ply_little()).replace("vertex 5", vertices);
        fault("b.ply", little.into_bytes());
    }
    let mut stl = stl_binary();
    stl[..80].fill(0);
    stl[80..84].fill(0xff);
    fault("a.stl", stl);
    fault("a.gltf", text(gltf()).replace("\"count\":4", "\"count\":4000000000"));
}

#[test]
fn changed_bytes_never_panic() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let folder = TempDir::new().unwrap();
    for (name, bytes) in [
        ("m.obj", obj()),
        ("m.off", off()),
        ("m.ply", ply("ascii", None)),
        ("n.ply", ply_little()),
        ("o.ply", ply_big()),
        ("m.stl", stl_text()),
        ("n.stl", stl_binary()),
        ("m.gltf", gltf()),
    ] {
        let path = folder.path().join(name);
        for _ in 0..3000 {
            let mut changed = bytes.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..changed.len());
                changed[at] = match random.random_range(0..3) {
                    0 => random.next_u32() as u8,
                    1 => b"0123456789-.e \n/{}[]"[random.random_range(0..20)],
                    _ => changed[random.random_range(0..changed.len())],
                };
            }
            changed.truncate(random.random_range(0..2 * changed.len()));
            fs::write(&path, &changed).unwrap();
            // What is read may be nonsense, but a model says so.
            if let Ok(MeshData { positions, triangles }) = read(&path) {
                let _ = pfront::Model::new(positions, triangles);
            }
        }
    }
}

#[test]
fn painted_meshes_come_back() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("painted.ply");
    let mesh = PaintedMesh {
        positions: &POSITIONS,
        triangles: &QUAD,
        hit: &[false, true],
        colours: [[1, 2, 3], [4, 5, 6]],
    };
    write_painted(&path, &[mesh, mesh]).unwrap();
    let read = read(&path).unwrap();
    assert_eq!(read.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]);
    assert_eq!(read.positions[9..], QUAD[1].map(|v| POSITIONS[v as usize]));
    let bytes = fs::read(&path).unwrap();
    let vertices = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    assert_eq!(bytes[vertices + 12..][..3], [1, 2, 3]);
    assert_eq!(bytes[vertices + 3 * 15 + 12..][..3], [4, 5, 6]);
}
