//! The header of a PLY file: which elements and properties its data has.

use crate::error::Fault;
use crate::import::Import;
use crate::text::{Line, Words, quote};
use std::collections::HashSet;

pub(super) const AXES: [&[u8]; 3] = [b"x", b"y", b"z"];
/// The name of the corners of a face, also where it is `vertex_index`.
pub(super) const INDICES: &[u8] = b"vertex_indices";

pub(super) struct Header<'b> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'b>>,
    pub(super) lines: usize,
    pub(super) bytes: usize,
}

#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Text,
    Binary { is_big: bool },
}

pub(super) struct Element<'b> {
    pub(super) name: &'b [u8],
    pub(super) count: usize,
    pub(super) properties: Vec<Property<'b>>,
}

pub(super) struct Property<'b> {
    pub(super) name: &'b [u8],
    /// The type of the length, in a list.
    pub(super) count: Option<Scalar>,
    pub(super) scalar: Scalar,
}

#[derive(Clone, Copy)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// Reads the header of a file, and checks that its elements have what is read of them.
pub(super) fn header<'b>(bytes: &'b [u8], import: &mut Import) -> Result<Header<'b>, Fault> {
    // On old Macs lines end in `\r` alone.
    let first = bytes.iter().position(u8::is_ascii_whitespace).unwrap_or(0);
    let is_old =
        bytes[first..].first_chunk().is_some_and(|[a, b]| (*a, *b != b'\n') == (b'\r', true));
    let end = if is_old { b'\r' } else { b'\n' };
    let (mut encoding, mut elements, mut length, mut strange) = (None, Vec::new(), 0, 0);
    for (line, number) in bytes.split_inclusive(|&byte| byte == end).zip(1..) {
        length += line.len();
        let line = Line::new(number, line);
        let mut words = line.words();
        match words.next() {
            Some(b"ply") if number == 1 => {}
            None | Some(b"comment" | b"obj_info") => {}
            Some(b"format") => {
                encoding = Some(match line.word(words.next())? {
                    b"ascii" => Encoding::Text,
                    b"binary_little_endian" => Encoding::Binary { is_big: false },
                    b"binary_big_endian" => Encoding::Binary { is_big: true },
                    other => {
                        return Err(line.fault(format!("{} is no format of PLY", quote(other))));
                    }
                });
            }
            Some(b"element") => {
                let (name, count) = (line.word(words.next())?, line.number(words.next())?);
                import.budget.take(2 * size_of::<Element<'_>>())?;
                elements.push(Element { name, count, properties: Vec::new() });
            }
            Some(b"property") => {
                let no_element = || line.fault("a property of no element");
                let element = elements.last_mut().ok_or_else(no_element)?;
                import.budget.take(2 * size_of::<Property<'_>>())?;
                element.properties.push(property(&line, words)?);
            }
            Some(b"end_header") => {
                elements.iter().try_for_each(check)?;
                let distinct: HashSet<_> = elements.iter().map(|element| element.name).collect();
                if distinct.len() < elements.len() {
                    return Err(Fault::broken("two elements have the same name"));
                }
                import.note("lines of the header that are no statements are passed over", strange);
                let encoding = encoding.ok_or_else(|| Fault::broken("the header has no format"))?;
                return Ok(Header { encoding, elements, lines: number, bytes: length });
            }
            // Later it could be an element or a property, and all data something else.
            Some(_) if elements.is_empty() => strange += 1,
            Some(word) => {
                return Err(line.fault(format!("{} is no statement of PLY", quote(word))));
            }
        }
    }
    Err(Fault::broken("the header has no end"))
}

fn property<'b>(line: &Line<'b>, mut words: Words<'b>) -> Result<Property<'b>, Fault> {
    let scalar = |words: &mut Words<'b>| {
        let word = line.word(words.next())?;
        Scalar::named(word).ok_or_else(|| line.fault(format!("{} is no type of PLY", quote(word))))
    };
    let is_list = words.clone().next() == Some(b"list");
    let count = if is_list { words.next().map(|_| scalar(&mut words)).transpose()? } else { None };
    let scalar = scalar(&mut words)?;
    let name = line.word(words.next())?;
    let name = if is_list && name == b"vertex_index" { INDICES } else { name };
    Ok(Property { name, count, scalar })
}

/// Checks that an element has what is read of it, and nothing twice.
fn check(element: &Element<'_>) -> Result<(), Fault> {
    let has = |name: &[u8], is_list| {
        let mut properties = element.properties.iter();
        properties.any(|property| property.name == name && property.count.is_some() == is_list)
    };
    let missing = match element.name {
        b"vertex" => ["x", "y", "z"].into_iter().find(|axis| !has(axis.as_bytes(), false)),
        b"face" | b"tristrips" if !has(INDICES, true) => Some("vertex_indices or vertex_index"),
        // Any number of them would take no bytes.
        _ if element.properties.is_empty() => Some("properties"),
        _ => None,
    };
    if let Some(missing) = missing {
        return Err(Fault::broken(format!("element {} has no {missing}", element.shown())));
    }
    let distinct: HashSet<_> = element.properties.iter().map(|property| property.name).collect();
    if distinct.len() < element.properties.len() {
        let shown = element.shown();
        return Err(Fault::broken(format!("two properties of element {shown} have the same name")));
    }
    Ok(())
}

impl Element<'_> {
    pub(super) fn has_corners(&self) -> bool {
        matches!(self.name, b"face" | b"tristrips")
    }

    /// The name for an error text.
    pub(super) fn shown(&self) -> String {
        self.name[..self.name.len().min(40)].escape_ascii().to_string()
    }
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number of as many bytes.
    pub(super) fn number(self, bytes: &[u8], is_big: bool) -> f64 {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        if is_big {
            word[..bytes.len()].reverse();
        }
        let bits = u64::from_le_bytes(word);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}
