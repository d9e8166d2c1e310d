//! STL, text and binary: three vertices a triangle, in the order of the file, each solid a body.
//!
//! By hand: of several solids `stl_io` reads the first, it takes text whose solid has no name for binary
//! and binary that begins with `solid` for text, and it refuses the NaN normals that triangles without
//! area have.

use crate::budget::demand;
use crate::error::{Fault, Remedy};
use crate::import::Import;
use crate::mesh::TriangleMesh;
use crate::text::{Line, Words, lines, quote, without_padding};

/// Header and count of a binary STL file, and each of its triangles.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The triangles that a binary file says it has.
fn count(head: &[u8]) -> Option<usize> {
    let [.., a, b, c, d] = *head.first_chunk::<HEADER>()?;
    Some(u32::from_le_bytes([a, b, c, d]) as usize)
}

/// The length of a binary file that has so many triangles.
fn length(triangles: usize) -> u64 {
    HEADER as u64 + TRIANGLE as u64 * triangles as u64
}

/// Checks the beginning of a file, and returns whether it is text.
///
/// # Errors
/// If it is binary, and too short for its triangles.
pub(crate) fn check(head: &[u8], found: Option<u64>) -> Result<bool, Fault> {
    let triangles = count(head);
    // Text is never as long as its bytes 80 to 83 say: as a count they are 150 million at least.
    let is_as_long = triangles.is_some_and(|n| found == Some(length(n)));
    if !is_as_long && is_text(without_padding(head)) {
        return Ok(true);
    }
    match (triangles, found) {
        (Some(0), Some(found)) if !(found - length(0)).is_multiple_of(TRIANGLE as u64) => {
            Err(other_length(0, found))
        }
        (Some(n), Some(found)) if found < length(n) => Err(other_length(n, found)),
        _ => Ok(false),
    }
}

fn other_length(triangles: usize, found: u64) -> Fault {
    let due = length(triangles);
    let what = format!("a binary STL of {triangles} triangles has {due} bytes, not {found}");
    Fault::broken(what).or(Remedy::Format)
}

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    import.is_split = true;
    if check(bytes, Some(bytes.len() as u64))? {
        return text(import.text(bytes), import);
    }
    let Some(mut n) = count(bytes) else {
        let what = "neither `solid` nor the 84 bytes that a binary STL has at least";
        return Err(Fault::broken(what).or(Remedy::Format));
    };
    let (triangles, over) = bytes[HEADER..].as_chunks::<TRIANGLE>();
    if n == 0 && over.is_empty() && !triangles.is_empty() {
        n = triangles.len();
        import.notes.push(format!("the header counts 0 triangles: all {n} that follow are read"));
    }
    // After that only what holds no triangle may follow.
    let after = &bytes[length(n) as usize..];
    let is_padding = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    if after.len() >= TRIANGLE && !after.iter().all(is_padding) {
        return Err(other_length(n, bytes.len() as u64));
    }
    import.note("bytes after the last triangle are passed over", after.len());
    import.budget.check(demand(3 * n, n))?;
    for triangle in &triangles[..n] {
        let number =
            |i: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|k| triangle[4 * i + k])));
        // After the normal.
        push(&mut import.mesh, [3, 6, 9].map(|i| [i, i + 1, i + 2].map(number)));
    }
    Ok(())
}

/// Binary files may begin with `solid` too, but have zeros.
fn is_text(bytes: &[u8]) -> bool {
    let word = lines(bytes).next().and_then(|line| line.words().next());
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !bytes.contains(&0)
}

fn push(mesh: &mut TriangleMesh, corners: [[f64; 3]; 3]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}

fn text(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let mut corners = Vec::new();
    let (mut is_open, mut facet_is_open, mut is_apart) = (false, false, false);
    for line in lines(bytes) {
        let mut words = line.words();
        let mut is_first = true;
        // Some files have several words of STL in a line, or all.
        while let Some(word) = words.next() {
            let mut keyword = word.to_ascii_lowercase();
            if keyword == b"end" {
                keyword.extend(words.next().unwrap_or_default().to_ascii_lowercase());
                is_apart = true;
            }
            match &keyword[..] {
                b"vertex" => {
                    let position = line.position(&mut words, &mut import.source)?;
                    corners.push((position, line.number));
                    import.budget.check_list(&corners, 1)?;
                }
                b"endloop" => push_facet(&line, &mut corners, import)?,
                b"solid" => {
                    is_open = true;
                    let name = rest_of_name(&mut words).join(&b' ');
                    let name = if name.is_empty() { b"solid" } else { &name[..] };
                    import.begin_body(String::from_utf8_lossy(name).into_owned())?;
                }
                b"endsolid" => {
                    is_open = false;
                    rest_of_name(&mut words);
                    if words.clone().next().is_some() {
                        return Err(line.fault("a solid begins in the line where another ends"));
                    }
                }
                b"facet" => facet_is_open = true,
                b"endfacet" => facet_is_open = false,
                b"outer" => {}
                _ if !is_first => {}
                _ => {
                    let what = format!("{} is no word of STL", quote(&keyword));
                    return Err(line.fault(what).or(Remedy::Format));
                }
            }
            is_first = false;
        }
    }
    if facet_is_open || !corners.is_empty() {
        let what = "the file ends within a facet, before its last endsolid";
        return Err(Fault::broken(what).or(Remedy::Format));
    }
    if is_apart {
        import.notes.push("`end solid` and the like are read as endsolid".to_owned());
    }
    if is_open {
        import.notes.push("the file ends before its last endsolid".to_owned());
    }
    Ok(())
}

/// The words up to the first facet, or to the end of the line.
fn rest_of_name<'t>(words: &mut Words<'t>) -> Vec<&'t [u8]> {
    let mut name = Vec::new();
    loop {
        let mut rest = *words;
        let two =
            [rest.next(), rest.next()].map(|word| word.unwrap_or_default().to_ascii_lowercase());
        if two[0].is_empty() || two == [&b"facet"[..], b"normal"] {
            return name;
        }
        name.extend(words.next());
    }
}

fn push_facet(
    line: &Line<'_>,
    corners: &mut Vec<([f64; 3], usize)>,
    import: &mut Import,
) -> Result<(), Fault> {
    if corners.len() != 3 {
        return Err(line.fault(format!("a facet of {} corners", corners.len())));
    }
    let first = import.mesh.positions.len() as u32;
    for (position, number) in corners.drain(..) {
        import.push_position(position, number)?;
    }
    import.mesh.triangles.push([first, first + 1, first + 2]);
    Ok(())
}
