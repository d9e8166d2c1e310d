//! Why a file is no mesh.

use super::FORMATS;
use std::io;
use std::path::{Path, PathBuf};

/// Why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// No reader for this extension.
    #[error("{}: unknown format; known are {}", path.display(), FORMATS.join(", "))]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file could not be read.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A line of a text file is wrong.
    #[error("{}, line {line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A record of a binary file is wrong.
    #[error("{}, byte {byte}: {what}", path.display())]
    Byte {
        /// The file.
        path: PathBuf,
        /// Where the record begins, from 0.
        byte: usize,
        /// What is wrong.
        what: String,
    },
    /// The file is not what its extension says.
    #[error("{}: {what}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

/// A [`ReadError`] that does not know its file yet.
#[derive(Debug)]
pub(super) enum Fault {
    Io(io::Error),
    Line(usize, String),
    Byte(usize, String),
    Broken(String),
}

impl Fault {
    pub(super) fn broken(what: impl Into<String>) -> Self {
        Self::Broken(what.into())
    }

    pub(super) fn no_triangle() -> Self {
        Self::broken("there is no triangle in it")
    }

    pub(super) fn at(self, path: &Path) -> ReadError {
        let path = path.to_owned();
        match self {
            Self::Io(source) => ReadError::Io { path, source },
            Self::Line(line, what) => ReadError::Line { path, line, what },
            Self::Byte(byte, what) => ReadError::Byte { path, byte, what },
            Self::Broken(what) => ReadError::Broken { path, what },
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}
