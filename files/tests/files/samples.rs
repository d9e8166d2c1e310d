//! Small files of each format, most of them of the same square.

/// A square whose second vertex is not used first, and a vertex that is not used at all.
pub(super) const POSITIONS: [[f32; 3]; 5] =
    [[0.1, 0.0, 0.0], [1.0, 1.0, 1e-7], [1.0, 0.0, -2.5e10], [0.0, 1.0, 16_777_217.0], [7.0; 3]];
pub(super) const QUAD: [[u32; 3]; 2] = [[2, 1, 3], [2, 3, 0]];

pub(super) fn obj() -> Vec<u8> {
    b"\xef\xbb\xbf# a square in C:\\\no first\nv 0.1 0 0\nv 1 1 1e-7 0.5 0.5 nan\r\nv 1 0 -2.5e10\nvt 0 0\nvn 0 0 1\n\
      g a b\nusemtl none\nv 0 1 16777217\nf 3/1/1 2//1 \\\n  4/1 -4\ncstype bezier\nv 7 7 7\n"
        .to_vec()
}

pub(super) fn off() -> Vec<u8> {
    b"COFF # with colours\n5 1 0\n0.1 0 0 255 0 0 255\n1 1 1e-7 0 0 0 0\n\n1 0 -2.5e10 0 0 0 0\n\
      0 1 16777217 0 0 0 0\n7 7 7 0 0 0 0\n4 2 1 3 0 0.5 0.5 0.5\n"
        .to_vec()
}

/// How a number is written, as float and as int.
type Binary = [fn(f32) -> [u8; 4]; 2];

pub(super) fn ply(format: &str, binary: Option<Binary>) -> Vec<u8> {
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

pub(super) fn ply_little() -> Vec<u8> {
    ply("binary_little_endian", Some([f32::to_le_bytes, |x| (x as i32).to_le_bytes()]))
}

pub(super) fn ply_big() -> Vec<u8> {
    ply("binary_big_endian", Some([f32::to_be_bytes, |x| (x as i32).to_be_bytes()]))
}

/// Two solids without names, and normals as triangles without area have them.
pub(super) fn stl_text() -> Vec<u8> {
    let solid = |t: &[u32; 3]| {
        let corner = |&v: &u32| {
            let [x, y, z] = POSITIONS[v as usize];
            format!("vertex {x} {y} {z}\n")
        };
        let corners: String = t.iter().map(corner).collect();
        let normal = "facet normal -nan(ind) nan 0";
        format!("solid\n{normal}\nouter loop\n{corners}endloop\nendfacet\nendsolid\n")
    };
    QUAD.iter().map(solid).collect::<String>().into_bytes()
}

/// Its header begins like a text file.
pub(super) fn stl_binary() -> Vec<u8> {
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
pub(super) fn gltf() -> Vec<u8> {
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

/// The same in one binary file.
pub(super) fn glb() -> Vec<u8> {
    let text = String::from_utf8(gltf()).unwrap();
    let (json, data) = text.split_once(",\"uri\":\"").unwrap();
    let mut json = format!("{json}{}", data.split_once('"').unwrap().1).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let corners = [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0].map(|x| x as f32);
    let chunk =
        |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", bytemuck::cast_slice(&corners))].concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [b"glTF\x02\0\0\0", &length[..], &chunks].concat()
}

/// A strip of two triangles, and one of one.
pub(super) fn ply_strips() -> String {
    let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n";
    format!("{header}8 0 1 2 3 -1 2 3 4\n")
}
