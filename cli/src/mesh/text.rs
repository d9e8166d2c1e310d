//! Lines of words, as OBJ, OFF and the texts of PLY and STL have them.

use super::error::Fault;
use std::str::FromStr;

/// A line that has words, without its comment.
pub(super) struct Line<'t> {
    /// From 1.
    pub(super) number: usize,
    text: &'t [u8],
}

/// The lines of a file that have words. They end as in Unix or Windows, or in a file without `\n` as on
/// old Macs.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let lines = bytes.split(move |&b| b == end).zip(1..).map(|(line, number)| {
        let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        Line { number, text: line[..end].trim_ascii() }
    });
    lines.filter(|line| !line.text.is_empty())
}

/// A word for an error text, on one line however long and strange it is.
pub(super) fn quote(word: &[u8]) -> String {
    let (shown, rest) = word.split_at(word.len().min(40));
    format!("'{}{}'", shown.escape_ascii(), if rest.is_empty() { "" } else { "…" })
}

impl<'t> Line<'t> {
    pub(super) fn words(&self) -> impl Iterator<Item = &'t [u8]> + use<'t> {
        self.text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::Line(self.number, what.into())
    }

    /// A word that has to be there.
    pub(super) fn word<'w>(&self, word: Option<&'w [u8]>) -> Result<&'w [u8], Fault> {
        word.ok_or_else(|| self.fault("the line ends too early"))
    }

    /// What `word` says.
    pub(super) fn number<T: FromStr>(&self, word: Option<&[u8]>) -> Result<T, Fault> {
        let word = self.word(word)?;
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| self.fault(format!("{} is not the number it should be", quote(word))))
    }

    /// The next three words as coordinates.
    pub(super) fn position<'w>(
        &self,
        words: &mut impl Iterator<Item = &'w [u8]>,
    ) -> Result<[f32; 3], Fault> {
        let [x, y, z] = [words.next(), words.next(), words.next()];
        Ok([self.number(x)?, self.number(y)?, self.number(z)?])
    }
}
