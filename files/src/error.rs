//! Why a file is no mesh.

use crate::escape::shown_path;
use std::path::{Path, PathBuf};
use std::{error, fmt, io};

/// Why a mesh file could not be read.
#[derive(Debug)]
pub struct ReadError {
    path: PathBuf,
    fault: Fault,
}

/// Options that may help where a file is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// The file may have another format than its name tells: [`ReadOptions::format`](crate::ReadOptions::format).
    Format,
    /// The file takes more memory than it may: [`ReadOptions::memory`](crate::ReadOptions::memory).
    Memory,
    /// The file names another outside of its folder:
    /// [`ReadOptions::allow_outside_files`](crate::ReadOptions::allow_outside_files).
    OutsideFiles,
}

/// The fault of a file, and where it is.
#[derive(Debug)]
pub(crate) struct Fault {
    place: Place,
    what: String,
    remedy: Option<Remedy>,
}

#[derive(Debug)]
enum Place {
    /// The file cannot be read.
    Io(io::Error),
    /// A line of a text file, from 1.
    Line(usize),
    /// A record of a binary file, which begins at this byte.
    Byte(usize),
    Whole,
}

impl Fault {
    pub(crate) fn broken(what: impl Into<String>) -> Self {
        Self { place: Place::Whole, what: what.into(), remedy: None }
    }

    pub(crate) fn line(line: usize, what: impl Into<String>) -> Self {
        Self { place: Place::Line(line), ..Self::broken(what) }
    }

    pub(crate) fn byte(byte: usize, what: impl Into<String>) -> Self {
        Self { place: Place::Byte(byte), ..Self::broken(what) }
    }

    /// The fault of a file that has vertices and what was passed over, and no triangle.
    pub(crate) fn no_triangle(vertices: usize, notes: &[String]) -> Self {
        let mut what = "there is no triangle in it".to_owned();
        if vertices > 0 {
            what += &format!(", but vertices: {vertices}");
        }
        notes.iter().for_each(|note| what += &format!("; {note}"));
        Self::broken(what).or(Remedy::Format)
    }

    /// More than so many bytes are needed.
    pub(crate) fn memory(most: usize) -> Self {
        let most = most.div_ceil(1_000_000);
        Self::broken(format!("needs more than {most} MB while it is read")).or(Remedy::Memory)
    }

    /// The same fault of a file for which there is a remedy.
    pub(crate) fn or(self, remedy: Remedy) -> Self {
        Self { remedy: Some(remedy), ..self }
    }

    /// The same fault with the part of the file that it is in, unless it is named already.
    pub(crate) fn within(self, part: impl fmt::Display) -> Self {
        match self {
            Self { place: Place::Whole, what, remedy: None } => {
                Self::broken(format!("{part}: {what}"))
            }
            fault => fault,
        }
    }

    pub(crate) fn at(self, path: &Path) -> ReadError {
        ReadError { path: path.to_owned(), fault: self }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self { place: Place::Io(error), what: String::new(), remedy: None }
    }
}

impl ReadError {
    /// The option that may help.
    pub fn remedy(&self) -> Option<Remedy> {
        self.fault.remedy
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = shown_path(&self.path);
        let what = &self.fault.what;
        match &self.fault.place {
            Place::Io(_) => write!(f, "cannot read {path}"),
            Place::Line(line) => write!(f, "{path}, line {line}: {what}"),
            Place::Byte(byte) => write!(f, "{path}, byte {byte}: {what}"),
            Place::Whole => write!(f, "{path}: {what}"),
        }
    }
}

impl error::Error for ReadError {
    fn source(&self) -> Option<&(dyn error::Error + 'static)> {
        match &self.fault.place {
            Place::Io(source) => Some(source),
            _ => None,
        }
    }
}
