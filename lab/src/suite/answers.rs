//! Somebody's answers to a file of pairs.

use super::FileError;
use super::file::read;
use std::io::Read;

/// Reads answers, as many at a time as there are questions.
#[derive(Debug)]
pub struct Answers<R> {
    from: R,
    read: u64,
}

impl<R: Read> Answers<R> {
    /// Answers as [`file`](super::file) describes them. Give it a buffered reader.
    #[must_use]
    pub fn new(from: R) -> Self {
        Self { from, read: 0 }
    }

    /// The next `count` answers.
    ///
    /// # Errors
    /// [`FileError::Answers`] if there are fewer, [`FileError::Answer`] names one that is none.
    pub fn next(&mut self, count: usize) -> Result<Vec<bool>, FileError> {
        let mut answers = Vec::with_capacity(count);
        for _ in 0..count {
            let mut byte = [0];
            read(&mut self.from, &mut byte, || FileError::Answers { found: self.read })?;
            answers.push(match byte {
                [answer @ 0..=1] => answer == 1,
                [found] => return Err(FileError::Answer { at: self.read, found }),
            });
            self.read += 1;
        }
        Ok(answers)
    }

    /// Sees to it that there are no more.
    ///
    /// # Errors
    /// [`FileError::Long`].
    pub fn finish(mut self) -> Result<(), FileError> {
        if self.from.read(&mut [0])? == 0 { Ok(()) } else { Err(FileError::Long) }
    }
}
