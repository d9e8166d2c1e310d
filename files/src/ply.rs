//! PLY, text and binary: x, y and z of `vertex`, `vertex_indices` (or `vertex_index`) of `face` and `tristrips`; other
//! elements and properties are passed over.
//!
//! `ply-rs-bw` reads the header and binary elements. Not those in text: it knows no `nan` and no `.5`
//! there, and rounds doubles twice.

mod element;

use crate::error::Fault;
use crate::import::Import;
use crate::text::{Line, lines};
use element::{AXES, Element, INDICES, RESTART};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyType};
use std::io::ErrorKind;

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    check_lines(bytes)?;
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader)?;
    let first = reader.line();
    let mut rest = reader.into_inner();
    check_header(&header, &bytes[..bytes.len() - rest.len()])?;

    let mut lines = lines(bytes).skip_while(|line| line.number < first);
    for element in header.elements.values() {
        for number in 0..element.count {
            let at = bytes.len() - rest.len();
            let fault = |e| binary_fault(&e, at, element, number);
            let mut line_number = 0;
            let record = match header.encoding {
                Encoding::Ascii => match lines.next() {
                    Some(line) => {
                        line_number = line.number;
                        Element::from_text(&line, element, &mut import.source)
                    }
                    None => Err(Fault::broken(ends_in(element, number))),
                },
                Encoding::BinaryLittleEndian => {
                    parser.read_little_endian_element(&mut rest, element).map_err(fault)
                }
                Encoding::BinaryBigEndian => {
                    parser.read_big_endian_element(&mut rest, element).map_err(fault)
                }
            }?;
            match (&element.name[..], record.corners.len()) {
                ("vertex", _) => {
                    let mut position = record.position;
                    if import.source.in_f32 {
                        position = position.map(|x| f64::from(x as f32));
                        // NaN is neither.
                        let is_rounded = |(x, y): &(f64, f64)| (x - y).abs() > 0.0;
                        let both = position.into_iter().zip(record.position);
                        import.source.rounded += both.filter(is_rounded).count();
                    }
                    import.push_position(position, line_number)?;
                }
                ("face", _) if record.corners.contains(&RESTART) => {
                    return Err(Fault::byte(at, not_natural(element, number)));
                }
                ("face", _) => import.push_face(&record.corners)?,
                ("tristrips", _) => {
                    let corners = record.corners.split(|&corner| corner == RESTART);
                    corners.into_iter().try_for_each(|strip| import.push_strip(strip))?;
                }
                _ => {}
            }
        }
    }
    let (lines_over, bytes_over) = match header.encoding {
        Encoding::Ascii => (lines.count(), 0),
        _ => (0, rest.len()),
    };
    if lines_over + bytes_over > 0 {
        let what = if lines_over > 0 { "lines" } else { "bytes" };
        let over = lines_over + bytes_over;
        import.notes.push(format!("{what} after the last element are passed over: {over}"));
    }
    Ok(())
}

/// Longer lines have no place in a header.
const LINE: usize = 4096;

/// Checks the lines of the header, which `ply-rs-bw` copies.
fn check_lines(bytes: &[u8]) -> Result<(), Fault> {
    let lines = bytes.split(|&byte| byte == b'\n' || byte == b'\r').zip(1..);
    for (line, number) in lines {
        if line.len() > LINE {
            return Err(Fault::line(number, "a line of the header is too long".to_owned()));
        }
        if line.starts_with(b"end_header") {
            break;
        }
    }
    Ok(())
}

fn check_header(header: &Header, bytes: &[u8]) -> Result<(), Fault> {
    // Where two have one name, `ply-rs-bw` keeps one, and then takes bytes for what they are not.
    let declares = |line: &Line<'_>| {
        line.words().next().is_some_and(|word| word == b"element" || word == b"property")
    };
    let kept: usize = header.elements.values().map(|element| 1 + element.properties.len()).sum();
    if lines(bytes).filter(declares).count() != kept {
        return Err(Fault::broken("two elements or two properties have the same name"));
    }
    for element in header.elements.values() {
        let has = |names: &[&str], list| {
            let mut found = names.iter().filter_map(|&name| element.properties.get(name));
            found.any(|property| matches!(property.data_type, PropertyType::List(..)) == list)
        };
        let name = &element.name;
        let missing = match &name[..] {
            "vertex" => AXES.into_iter().find(|&axis| !has(&[axis], false)),
            "face" | "tristrips" if !has(&INDICES, true) => Some("vertex_indices or vertex_index"),
            // Any number of them would take no bytes.
            _ if element.properties.is_empty() => Some("properties"),
            _ => None,
        };
        if let Some(missing) = missing {
            return Err(Fault::broken(format!("element {name} has no {missing}")));
        }
    }
    Ok(())
}

fn ends_in(element: &ElementDef, number: usize) -> String {
    format!("the file ends in {} {number} of {}", element.name, element.count)
}

fn not_natural(element: &ElementDef, number: usize) -> String {
    format!("the indices of {} {number} are no natural numbers", element.name)
}

fn binary_fault(e: &ParseError, at: usize, element: &ElementDef, number: usize) -> Fault {
    let what = match e.kind() {
        ErrorKind::UnexpectedEof => ends_in(element, number),
        // `Element` does not take every type.
        ErrorKind::InvalidData => not_natural(element, number),
        _ => format!("{} {number}: {e}", element.name),
    };
    Fault::byte(at, what)
}

/// A fault of a header.
impl From<ParseError> for Fault {
    fn from(error: ParseError) -> Self {
        let text = error.to_string();
        // The rest is an account of the grammar, and the line again before it.
        let what = text.lines().next().unwrap_or_default();
        match error.line() {
            Some(line) => Self::line(line, what.trim_start_matches(&format!("Line {line}: "))),
            None => Self::broken(what),
        }
    }
}
