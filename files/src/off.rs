//! OFF in text: `OFF`, `COFF`, `NOFF` and the like, one vertex or face a line, or all on one. No kept crate reads it.

use crate::error::Fault;
use crate::import::Import;
use crate::text::{Line, lines};

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let bytes = import.text(bytes);
    let mut rest = lines(bytes);
    let mut line = rest.next().ok_or_else(|| ends("its header"))?;
    let mut words: Vec<_> = line.words().collect();
    let header = words.remove(0);
    let no_header = || line.fault("an OFF file begins with OFF, or with ST, C and N before it");
    let at = header.windows(3).position(|word| word.eq_ignore_ascii_case(b"OFF"));
    let (letters, glued) = header.split_at(at.ok_or_else(no_header)?);
    let (word, glued) = glued.split_at(3);
    let is_letter = |b: &u8| b"STCN".contains(&b.to_ascii_uppercase());
    if !letters.iter().all(is_letter) || !glued.iter().all(u8::is_ascii_digit) {
        return Err(no_header());
    }
    if word != b"OFF" || letters != letters.to_ascii_uppercase() {
        import.notes.push("the header is not in capitals".to_owned());
    }
    if !glued.is_empty() {
        import.notes.push("there is no space after OFF".to_owned());
        words.insert(0, glued);
    }
    if words.first() == Some(&&b"BINARY"[..]) {
        return Err(line.fault("binary OFF is not supported: convert it to text"));
    }
    if words.is_empty() {
        line = rest.next().ok_or_else(|| ends("its counts"))?;
        words = line.words().collect();
    }
    let count = |i: usize| -> Result<u32, Fault> { line.number(words.get(i).copied()) };
    let (vertices, faces) = (count(0)?, count(1)?);
    if words.len() > 3 && letters.is_empty() {
        import.notes.push("vertices and faces follow the counts on their line".to_owned());
        let first = line.words().count() - words.len() + usize::from(!glued.is_empty()) + 3;
        let after = lines_of_words(line, first, rest);
        return by_words(after, vertices, faces, import);
    }

    let first = line.number;
    match by_lines(rest, vertices, faces, import) {
        Err(fault) if letters.is_empty() => {
            // Lines may end anywhere where there is nothing but numbers to count.
            let notes = std::mem::take(&mut import.notes);
            import.forget_mesh();
            let after = lines(bytes).filter(|line| line.number > first);
            let words = after.flat_map(|line| line.words().map(move |word| (line, word)));
            let read = by_words(words, vertices, faces, import).map_err(|_| fault);
            import.notes = notes;
            import.notes.push("lines do not end where vertices and faces do".to_owned());
            read
        }
        read => read,
    }
}

/// Reads a vertex or a face a line.
fn by_lines<'t>(
    mut rest: impl Iterator<Item = Line<'t>>,
    vertices: u32,
    faces: u32,
    import: &mut Import,
) -> Result<(), Fault> {
    let mut corners = Vec::new();
    // Nothing is reserved on the word of a header.
    for _ in 0..vertices {
        let line = rest.next().ok_or_else(|| ends("its last vertex"))?;
        let position = line.position(&mut line.words(), &mut import.source)?;
        import.push_position(position, line.number)?;
    }
    for _ in 0..faces {
        let line = rest.next().ok_or_else(|| ends("its last face"))?;
        let mut words = line.words();
        let count: u32 = line.number(words.next())?;
        corners.clear();
        for _ in 0..count {
            push_corner(&line, words.next(), vertices, &mut corners, import)?;
        }
        import.push_face(&corners)?;
    }
    match rest.next() {
        Some(line) => Err(goes_on(&line, faces)),
        None => Ok(()),
    }
}

/// The words of a line from one on, and those of all lines after it.
fn lines_of_words<'t>(
    line: Line<'t>,
    first: usize,
    rest: impl Iterator<Item = Line<'t>>,
) -> impl Iterator<Item = (Line<'t>, &'t [u8])> {
    let own = line.words().skip(first).map(move |word| (line, word));
    own.chain(rest.flat_map(|line| line.words().map(move |word| (line, word))))
}

/// Reads vertices and faces that lines do not tell apart.
fn by_words<'t>(
    mut words: impl Iterator<Item = (Line<'t>, &'t [u8])>,
    vertices: u32,
    faces: u32,
    import: &mut Import,
) -> Result<(), Fault> {
    for _ in 0..vertices {
        let mut position = [0.0; 3];
        let mut at = 0;
        for coordinate in &mut position {
            let (line, word) = words.next().ok_or_else(|| ends("its last vertex"))?;
            *coordinate = line.coordinate(Some(word), &mut import.source)?;
            at = line.number;
        }
        import.push_position(position, at)?;
    }
    let mut corners = Vec::new();
    for _ in 0..faces {
        let mut next = || words.next().ok_or_else(|| ends("its last face"));
        let (line, word) = next()?;
        let count: u32 = line.number(Some(word))?;
        corners.clear();
        for _ in 0..count {
            let (line, word) = next()?;
            push_corner(&line, Some(word), vertices, &mut corners, import)?;
        }
        import.push_face(&corners)?;
    }
    match words.next() {
        Some((line, _)) => Err(goes_on(&line, faces)),
        None => Ok(()),
    }
}

fn push_corner(
    line: &Line<'_>,
    word: Option<&[u8]>,
    vertices: u32,
    corners: &mut Vec<u32>,
    import: &Import,
) -> Result<(), Fault> {
    let corner = line.number(word)?;
    if corner >= vertices {
        return Err(line.fault(format!("there is no vertex {corner} among {vertices}")));
    }
    import.push_corner(corners, corner)
}

fn ends(what: &str) -> Fault {
    Fault::broken(format!("the file ends before {what}"))
}

fn goes_on(line: &Line<'_>, faces: u32) -> Fault {
    line.fault(format!("the file goes on after its {faces} faces"))
}
