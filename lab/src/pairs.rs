//! Files of triangle pairs, frame by frame.
//!
//! Little-endian: magic `TRICOLP1`, u32 number of frames, u32 0; per frame u64 n and n pairs of u32
//! (a, b), sorted. Within one mesh a < b; of many objects, triangles are numbered through in the order
//! of the objects, and a belongs to the lower one.

use crate::format::write_words;
use pfront::TrianglePair;
use std::io::{self, Write};

const MAGIC: &[u8; 8] = b"TRICOLP1";

/// Writes a pair file; it is whole after as many frames as announced.
#[derive(Debug)]
pub struct PairWriter<W>(W);

impl<W: Write> PairWriter<W> {
    /// Begins a file of `frames` frames.
    ///
    /// # Errors
    /// Fails as `to` does; so do the other methods.
    pub fn new(mut to: W, frames: u32) -> io::Result<Self> {
        to.write_all(MAGIC)?;
        write_words(&mut to, &[frames, 0])?;
        Ok(Self(to))
    }

    /// Writes the sorted pairs of the next frame.
    pub fn frame(&mut self, pairs: &[TrianglePair]) -> io::Result<()> {
        self.0.write_all(&(pairs.len() as u64).to_le_bytes())?;
        write_words(&mut self.0, pairs)
    }

    /// Gives back where it was written to, which may have a buffer.
    pub fn finish(self) -> W {
        self.0
    }
}
