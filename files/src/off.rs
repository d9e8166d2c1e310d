//! OFF in text: `OFF`, `COFF`, `NOFF` and the like, one vertex or face a line, or all on one. No kept crate reads it.

use crate::error::Fault;
use crate::import::Import;
use crate::text::{Line, Words, lines};

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let mut rest = lines(import.text(bytes));
    let mut line = rest.next().ok_or_else(|| ends("its header"))?;
    let mut words = line.words();
    let header = line.word(words.next())?;
    let no_header = || line.fault("an OFF file begins with OFF, or with ST, C and N before it");
    let at = header.windows(3).position(|word| word.eq_ignore_ascii_case(b"OFF"));
    // The specification lets it be left out.
    let is_count = header.iter().all(u8::is_ascii_digit);
    let (letters, word, glued) = match at {
        Some(at) => (&header[..at], &header[at..at + 3], &header[at + 3..]),
        None if is_count => (&b""[..], &b"OFF"[..], header),
        None => return Err(no_header()),
    };
    let is_letter = |b: &u8| b"STCN".contains(&b.to_ascii_uppercase());
    if !letters.iter().all(is_letter) || !glued.iter().all(u8::is_ascii_digit) {
        return Err(no_header());
    }
    if word == b"OFF" && letters.contains(&b'n') {
        return Err(line.fault("OFF of n dimensions is not read"));
    }
    if word != b"OFF" || letters != letters.to_ascii_uppercase() {
        import.notes.push("the header is not in capitals".to_owned());
    }
    if words.clone().next() == Some(b"BINARY") {
        return Err(line.fault("binary OFF is not supported: convert it to text"));
    }
    let vertices = if glued.is_empty() {
        if words.clone().next().is_none() {
            line = rest.next().ok_or_else(|| ends("its counts"))?;
            words = line.words();
        }
        line.number(words.next())?
    } else {
        let what =
            if is_count { "the header OFF is missing" } else { "there is no space after OFF" };
        import.notes.push(what.to_owned());
        line.number(Some(glued))?
    };
    let counts = [vertices, line.number(words.next())?];
    // The number of edges, which is often wrong.
    words.next();

    let by_words = Numbers { line, words, rest: rest.clone(), is_by_lines: false };
    if words.next().is_some() && letters.is_empty() {
        import.notes.push("vertices and faces follow the counts on their line".to_owned());
        return by_words.read(counts, import);
    }
    let notes = import.notes.clone();
    match (Numbers { is_by_lines: true, rest, ..by_words }).read(counts, import) {
        Err(fault) if letters.is_empty() => {
            // Lines may end anywhere where there is nothing but numbers to count.
            import.forget_mesh();
            import.notes = notes;
            import.notes.push("lines do not end where vertices and faces do".to_owned());
            by_words.read(counts, import).map_err(|_| fault)
        }
        read => read,
    }
}

/// The numbers of vertices and faces.
struct Numbers<'t, L> {
    line: Line<'t>,
    /// The rest of the line.
    words: Words<'t>,
    /// The lines after it.
    rest: L,
    /// Whether each vertex and face has a line, which may have more words.
    is_by_lines: bool,
}

impl<'t, L: Iterator<Item = Line<'t>>> Numbers<'t, L> {
    fn read(mut self, [vertices, faces]: [u32; 2], import: &mut Import) -> Result<(), Fault> {
        // Nothing is reserved on the word of a header.
        for _ in 0..vertices {
            let what = "its last vertex";
            self.begin(what)?;
            let mut position = [0.0; 3];
            for coordinate in &mut position {
                let word = self.next(what)?;
                *coordinate = self.line.coordinate(Some(word), &mut import.source)?;
            }
            import.push_position(position, self.line.number)?;
        }
        let mut corners = Vec::new();
        for _ in 0..faces {
            let what = "its last face";
            self.begin(what)?;
            let word = self.next(what)?;
            let count: u32 = self.line.number(Some(word))?;
            corners.clear();
            for _ in 0..count {
                let word = self.next(what)?;
                let corner = self.line.number(Some(word))?;
                if corner >= vertices {
                    let what = format!("there is no vertex {corner} among {vertices}");
                    return Err(self.line.fault(what));
                }
                import.push_corner(&mut corners, corner)?;
            }
            import.push_face(&corners)?;
        }
        if !self.is_by_lines && self.words.next().is_some() {
            return Err(goes_on(&self.line, faces));
        }
        self.rest.next().map_or(Ok(()), |line| Err(goes_on(&line, faces)))
    }

    /// Begins a vertex or a face.
    fn begin(&mut self, what: &str) -> Result<(), Fault> {
        if self.is_by_lines { self.next_line(what) } else { Ok(()) }
    }

    fn next(&mut self, what: &str) -> Result<&'t [u8], Fault> {
        loop {
            match self.words.next() {
                Some(word) => return Ok(word),
                None if self.is_by_lines => return self.line.word(None),
                None => self.next_line(what)?,
            }
        }
    }

    fn next_line(&mut self, what: &str) -> Result<(), Fault> {
        self.line = self.rest.next().ok_or_else(|| ends(what))?;
        self.words = self.line.words();
        Ok(())
    }
}

fn ends(what: &str) -> Fault {
    Fault::broken(format!("the file ends before {what}"))
}

fn goes_on(line: &Line<'_>, faces: u32) -> Fault {
    line.fault(format!("the file goes on after its {faces} faces"))
}
