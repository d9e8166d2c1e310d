//! STL, text and binary, through `stl_io`: a soup of three vertices a triangle, in the order of the file.
//! [`welded`](MeshData::welded) joins them.

use super::MeshData;
use super::error::Fault;
use std::io::Cursor;
use stl_io::create_stl_reader;

/// Header and count of a binary file, and each of its triangles.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<MeshData, Fault> {
    let mut mesh = MeshData::default();
    let mut push = |corners: [[f32; 3]; 3]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.push([first, first + 1, first + 2]);
    };
    if is_binary(bytes) {
        // Not by `stl_io`, which takes a binary file whose header begins with `solid` for text.
        for triangle in bytes[HEADER..].chunks_exact(TRIANGLE) {
            let number = |i: usize| [0, 1, 2, 3].map(|k| triangle[4 * i + k]);
            let corner = |i: usize| [i, i + 1, i + 2].map(|i| f32::from_le_bytes(number(i)));
            push([corner(3), corner(6), corner(9)]);
        }
        return Ok(mesh);
    }
    if !bytes.starts_with(b"solid") {
        return Err(Fault::broken(wrong_length(bytes)));
    }
    let mut file = Cursor::new(bytes);
    let broken = |e: std::io::Error, n| Fault::broken(format!("after {n} triangles: {e}"));
    for (triangle, n) in create_stl_reader(&mut file).map_err(|e| broken(e, 0))?.zip(0..) {
        push(triangle.map_err(|e| broken(e, n))?.vertices.map(|v| v.0));
    }
    Ok(mesh)
}

/// Whether the file is just as long as its count says. Text never is: at the count it has letters, which
/// would make over 500 million triangles.
fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|n| HEADER + n * TRIANGLE == bytes.len())
}

fn count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

fn wrong_length(bytes: &[u8]) -> String {
    let found = bytes.len();
    match count(bytes) {
        Some(n) => format!(
            "a binary STL of {n} triangles has {} bytes, not {found}",
            HEADER + n * TRIANGLE
        ),
        None => format!("an STL has 84 bytes at least, this file {found}"),
    }
}
