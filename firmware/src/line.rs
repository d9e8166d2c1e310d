//! Lines of text without `core::fmt`, which takes 4 KiB of flash and can panic.

use core::ffi::CStr;

/// A line of up to 95 characters; what does not fit is left out.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    text: [u8; 96],
    len: usize,
}

impl Line {
    /// An empty line.
    pub const EMPTY: Self = Self { text: [0; 96], len: 0 };

    /// The line with a number and what it counts.
    #[must_use]
    pub fn with(mut self, number: u32, what: &str) -> Self {
        let mut unit = 1;
        while number / 10 >= unit {
            unit *= 10;
        }
        while unit > 0 {
            self.push(b'0' + (number / unit % 10) as u8);
            unit /= 10;
        }
        what.bytes().for_each(|byte| self.push(byte));
        self
    }

    fn push(&mut self, byte: u8) {
        // The last one stays zero.
        if let [text @ .., _] = &mut self.text
            && let Some(free) = text.get_mut(self.len)
        {
            *free = byte;
            self.len += 1;
        }
    }

    /// The line as C has it, to be printed over semihosting.
    #[must_use]
    pub fn as_c_str(&self) -> &CStr {
        CStr::from_bytes_until_nul(&self.text).unwrap_or_default()
    }
}
