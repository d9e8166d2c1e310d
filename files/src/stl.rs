//! STL, text and binary: a soup of three vertices a triangle, in the order of the file.
//! [`welded`](TriangleMesh::welded) joins them.
//!
//! By hand: of several solids `stl_io` reads the first, it takes text whose solid has no name for binary
//! and binary that begins with `solid` for text, and it refuses the NaN normals that triangles without
//! area have.

use crate::budget::demand;
use crate::error::{Fault, Remedy};
use crate::import::Import;
use crate::mesh::TriangleMesh;
use crate::text::{Line, lines, quote};

/// Header and count of a binary STL file, and each of its triangles.
pub(crate) const HEADER: usize = 84;
pub(crate) const TRIANGLE: usize = 50;

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let count = bytes.first_chunk::<HEADER>().map(|header| {
        let [.., a, b, c, d] = *header;
        u32::from_le_bytes([a, b, c, d]) as usize
    });
    match count {
        // Text is never as long as its bytes 80 to 83 say: as a count they are 150 million at least.
        Some(n) if HEADER + n * TRIANGLE == bytes.len() => {
            import.budget.check(demand(3 * n, n))?;
            binary(bytes, &mut import.mesh);
            Ok(())
        }
        _ if is_text(bytes) => text(bytes, import),
        Some(n) => {
            let (due, found) = (HEADER + n * TRIANGLE, bytes.len());
            let what = format!("a binary STL of {n} triangles has {due} bytes, not {found}");
            Err(Fault::broken(what).or(Remedy::Format))
        }
        None => {
            Err(Fault::broken("neither `solid` nor the 84 bytes that a binary STL has at least")
                .or(Remedy::Format))
        }
    }
}

/// Binary files may begin with `solid` too, but have zeros.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    let word = lines(bytes).next().and_then(|line| line.words().next());
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
}

fn binary(bytes: &[u8], mesh: &mut TriangleMesh) {
    for triangle in bytes[HEADER..].chunks_exact(TRIANGLE) {
        let number =
            |i: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|k| triangle[4 * i + k])));
        // After the normal.
        push(mesh, [3, 6, 9].map(|i| [i, i + 1, i + 2].map(number)));
    }
}

fn text(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let mut corners = Vec::new();
    let mut ended = false;
    for line in lines(bytes) {
        let mut words = line.words();
        let keyword = line.word(words.next())?.to_ascii_lowercase();
        ended = keyword == b"endsolid";
        match &keyword[..] {
            b"vertex" => corners.push(line.position(&mut words, &mut import.source)?),
            b"endloop" => {
                push(&mut import.mesh, three(&line, &mut corners)?);
                import.check_memory()?;
            }
            b"solid" | b"facet" | b"outer" | b"endfacet" | b"endsolid" => {}
            _ => {
                let what = format!("{} is no word of STL", quote(&keyword));
                return Err(line.fault(what).or(Remedy::Format));
            }
        }
    }
    if ended && corners.is_empty() {
        return Ok(());
    }
    Err(Fault::broken("the file ends before its last endsolid").or(Remedy::Format))
}

fn three(line: &Line<'_>, corners: &mut Vec<[f64; 3]>) -> Result<[[f64; 3]; 3], Fault> {
    let found = std::mem::take(corners);
    found
        .try_into()
        .map_err(|found: Vec<_>| line.fault(format!("a facet of {} corners", found.len())))
}

fn push(mesh: &mut TriangleMesh, corners: [[f64; 3]; 3]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}
