//! JSON on one line, escaped as a terminal may show it.

use pfront_files::escape::is_shown;
use serde::Serialize;
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// The version of all JSON objects: it changes when something in them gets another name or meaning.
pub const VERSION: u32 = 1;

/// Writes a value as JSON in one line, which says the same and is [`escaped`](pfront_files::escape::escaped).
///
/// # Errors
/// As `to` does, or if the value is not JSON.
pub fn write_json(to: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    value.serialize(&mut json(&mut *to))?;
    writeln!(to)
}

/// A serializer of JSON that is [`escaped`](pfront_files::escape::escaped).
pub fn json<W: Write>(to: W) -> serde_json::Serializer<W, EscapedJson> {
    serde_json::Serializer::with_formatter(to, EscapedJson)
}

/// The format of [`json`].
#[derive(Debug)]
pub struct EscapedJson;

impl Formatter for EscapedJson {
    fn write_string_fragment<W: ?Sized + Write>(
        &mut self,
        to: &mut W,
        fragment: &str,
    ) -> io::Result<()> {
        if fragment.chars().all(is_shown) {
            return to.write_all(fragment.as_bytes());
        }
        for character in fragment.chars() {
            let mut units = [0; 2];
            if is_shown(character) {
                write!(to, "{character}")?;
            } else {
                let units = character.encode_utf16(&mut units);
                units.iter().try_for_each(|unit| write!(to, "\\u{unit:04x}"))?;
            }
        }
        Ok(())
    }
}
