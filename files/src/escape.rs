//! Strings of files, as a terminal may show them: a name cannot move its cursor, change its colours, turn the order of
//! what it shows, or begin a line.

use std::borrow::Cow;
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
/// use pfront_files::escape::escaped;
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
