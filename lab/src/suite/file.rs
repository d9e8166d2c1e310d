//! Triangle pairs with their truth as a file, for anyone to test an implementation with; and its answers, as another.
//!
//! # Pairs
//! All numbers are little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `TRIPAIRS` |
//! | 4 | version, u32: 1 |
//! | 4 | number of sets, u32 |
//! | 8 | seed that the pairs come from, u64 |
//! | for each set: 4, n, 8 | n, u32, at most 255; its name, UTF-8; its number of pairs, u64 |
//! | for each pair, set by set: 72, 1 | a0 a1 a2 b0 b1 b2, each x y z, f32, finite; 1 if they meet, else 0 |
//!
//! Nothing follows. Triangles are closed; one without area is its segment or point.
//!
//! # Answers
//! A byte for each pair, in the order of the pairs: 1 if they meet, else 0. Nothing else.

use super::{BLOCK, Block, Case};
use crate::format::{self, FormatError};
use anyhow::{Result, ensure};
use std::io::{self, Read, Seek, Write};

const MAGIC: &[u8; 8] = b"TRIPAIRS";
const VERSION: u32 = 1;
const LONGEST_NAME: u32 = 255;
/// Bytes of a pair.
const PAIR: usize = 73;

/// Writes pairs.
#[derive(Debug)]
pub struct Writer<W> {
    to: W,
}

impl<W: Write> Writer<W> {
    /// Begins a file of sets, each with its name and number of pairs, which have to follow in this order.
    ///
    /// # Errors
    /// Fails as `to` does; so does [`Writer::add`].
    pub fn new(mut to: W, seed: u64, sets: &[(String, u64)]) -> io::Result<Self> {
        to.write_all(MAGIC)?;
        to.write_all(&VERSION.to_le_bytes())?;
        to.write_all(&(sets.len() as u32).to_le_bytes())?;
        to.write_all(&seed.to_le_bytes())?;
        for (name, pairs) in sets {
            to.write_all(&(name.len() as u32).to_le_bytes())?;
            to.write_all(name.as_bytes())?;
            to.write_all(&pairs.to_le_bytes())?;
        }
        Ok(Self { to })
    }

    /// Writes the next pairs.
    pub fn add(&mut self, cases: &[Case]) -> io::Result<()> {
        for Case { a, b, meets } in cases {
            format::write_words(&mut self.to, &[*a, *b])?;
            self.to.write_all(&[u8::from(*meets)])?;
        }
        Ok(())
    }

    /// Hands back what was written to.
    pub fn finish(self) -> W {
        self.to
    }
}

/// Reads pairs, a block at a time.
#[derive(Debug)]
pub struct Reader<R> {
    from: format::Reader<R>,
    seed: u64,
    sets: Vec<(String, u64)>,
    /// The set that is read, and how many of its pairs have been.
    at: (usize, u64),
}

impl<R: Read + Seek> Reader<R> {
    /// Reads the list of sets, and checks that their pairs are there. Give it a buffered reader.
    ///
    /// # Errors
    /// [`FormatError`] says what is wrong, and where.
    pub fn new(from: R) -> Result<Self, FormatError> {
        let mut from = format::Reader::new(from)?;
        let mut magic = [0; 8];
        from.bytes("the magic", &mut magic)?;
        if &magic != MAGIC {
            return Err(from.invalid(
                8,
                "this is not a file of triangle pairs: it does not begin with TRIPAIRS",
            ));
        }
        let version = from.u32("the version")?;
        if version != VERSION {
            return Err(from.invalid(4, format!("version {version} is unknown; this is {VERSION}")));
        }
        let count = from.u32("the number of sets")?;
        let seed = from.u64("the seed")?;
        from.fits("the sets", count.into(), 12)?;
        let (mut sets, mut total) = (Vec::new(), 0_u64);
        for set in 0..count {
            let length = from.u32("the length of a name")?;
            let wrong =
                format!("the name of set {set} is longer than {LONGEST_NAME} bytes or not UTF-8");
            if length > LONGEST_NAME {
                return Err(from.invalid(4, wrong));
            }
            let mut name = vec![0; length as usize];
            from.bytes("the name of a set", &mut name)?;
            let name = String::from_utf8(name).map_err(|_| from.invalid(length.into(), wrong))?;
            let pairs = from.u64("the number of pairs")?;
            total = total.saturating_add(pairs);
            sets.push((name, pairs));
        }
        from.fits("the pairs", total, PAIR)?;
        match from.left() - total * PAIR as u64 {
            0 => Ok(Self { from, seed, sets, at: (0, 0) }),
            left => Err(from.invalid(0, format!("{left} bytes more than the pairs take"))),
        }
    }

    /// The seed that the pairs come from.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The sets: name, and number of pairs.
    pub fn sets(&self) -> &[(String, u64)] {
        &self.sets
    }

    /// The next block; `None` after the last.
    ///
    /// # Errors
    /// [`FormatError`] names the pair at fault.
    pub fn next_block(&mut self) -> Result<Option<Block>, FormatError> {
        while self.sets.get(self.at.0).is_some_and(|(_, pairs)| self.at.1 >= *pairs) {
            self.at = (self.at.0 + 1, 0);
        }
        let (set, first) = self.at;
        let Some((name, pairs)) = self.sets.get(set) else { return Ok(None) };
        let length = (pairs - first).min(BLOCK as u64);
        let mut cases = Vec::with_capacity(length as usize);
        for pair in first..first + length {
            let (mut corners, mut truth) = ([[[0_f32; 3]; 3]; 2], [0]);
            self.from.words("a pair", &mut corners)?;
            self.from.bytes("the truth of a pair", &mut truth)?;
            let wrong = match truth[0] {
                _ if !corners.iter().flatten().flatten().all(|x| x.is_finite()) => {
                    "a coordinate that is not finite".to_owned()
                }
                0 | 1 => {
                    let [a, b] = corners;
                    cases.push(Case { a, b, meets: truth[0] == 1 });
                    continue;
                }
                found => format!("the truth {found}, which must be 0 or 1"),
            };
            return Err(self
                .from
                .invalid(PAIR as u64, format!("pair {pair} of set '{name}' has {wrong}")));
        }
        self.at.1 += length;
        Ok(Some(Block { set, cases }))
    }
}

/// Checks somebody's answers to so many pairs.
///
/// # Errors
/// If there are fewer or more, or one is neither 0 nor 1.
pub fn answers(bytes: &[u8], pairs: u64) -> Result<Vec<bool>> {
    let found = bytes.len();
    ensure!(
        found as u64 == pairs,
        "there are {found} answers to {pairs} pairs: write one byte for each"
    );
    let wrong = bytes.iter().position(|byte| *byte > 1);
    ensure!(wrong.is_none(), "answer {} is neither 0 nor 1", wrong.unwrap_or_default());
    Ok(bytes.iter().map(|byte| *byte == 1).collect())
}
