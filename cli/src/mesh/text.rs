//! Lines of words, as OBJ and OFF have them.

use super::error::Fault;
use std::str::FromStr;

/// A line that has words, without its comment.
pub(super) struct Line<'t> {
    /// From 1.
    pub(super) number: usize,
    text: &'t [u8],
}

/// The lines of a file that have words.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let lines = bytes.split(|&b| b == b'\n').zip(1..).map(|(line, number)| {
        let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        Line { number, text: line[..end].trim_ascii() }
    });
    lines.filter(|line| !line.text.is_empty())
}

impl<'t> Line<'t> {
    pub(super) fn words(&self) -> impl Iterator<Item = &'t [u8]> + use<'t> {
        self.text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }

    pub(super) fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::Line(self.number, what.into())
    }

    /// What `word` says.
    pub(super) fn number<T: FromStr>(&self, word: Option<&[u8]>) -> Result<T, Fault> {
        let word = word.ok_or_else(|| self.fault("the line ends too early"))?;
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        let wrong =
            || format!("'{}' is not the number it should be", String::from_utf8_lossy(word));
        parsed.ok_or_else(|| self.fault(wrong()))
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
