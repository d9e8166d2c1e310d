//! Files of triangle pairs, frame by frame.
//!
//! Little-endian: magic `TRICOLP1`, u32 number of frames, u32 0; per frame u64 n and n pairs of u32
//! (a, b), sorted. Within one mesh a < b; of many objects, triangles are numbered through in the order
//! of the objects, and a belongs to the lower one.

use crate::format::{Reader, write_words};
use anyhow::Result;
use pfront::TrianglePair;
use std::io::{self, Read, Seek, Write};

const MAGIC: &[u8; 8] = b"TRICOLP1";

/// Writes a pair file; it is whole after as many frames as announced.
#[derive(Debug)]
pub struct PairWriter<W> {
    to: W,
}

impl<W: Write> PairWriter<W> {
    /// Begins a file of `frames` frames.
    ///
    /// # Errors
    /// Fails as `to` does; so do the other methods.
    pub fn new(mut to: W, frames: u32) -> io::Result<Self> {
        to.write_all(MAGIC)?;
        write_words(&mut to, &[frames, 0])?;
        Ok(Self { to })
    }

    /// Writes the sorted pairs of the next frame.
    pub fn frame(&mut self, pairs: &[TrianglePair]) -> io::Result<()> {
        self.to.write_all(&(pairs.len() as u64).to_le_bytes())?;
        write_words(&mut self.to, pairs)
    }

    /// Gives back where it was written to, which may have a buffer.
    pub fn finish(self) -> W {
        self.to
    }
}

/// Reads all frames of a pair file.
///
/// # Errors
/// The offset of what is not as the format says: also pairs out of order, and bytes after the last frame.
pub fn read(from: impl Read + Seek) -> Result<Vec<Vec<TrianglePair>>> {
    let mut reader = Reader::new(from, MAGIC, "a pair file")?;
    let frames = reader.u32("the number of frames")?;
    if reader.u32("the reserved word")? != 0 {
        return Err(reader.invalid(4, "the reserved word is not 0"));
    }
    reader.fits("the frames", frames.into(), 8)?;
    let mut all = Vec::with_capacity(frames as usize);
    for _ in 0..frames {
        let mut halves = [0_u32; 2];
        reader.words("the number of pairs", &mut halves)?;
        let count = u64::from(halves[0]) | u64::from(halves[1]) << 32;
        let pairs: Vec<TrianglePair> = reader.array("the pairs of a frame", count)?;
        if let Some(i) = (1..pairs.len()).find(|&i| pairs[i - 1] >= pairs[i]) {
            let back = (pairs.len() - i) * size_of::<TrianglePair>();
            return Err(reader.invalid(back as u64, "the pairs are not sorted"));
        }
        all.push(pairs);
    }
    reader.ends_after("the pairs", 0)?;
    Ok(all)
}
