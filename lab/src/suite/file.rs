//! Triangle pairs with their truth as a file, for anyone to test an implementation with; and what it
//! answered, as another.
//!
//! # Pairs
//! All numbers are little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `TRIPAIRS` |
//! | 4 | version, u32: 1 |
//! | 4 | number of sets, u32, at most 65,536 |
//! | 8 | seed that the pairs come from, u64 |
//! | for each set: 4, n, 8 | n, u32, at most 255; its name, UTF-8; its number of pairs, u64 |
//! | for each pair, set by set: 72, 1 | a0 a1 a2 b0 b1 b2, each x y z, f32, finite; 1 if they meet, else 0 |
//!
//! Nothing follows. Triangles are closed; one without area is its segment or point.
//!
//! # Answers
//! A byte for each pair, in the order of the pairs: 1 if they meet, else 0. Nothing else.

use super::{BLOCK, Block, Case};
use std::io::{self, ErrorKind, Read, Write};
use thiserror::Error;

const MAGIC: &[u8; 8] = b"TRIPAIRS";
const VERSION: u32 = 1;
const MOST_SETS: u32 = 65_536;
const LONGEST_NAME: u32 = 255;
/// Bytes of a pair.
const PAIR: usize = 73;

/// Why a file of pairs or answers is refused.
#[derive(Debug, Error)]
pub enum FileError {
    /// It cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It does not begin like one.
    #[error("not a file of triangle pairs: it does not begin with TRIPAIRS")]
    Magic,
    /// Of another version.
    #[error("version {found} of the format is unknown; this is version {VERSION}")]
    Version {
        /// Its version.
        found: u32,
    },
    /// It ends within its list of sets.
    #[error("the file ends before its list of sets does")]
    Header,
    /// There are too many sets.
    #[error("{found} sets are more than {MOST_SETS}: the file is damaged")]
    Sets {
        /// How many it says there are.
        found: u32,
    },
    /// The name of a set is too long or not UTF-8.
    #[error("the name of set {set} is longer than {LONGEST_NAME} bytes or not UTF-8")]
    Name {
        /// Which, from 0.
        set: usize,
    },
    /// It ends before all pairs were read.
    #[error("the file ends at pair {pair} of set '{set}', which has {pairs}")]
    Short {
        /// The set.
        set: String,
        /// The first pair that is not whole, from 0.
        pair: u64,
        /// How many it should have.
        pairs: u64,
    },
    /// A coordinate is infinite or no number.
    #[error("pair {pair} of set '{set}' has a coordinate that is not finite")]
    Coordinate {
        /// The set.
        set: String,
        /// The pair, from 0.
        pair: u64,
    },
    /// A truth is neither 0 nor 1.
    #[error("the truth of pair {pair} of set '{set}' is {found}; it must be 0 or 1")]
    Truth {
        /// The set.
        set: String,
        /// The pair, from 0.
        pair: u64,
        /// The byte.
        found: u8,
    },
    /// It goes on after its last pair, or answer.
    #[error("the file goes on after the last pair")]
    Long,
    /// There are fewer answers than pairs.
    #[error("there are only {found} answers: there must be one byte for each pair")]
    Answers {
        /// How many there are.
        found: u64,
    },
    /// An answer is neither 0 nor 1.
    #[error("answer {at} is {found}; it must be 0 or 1")]
    Answer {
        /// Which, from 0.
        at: u64,
        /// The byte.
        found: u8,
    },
}

/// Writes pairs.
#[derive(Debug)]
pub struct Writer<W> {
    to: W,
}

impl<W: Write> Writer<W> {
    /// Begins a file of sets, each with its name and number of pairs, which have to follow in this order.
    ///
    /// # Errors
    /// [`FileError::Name`], [`FileError::Sets`], [`FileError::Io`].
    pub fn new(mut to: W, seed: u64, sets: &[(String, u64)]) -> Result<Self, FileError> {
        let count = sets.len() as u32;
        if count > MOST_SETS {
            return Err(FileError::Sets { found: count });
        }
        to.write_all(MAGIC)?;
        to.write_all(&VERSION.to_le_bytes())?;
        to.write_all(&count.to_le_bytes())?;
        to.write_all(&seed.to_le_bytes())?;
        for (set, (name, pairs)) in sets.iter().enumerate() {
            let length = name.len() as u32;
            if length > LONGEST_NAME {
                return Err(FileError::Name { set });
            }
            to.write_all(&length.to_le_bytes())?;
            to.write_all(name.as_bytes())?;
            to.write_all(&pairs.to_le_bytes())?;
        }
        Ok(Self { to })
    }

