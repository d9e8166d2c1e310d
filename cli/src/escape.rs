//! Strings of files, as a terminal may show them: a name cannot move its cursor, change its colours, turn the order of
//! what it shows, or begin a line.

use serde::Serialize;
use serde_json::ser::Formatter;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

/// Whether a terminal shows a character in its place, and does nothing else with it.
pub fn is_shown(character: char) -> bool {
    let is_format = matches!(
        character,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{feff}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e0fff}'
    );
    !character.is_control() && !is_format
}

/// A text on one line, with escapes as Rust has them in place of control characters, ends of lines, and characters that change
/// the direction of text or that nobody sees.
///
/// # Examples
/// ```
/// use pfront_cli::escape::escaped;
/// assert_eq!(escaped("a lid"), "a lid");
/// assert_eq!(escaped("\x1b[2J\n\u{202e}"), r"\u{1b}[2J\n\u{202e}");
/// ```
pub fn escaped(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_shown) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_shown(character) {
            shown.push(character);
        } else {
            shown.extend(character.escape_default());
        }
    }
    Cow::Owned(shown)
}

/// The name of a file, [`escaped`].
pub fn shown_path(path: &Path) -> String {
    escaped(&path.to_string_lossy()).into_owned()
}

/// Writes a value as JSON in one line, which says the same and is [`escaped`].
///
/// # Errors
/// As `to` does, or if the value is not JSON.
pub fn write_json(to: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    value.serialize(&mut json(&mut *to))?;
    writeln!(to)
}

/// A serializer of JSON that is [`escaped`].
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
