//! OFF in text: `OFF`, `COFF`, `NOFF` and the like, one vertex or face a line. No kept crate reads it.

use crate::error::Fault;
use crate::import::Import;
use crate::text::{Line, lines};

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let mut lines = lines(bytes);
    let mut next = |what: &str| {
        lines.next().ok_or_else(|| Fault::broken(format!("the file ends before {what}")))
    };
    let mut line = next("its header")?;
    let mut words = line.words();
    let header = words.next().unwrap_or_default();
    let letters = header.strip_suffix(b"OFF");
    if !letters.is_some_and(|letters| letters.iter().all(|b| b"STCN".contains(b))) {
        return Err(line.fault("an OFF file begins with OFF, or with ST, C and N before it"));
    }
    let mut counts = words.take(3).collect::<Vec<_>>();
    if counts.first() == Some(&&b"BINARY"[..]) {
        return Err(line.fault("binary OFF is not supported: convert it to text"));
    }
    if counts.is_empty() {
        line = next("its counts")?;
        counts = line.words().take(3).collect();
    }
    let count = |i: usize| -> Result<u32, Fault> { line.number(counts.get(i).copied()) };
    let (vertices, faces) = (count(0)?, count(1)?);

    // Nothing is reserved on the word of a header.
    for _ in 0..vertices {
        let line = next("its last vertex")?;
        let position = line.position(&mut line.words(), &mut import.source)?;
        import.push_position(position)?;
    }
    let mut corners = Vec::new();
    for _ in 0..faces {
        let line = next("its last face")?;
        face(&line, vertices, &mut corners, import)?;
        import.push_face(&corners)?;
    }
    match lines.next() {
        Some(line) => Err(line.fault(format!("the file goes on after its {faces} faces"))),
        None => Ok(()),
    }
}

fn face(
    line: &Line<'_>,
    vertices: u32,
    corners: &mut Vec<u32>,
    import: &Import,
) -> Result<(), Fault> {
    let mut words = line.words();
    let count: u32 = line.number(words.next())?;
    if count < 3 {
        return Err(line.fault(format!("a face of {count} corners")));
    }
    corners.clear();
    for _ in 0..count {
        let corner = line.number(words.next())?;
        if corner >= vertices {
            return Err(line.fault(format!("there is no vertex {corner} among {vertices}")));
        }
        import.push_corner(corners, corner)?;
    }
    Ok(())
}
