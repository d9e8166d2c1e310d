//! Lines of words, as OBJ, OFF and the texts of PLY and STL have them.

use crate::error::Fault;
use crate::source::Source;
use std::str::FromStr;

/// A line that has words, without its comment.
#[derive(Clone, Copy)]
pub(crate) struct Line<'t> {
    /// From 1.
    pub(crate) number: usize,
    text: &'t [u8],
}

/// The lines of a file that have words. They end as in Unix or Windows, or in a file without `\n` as on
/// old Macs.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> + Clone {
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let lines = bytes.split(move |&b| b == end).zip(1..).map(|(line, number)| {
        // Within a word it is a part of a name.
        let begins =
            |&at: &usize| line[at] == b'#' && (at == 0 || line[at - 1].is_ascii_whitespace());
        let end = (0..line.len()).find(begins).unwrap_or(line.len());
        Line::new(number, &line[..end])
    });
    lines.filter(|line| !line.text.is_empty())
}

/// The bytes of a text before the NULs that some programs end it with.
pub(crate) fn without_padding(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    &bytes[..end]
}

/// Whether a file that begins so is text in UTF-16, and then whether the high byte of each unit comes first.
pub(crate) fn utf16(head: &[u8]) -> Option<bool> {
    match head {
        [0xff, 0xfe, _, 0, ..] => Some(false),
        [0xfe, 0xff, 0, _, ..] => Some(true),
        _ => None,
    }
}

/// The text of a file in UTF-16, without its mark.
pub(crate) fn from_utf16(bytes: Vec<u8>, is_big: bool) -> Result<String, Fault> {
    let (pairs, over) = bytes[2..].as_chunks();
    let unit = |&pair: &[u8; 2]| match is_big {
        true => u16::from_be_bytes(pair),
        false => u16::from_le_bytes(pair),
    };
    let text: Result<String, _> = char::decode_utf16(pairs.iter().map(unit)).collect();
    text.ok().filter(|_| over.is_empty()).ok_or_else(|| Fault::broken("it is no text of UTF-16"))
}

/// A word for an error text, on one line however long and strange it is.
pub(crate) fn quote(word: &[u8]) -> String {
    let (shown, rest) = word.split_at(word.len().min(40));
    format!("'{}{}'", shown.escape_ascii(), if rest.is_empty() { "" } else { "…" })
}

/// The words of a line, or those that are left of it.
#[derive(Clone, Copy)]
pub(crate) struct Words<'t>(&'t [u8]);

impl<'t> Iterator for Words<'t> {
    type Item = &'t [u8];

    fn next(&mut self) -> Option<&'t [u8]> {
        let text = self.0.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

impl<'t> Line<'t> {
    pub(crate) fn new(number: usize, text: &'t [u8]) -> Self {
        Self { number, text: text.trim_ascii() }
    }

    pub(crate) fn words(&self) -> Words<'t> {
        Words(self.text)
    }

    pub(crate) fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::line(self.number, what.into())
    }

    /// A word that has to be there.
    pub(crate) fn word<'w>(&self, word: Option<&'w [u8]>) -> Result<&'w [u8], Fault> {
        word.ok_or_else(|| self.fault("the line ends too early"))
    }

    /// The number that `word` states.
    pub(crate) fn number<T: FromStr>(&self, word: Option<&[u8]>) -> Result<T, Fault> {
        let word = self.word(word)?;
        parsed(word).ok_or_else(|| self.no_number(word))
    }

    fn no_number(&self, word: &[u8]) -> Fault {
        self.fault(format!("{} is not the number it should be", quote(word)))
    }

    /// The next three words as coordinates.
    pub(crate) fn position<'w>(
        &self,
        words: &mut impl Iterator<Item = &'w [u8]>,
        source: &mut Source,
    ) -> Result<[f64; 3], Fault> {
        let mut next = || self.coordinate(words.next(), source);
        Ok([next()?, next()?, next()?])
    }

    /// The number nearest to what `word` says; `source` tells in which precision, and notes what it loses.
    pub(crate) fn coordinate(
        &self,
        word: Option<&[u8]>,
        source: &mut Source,
    ) -> Result<f64, Fault> {
        let word = self.word(word)?;
        coordinate(word, source).ok_or_else(|| self.no_number(word))
    }
}

/// The number nearest to what `word` says, if it is one; `source` tells in which precision, and notes what it loses.
fn coordinate(word: &[u8], source: &mut Source) -> Option<f64> {
    if !source.in_f32 {
        return decimal(word);
    }
    let nearest: f32 = decimal(word)?;
    source.rounded += usize::from(loses_digits(word, nearest));
    Some(nearest.into())
}

/// The number that a word is, also if that is NaN or infinite, as C libraries write it.
pub(crate) fn decimal<T: FromStr + From<f32>>(word: &[u8]) -> Option<T> {
    parsed(word).or_else(|| not_finite(word).map(T::from))
}

/// NaN and infinity as `-nan(ind)`, `1.#QNAN` and `-1.#INF`.
fn not_finite(word: &[u8]) -> Option<f32> {
    let word = word.strip_prefix(b"-").unwrap_or(word).to_ascii_lowercase();
    let begins = |words: &[&str]| words.iter().any(|begin| word.starts_with(begin.as_bytes()));
    match word {
        _ if begins(&["nan(", "1.#ind", "1.#qnan", "1.#snan"]) => Some(f32::NAN),
        _ if begins(&["1.#inf"]) => Some(f32::INFINITY),
        _ => None,
    }
}

fn parsed<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Whether a decimal has digits that the nearest f32, rounded to as many, does not.
fn loses_digits(word: &[u8], nearest: f32) -> bool {
    let is_exponent = |b: &u8| b.eq_ignore_ascii_case(&b'e');
    // Every decimal of six digits comes back from the nearest f32, unless it is beyond the range.
    if word.len() <= 6 && !word.iter().any(is_exponent) {
        return false;
    }
    let Ok(text) = std::str::from_utf8(word) else { return false };
    let Ok(written) = text.parse::<f64>() else { return false };
    let error = (written - f64::from(nearest)).abs();
    let mut parts = text.split(['e', 'E']);
    let decimals = parts.next().and_then(|mantissa| Some(mantissa.split_once('.')?.1.len()));
    let exponent: i32 = parts.next().and_then(|exponent| exponent.parse().ok()).unwrap_or(0);
    // An infinity is refused later.
    nearest.is_finite()
        && error > 0.5 * 10_f64.powi(exponent.saturating_sub(decimals.unwrap_or(0) as i32))
}
