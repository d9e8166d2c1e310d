//! Little-endian arrays in files whose headers may lie.

use bytemuck::Pod;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// Why a file could not be read as what it claims to be. Offsets are in bytes from its start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// Reading failed.
    #[error("at byte {offset}: cannot read on")]
    Io {
        /// Where.
        offset: u64,
        /// Why.
        source: io::Error,
    },
    /// The file ends before something that it announces.
    #[error("at byte {offset}: the file has {length} bytes, too few for {what} ({needed} bytes)")]
    Truncated {
        /// Where it begins.
        offset: u64,
        /// Its name.
        what: &'static str,
        /// Its size in bytes.
        needed: u64,
        /// The size of the file in bytes.
        length: u64,
    },
    /// Something is there that cannot be.
    #[error("at byte {offset}: {what}")]
    Invalid {
        /// Where.
        offset: u64,
        /// The fault, in words.
        what: String,
    },
}

/// Reads arrays; never allocates for more bytes than the file has.
#[derive(Debug)]
pub(crate) struct Reader<R> {
    inner: R,
    offset: u64,
    length: u64,
}

impl<R: Read + Seek> Reader<R> {
    /// Reads `inner` from its start to its end.
    pub(crate) fn new(mut inner: R) -> Result<Self, FormatError> {
        let measured = inner.seek(SeekFrom::End(0)).and_then(|length| {
            inner.rewind()?;
            Ok(length)
        });
        let length = measured.map_err(|source| FormatError::Io { offset: 0, source })?;
        Ok(Self { inner, offset: 0, length })
    }

    /// Bytes left.
    pub(crate) fn left(&self) -> u64 {
        self.length - self.offset
    }

    /// An error about something `back` bytes ago.
    pub(crate) fn invalid(&self, back: u64, what: impl Into<String>) -> FormatError {
        FormatError::Invalid { offset: self.offset - back, what: what.into() }
    }

    /// The number of bytes of `count` elements of `size`, if the file still has as many.
    pub(crate) fn fits(
        &self,
        what: &'static str,
        count: u64,
        size: usize,
    ) -> Result<(), FormatError> {
        let needed = count.saturating_mul(size as u64);
        if needed <= self.left() {
            return Ok(());
        }
        Err(FormatError::Truncated { offset: self.offset, what, needed, length: self.length })
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, FormatError> {
        let mut word = [0_u32];
        self.words(what, &mut word)?;
        Ok(word[0])
    }

    pub(crate) fn u64(&mut self, what: &'static str) -> Result<u64, FormatError> {
        let mut bytes = [0_u8; 8];
        self.bytes(what, &mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    }

    /// `count` elements that consist of 32-bit words.
    pub(crate) fn array<T: Pod>(
        &mut self,
        what: &'static str,
        count: u64,
    ) -> Result<Vec<T>, FormatError> {
        self.fits(what, count, size_of::<T>())?;
        let mut out = vec![T::zeroed(); count as usize];
        self.words(what, &mut out)?;
        Ok(out)
    }

    /// Fills `out`, which consists of 32-bit words.
    pub(crate) fn words<T: Pod>(
        &mut self,
        what: &'static str,
        out: &mut [T],
    ) -> Result<(), FormatError> {
        self.bytes(what, bytemuck::cast_slice_mut(out))?;
        for word in bytemuck::cast_slice_mut::<T, u32>(out) {
            *word = u32::from_le(*word);
        }
        Ok(())
    }

    /// Fills `out`.
    pub(crate) fn bytes(&mut self, what: &'static str, out: &mut [u8]) -> Result<(), FormatError> {
        self.fits(what, out.len() as u64, 1)?;
        let offset = self.offset;
        self.inner.read_exact(out).map_err(|source| FormatError::Io { offset, source })?;
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