    /// Writes the next pairs.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn add(&mut self, cases: &[Case]) -> Result<(), FileError> {
        let mut bytes = Vec::with_capacity(cases.len() * PAIR);
        for Case { a, b, meets } in cases {
            let coordinates = a.iter().chain(b).flatten();
            bytes.extend(coordinates.flat_map(|x| x.to_le_bytes()));
            bytes.push(u8::from(*meets));
        }
        Ok(self.to.write_all(&bytes)?)
    }

    /// Hands back what was written to.
    pub fn finish(self) -> W {
        self.to
    }
}

/// Reads pairs, a block at a time.
#[derive(Debug)]
pub struct Reader<R> {
    from: R,
    seed: u64,
    sets: Vec<(String, u64)>,
    /// The set that is read, and how many of its pairs have been.
    at: (usize, u64),
}

impl<R: Read> Reader<R> {
    /// Reads the list of sets. Give it a buffered reader.
    ///
    /// # Errors
    /// [`FileError`] says what is wrong with it.
    pub fn new(mut from: R) -> Result<Self, FileError> {
        let mut magic = [0; 8];
        read(&mut from, &mut magic, || FileError::Magic)?;
        if &magic != MAGIC {
            return Err(FileError::Magic);
        }
        let version = number(&mut from)?;
        if version != VERSION {
            return Err(FileError::Version { found: version });
        }
        let count = number(&mut from)?;
        if count > MOST_SETS {
            return Err(FileError::Sets { found: count });
        }
        let seed = long_number(&mut from)?;
        let mut sets = Vec::new();
        for set in 0..count as usize {
            let length = number(&mut from)?;
            if length > LONGEST_NAME {
                return Err(FileError::Name { set });
            }
            let mut name = vec![0; length as usize];
            read(&mut from, &mut name, || FileError::Header)?;
            let name = String::from_utf8(name).map_err(|_| FileError::Name { set })?;
            sets.push((name, long_number(&mut from)?));
        }
        Ok(Self { from, seed, sets, at: (0, 0) })
    }

    /// The seed that the pairs come from.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The sets: name, and number of pairs.
    #[must_use]
    pub fn sets(&self) -> &[(String, u64)] {
        &self.sets
    }

    /// The next block; `None` after the last, when the file ends as it should.
    ///
    /// # Errors
    /// [`FileError`] names the pair at fault.
    pub fn next_block(&mut self) -> Result<Option<Block>, FileError> {
        while self.sets.get(self.at.0).is_some_and(|(_, pairs)| self.at.1 >= *pairs) {
            self.at = (self.at.0 + 1, 0);
        }
        let (set, first) = self.at;
        let Some((name, pairs)) = self.sets.get(set) else {
            return if self.from.read(&mut [0])? == 0 { Ok(None) } else { Err(FileError::Long) };
        };
        let length = (pairs - first).min(BLOCK as u64);
        let mut cases = Vec::with_capacity(length as usize);
        for pair in first..first + length {
            let mut bytes = [0; PAIR];
            let short = || FileError::Short { set: name.clone(), pair, pairs: *pairs };
            read(&mut self.from, &mut bytes, short)?;
            let point =
                |i: usize| [0, 1, 2].map(|k| f32::from_le_bytes(four(&bytes, 12 * i + 4 * k)));
            let [a, b] = [0, 3].map(|first| [0, 1, 2].map(|i| point(first + i)));
            if a.iter().chain(&b).flatten().any(|x| !x.is_finite()) {
                return Err(FileError::Coordinate { set: name.clone(), pair });
            }
            let meets = match bytes[PAIR - 1] {
                truth @ 0..=1 => truth == 1,
                found => return Err(FileError::Truth { set: name.clone(), pair, found }),
            };
            cases.push(Case { a, b, meets });
        }
        self.at.1 += length;
        Ok(Some(Block { set, cases }))
    }
}

/// Four bytes of a pair.
fn four(bytes: &[u8; PAIR], at: usize) -> [u8; 4] {
    [0, 1, 2, 3].map(|i| bytes[at + i])
}

fn number(from: &mut impl Read) -> Result<u32, FileError> {
    let mut bytes = [0; 4];
    read(from, &mut bytes, || FileError::Header)?;
    Ok(u32::from_le_bytes(bytes))
}

fn long_number(from: &mut impl Read) -> Result<u64, FileError> {
    let mut bytes = [0; 8];
    read(from, &mut bytes, || FileError::Header)?;
    Ok(u64::from_le_bytes(bytes))
}

/// Fills `bytes`, or says what a file that ends before has failed to give.
pub(super) fn read(
    from: &mut impl Read,
    bytes: &mut [u8],
    short: impl FnOnce() -> FileError,
) -> Result<(), FileError> {
    from.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => short(),
        _ => error.into(),
    })
}
