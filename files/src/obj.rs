//! Wavefront OBJ: vertices, faces, and the objects or groups that these are of; everything else is passed over.
//!
//! By hand: `tobj` renumbers vertices group by group, so that faces of two groups share none, and `obj-rs`
//! panics on statements it does not know.

use crate::error::{Fault, Remedy};
use crate::import::Import;
use crate::text::{Line, lines, quote};
use std::collections::HashMap;

/// Statements that leave triangles alone, of the specification and of some programs.
const HARMLESS: &str = "vt vn vp s mg usemtl mtllib usemap maplib deg bmat step cstype parm end con bevel c_interp d_interp lod \
    shadow_obj trace_obj ctech stech";

/// Statements of geometry that is no triangle, and of other files.
const OTHERS: &str = "p l curv curv2 surf trim hole scrv sp call csh";

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let bytes = import.text(bytes);
    let joined = join_continued(bytes, import)?;
    let mut corners = Vec::new();
    let mut bodies = Bodies::default();
    let (mut others, mut strange) = (Passed::default(), Passed::default());
    // Faces may come before their vertices.
    let mut farthest = (0, 0);
    for line in lines(joined.as_deref().unwrap_or(bytes)) {
        let mut words = line.words();
        let is_of = |list: &str, word: &[u8]| list.split(' ').any(|s| s.as_bytes() == word);
        match line.word(words.next())? {
            b"v" => {
                let position = line.position(&mut words, &mut import.source)?;
                import.push_position(position, line.number)?;
            }
            b"f" | b"fo" => {
                corners.clear();
                for word in words {
                    import.is_split |= word.contains(&b'/');
                    let corner = corner(&line, word, import.mesh.positions.len())?;
                    farthest = farthest.max((corner, line.number));
                    import.push_corner(&mut corners, corner)?;
                }
                import.push_face(&corners)?;
            }
            word @ (b"o" | b"g") => bodies.begin(word, words, import)?,
            word if is_of(HARMLESS, word) => {}
            word if is_of(OTHERS, word) => others.add(&line, word),
            word => strange.add(&line, word),
        }
    }
    let all = import.mesh.positions.len();
    match (import.mesh.triangles.is_empty(), strange.first) {
        (true, Some((line, word))) => {
            let what = format!("{} is no statement of OBJ", quote(word));
            Err(Fault::line(line, what).or(Remedy::Format))
        }
        (false, _) if farthest.0 as usize >= all => {
            let vertex = u64::from(farthest.0) + 1;
            Err(Fault::line(farthest.1, format!("vertex {vertex} of {all}")))
        }
        _ => {
            others.note("points, lines, surfaces and other files are passed over", import);
            strange.note("lines that are no statements of OBJ are passed over", import);
            Ok(())
        }
    }
}

/// Statements that were passed over.
#[derive(Default)]
struct Passed<'b> {
    count: usize,
    /// The number of the first line, and its first word.
    first: Option<(usize, &'b [u8])>,
}

impl<'b> Passed<'b> {
    fn add(&mut self, line: &Line<'_>, word: &'b [u8]) {
        self.count += 1;
        self.first.get_or_insert((line.number, word));
    }

    fn note(&self, what: &str, import: &mut Import) {
        if let Some((line, word)) = self.first {
            let (count, word) = (self.count, quote(word));
            import.notes.push(format!("{what}: {count}, the first is {word} in line {line}"));
        }
    }
}

/// The bodies of a file: its objects, or its groups if there are none. A body that is named again goes on.
#[derive(Default)]
struct Bodies {
    has_objects: bool,
    numbers: HashMap<Vec<u8>, u32>,
}

impl Bodies {
    fn begin<'w>(
        &mut self,
        word: &[u8],
        name: impl Iterator<Item = &'w [u8]>,
        import: &mut Import,
    ) -> Result<(), Fault> {
        let triangles = import.mesh.triangles.len();
        let is_object = word == b"o";
        if is_object && !self.has_objects {
            self.has_objects = true;
            self.numbers.clear();
            import.source.forget_bodies();
        }
        if is_object != self.has_objects {
            return Ok(());
        }
        let name = name.collect::<Vec<_>>().join(&b' ');
        match self.numbers.get(&name) {
            Some(&body) => import.source.resume_body(body, triangles),
            None => {
                let body = import.begin_body(String::from_utf8_lossy(&name).into_owned())?;
                self.numbers.insert(name, body);
            }
        }
        Ok(())
    }
}

/// `7`, `7/1`, `7//2`, `7/1/2`, each also counted from the end: −1 is the latest vertex.
fn corner(line: &Line<'_>, word: &[u8], vertices: usize) -> Result<u32, Fault> {
    let written: i64 = line.number(word.split(|&b| b == b'/').next())?;
    let from_zero = match written {
        1.. => Some(written - 1),
        0 => None,
        _ => Some(vertices as i64 + written),
    };
    let index = from_zero.and_then(|index| u32::try_from(index).ok());
    index.ok_or_else(|| line.fault(format!("there is no vertex {written}")))
}

/// Lines that end in a backslash go on in the next, but for comments, which may end in a Windows path;
/// numbers of later lines stay right. `None` if there are no such lines.
fn join_continued(bytes: &[u8], import: &mut Import) -> Result<Option<Vec<u8>>, Fault> {
    if !bytes.windows(2).any(|w| w == b"\\\n" || w == b"\\\r") {
        return Ok(None);
    }
    import.budget.take(bytes.len())?;
    let mut joined = Vec::with_capacity(bytes.len());
    let mut owed = 0;
    for line in bytes.split(|&b| b == b'\n') {
        let body = line.strip_suffix(b"\r").unwrap_or(line);
        let continued = body.strip_suffix(b"\\").filter(|body| !body.contains(&b'#'));
        if let Some(body) = continued {
            joined.extend_from_slice(body);
            joined.push(b' ');
            owed += 1;
        } else {
            joined.extend_from_slice(body);
            joined.extend(std::iter::repeat_n(b'\n', 1 + std::mem::take(&mut owed)));
        }
    }
    Ok(Some(joined))
}
