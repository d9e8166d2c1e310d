//! Binary files of 32-bit words, little-endian, whose announcements are not believed. Errors tell the byte.

use anyhow::{Context, Error, Result, anyhow, ensure};
use bytemuck::Pod;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// Reads arrays; never allocates for more bytes than the file has.
#[derive(Debug)]
pub(crate) struct Reader<R> {
    inner: R,
    offset: u64,
    length: u64,
}

impl<R: Read + Seek> Reader<R> {
    /// Reads `inner` from its start, where it has a magic, to its end; `what` it is.
    pub(crate) fn new(mut inner: R, magic: &[u8; 8], what: &str) -> Result<Self> {
        let length = inner.seek(SeekFrom::End(0))?;
        inner.rewind()?;
        let mut reader = Self { inner, offset: 0, length };
        let mut found = [0; 8];
        reader.bytes("the magic", &mut found)?;
        let name = String::from_utf8_lossy(magic);
        let wrong = || format!("at byte 0: this is not {what}: it does not begin with {name}");
        ensure!(found == *magic, wrong());
        Ok(reader)
    }

    /// An error about something `back` bytes ago.
    pub(crate) fn invalid(&self, back: u64, what: impl std::fmt::Display) -> Error {
        anyhow!("at byte {}: {what}", self.offset - back)
    }

    /// Checks that the file still has `count` elements of `size` bytes.
    pub(crate) fn fits(&self, what: &str, count: u64, size: usize) -> Result<()> {
        let needed = count.saturating_mul(size as u64);
        let length = self.length;
        let few = || format!("the file has {length} bytes, too few for {what} ({needed} bytes)");
        if needed <= length - self.offset { Ok(()) } else { Err(self.invalid(0, few())) }
    }

    /// Checks that nothing follows so many bytes, which are `what`.
    pub(crate) fn ends_after(&self, what: &str, bytes: u64) -> Result<()> {
        match self.length - self.offset - bytes {
            0 => Ok(()),
            left => Err(self.invalid(0, format!("{left} bytes more than {what} take"))),
        }
    }

    pub(crate) fn u32(&mut self, what: &str) -> Result<u32> {
        let mut word = [0_u32];
        self.words(what, &mut word)?;
        Ok(word[0])
    }

    /// `count` elements that consist of 32-bit words.
    pub(crate) fn array<T: Pod>(&mut self, what: &str, count: u64) -> Result<Vec<T>> {
        self.fits(what, count, size_of::<T>())?;
        let mut out = vec![T::zeroed(); count as usize];
        self.words(what, &mut out)?;
        Ok(out)
    }

    /// Fills `out`, which consists of 32-bit words.
    pub(crate) fn words<T: Pod>(&mut self, what: &str, out: &mut [T]) -> Result<()> {
        self.bytes(what, bytemuck::cast_slice_mut(out))?;
        for word in bytemuck::cast_slice_mut::<T, u32>(out) {
            *word = u32::from_le(*word);
        }
        Ok(())
    }

    fn bytes(&mut self, what: &str, out: &mut [u8]) -> Result<()> {
        self.fits(what, out.len() as u64, 1)?;
        let offset = self.offset;
        let read = self.inner.read_exact(out);
        read.with_context(|| format!("at byte {offset}: cannot read on"))?;
        self.offset += out.len() as u64;
        Ok(())
    }
}

/// Writes elements that consist of 32-bit words.
pub(crate) fn write_words<T: Pod>(to: &mut impl Write, elements: &[T]) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        return to.write_all(bytemuck::cast_slice(elements));
    }
    let words = bytemuck::cast_slice::<T, u32>(elements).iter();
    words.copied().try_for_each(|word| to.write_all(&word.to_le_bytes()))
}
