//! PLY, text and binary: x, y and z of `vertex`, `vertex_indices` (or `vertex_index`) of `face` and `tristrips`; other
//! elements and properties are passed over.
//!
//! By hand: `ply-rs-bw` refuses headers with a line of no statement, knows no `nan` and no `.5` in text, and rounds
//! doubles twice.

mod header;

use crate::error::Fault;
use crate::import::Import;
use crate::source::Source;
use crate::text::{Line, Words, lines};
use header::{AXES, Element, Encoding, INDICES, Scalar, header};

/// Stands for −1, with which a strip ends and another begins.
const RESTART: u32 = u32::MAX;

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    let header = header(bytes, import)?;
    let mut text = lines(bytes).skip_while(|line| line.number <= header.lines);
    let mut rest = &bytes[header.bytes..];
    let mut corners = Vec::new();
    for element in &header.elements {
        for number in 0..element.count {
            let data = match header.encoding {
                Encoding::Text => {
                    let ends = || Fault::broken(ends_in(element, number));
                    let line = text.next().ok_or_else(ends)?;
                    Data::Text { line, words: line.words() }
                }
                Encoding::Binary { is_big } => {
                    Data::Binary { byte: bytes.len() - rest.len(), rest: &mut rest, is_big }
                }
            };
            let mut record = Record { element, number, data };
            let position = record.read(&mut corners, import)?;
            match element.name {
                b"vertex" => {
                    let position = import.source.rounded(position);
                    import.push_position(position, record.line())?;
                }
                b"face" => import.push_face(&corners)?,
                b"tristrips" => {
                    let mut strips = corners.split(|&corner| corner == RESTART);
                    strips.try_for_each(|strip| import.push_strip(strip))?;
                }
                _ => {}
            }
        }
        if !element.has_corners()
            && element.properties.iter().any(|property| property.name == INDICES)
        {
            let what = format!("elements {} are passed over", element.shown());
            import.note(&what, element.count);
        }
    }
    match header.encoding {
        Encoding::Text => {
            import.note("lines after the last element are passed over", text.count());
        }
        Encoding::Binary { .. } => {
            import.note("bytes after the last element are passed over", rest.len());
        }
    }
    Ok(())
}

fn ends_in(element: &Element<'_>, number: usize) -> String {
    format!("the file ends in {} {number} of {}", element.shown(), element.count)
}

/// An element of the data.
struct Record<'r, 'b> {
    element: &'r Element<'b>,
    number: usize,
    data: Data<'r, 'b>,
}

/// The numbers of an element that are not read yet.
enum Data<'r, 'b> {
    Text { line: Line<'b>, words: Words<'b> },
    Binary { byte: usize, rest: &'r mut &'b [u8], is_big: bool },
}

impl Record<'_, '_> {
    /// Reads the position of a vertex, and the corners of a face or strip.
    fn read(&mut self, corners: &mut Vec<u32>, import: &mut Import) -> Result<[f64; 3], Fault> {
        let mut position = [0.0; 3];
        corners.clear();
        for property in &self.element.properties {
            let (scalar, name) = (property.scalar, property.name);
            let axis = AXES.iter().position(|axis| *axis == name);
            match (property.count, axis) {
                (None, Some(axis)) => {
                    position[axis] = self.coordinate(scalar, &mut import.source)?;
                }
                (None, None) => self.pass(scalar)?,
                (Some(count), _) if name == INDICES && self.element.has_corners() => {
                    for _ in 0..self.natural(count)? {
                        let corner = self.natural(scalar)?;
                        import.push_corner(corners, corner)?;
                    }
                }
                (Some(count), _) => {
                    let count = self.natural(count)?;
                    (0..count).try_for_each(|_| self.pass(scalar))?;
                }
            }
        }
        Ok(position)
    }

    /// The line, if there are lines.
    fn line(&self) -> usize {
        match &self.data {
            Data::Text { line, .. } => line.number,
            Data::Binary { .. } => 0,
        }
    }

    fn fault(&self, what: String) -> Fault {
        match &self.data {
            Data::Text { line, .. } => line.fault(what),
            Data::Binary { byte, .. } => Fault::byte(*byte, what),
        }
    }

    /// Straight to f32 or f64 in text, whatever the type is, so that all is rounded once.
    fn coordinate(&mut self, scalar: Scalar, source: &mut Source) -> Result<f64, Fault> {
        match &mut self.data {
            Data::Text { line, words } => line.coordinate(words.next(), source),
            Data::Binary { .. } => self.number(scalar),
        }
    }

    /// A natural number, or in strips `RESTART`.
    fn natural(&mut self, scalar: Scalar) -> Result<u32, Fault> {
        let number = self.number(scalar)?;
        let is_strip = self.element.name == b"tristrips";
        if is_strip && (number == -1.0 || number == f64::from(RESTART)) {
            return Ok(RESTART);
        }
        let natural = number as u32;
        if f64::from(natural) == number && natural != RESTART {
            return Ok(natural);
        }
        let (element, at) = (self.element.shown(), self.number);
        Err(self.fault(format!("{element} {at}: {number} is no index and no number of indices")))
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        match &mut self.data {
            Data::Text { line, words } => line.number(words.next()),
            Data::Binary { rest, is_big, .. } => match rest.split_at_checked(scalar.size()) {
                Some((bytes, after)) => {
                    **rest = after;
                    Ok(scalar.number(bytes, *is_big))
                }
                None => Err(self.fault(ends_in(self.element, self.number))),
            },
        }
    }

    /// Passes a number over, which need be none in text.
    fn pass(&mut self, scalar: Scalar) -> Result<(), Fault> {
        match &mut self.data {
            Data::Text { line, words } => line.word(words.next()).map(drop),
            Data::Binary { .. } => self.number(scalar).map(drop),
        }
    }
}
