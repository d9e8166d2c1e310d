//! Why a file is no mesh.

use super::format::FORMATS;
use crate::escape::shown_path;
use std::path::{Path, PathBuf};
use std::{error, fmt, io};

/// Why a mesh file could not be read.
#[derive(Debug)]
pub struct ReadError {
    path: PathBuf,
    fault: Fault,
}

/// The fault of a file, and where it is.
#[derive(Debug)]
pub(super) enum Fault {
    /// The file cannot be read.
    Io(io::Error),
    /// There is no reader for this extension.
    UnknownFormat,
    /// A line of a text file, from 1, is wrong.
    Line(usize, String),
    /// A record of a binary file, which begins at this byte, is wrong.
    Byte(usize, String),
    /// The file is not what its extension says.
    Broken(String),
    /// The file names another by this URI, which does not lie in its folder.
    Outside(String),
}

impl Fault {
    pub(super) fn broken(what: impl Into<String>) -> Self {
        Self::Broken(what.into())
    }

    pub(super) fn no_triangle() -> Self {
        Self::broken(other_format("there is no triangle in it"))
    }

    /// More than so many bytes are needed.
    pub(super) fn memory(most: usize) -> Self {
        let most = most.div_ceil(1_000_000);
        Self::broken(format!(
            "needs more than {most} MB while it is read; --memory lets it take more"
        ))
    }

    pub(super) fn at(self, path: &Path) -> ReadError {
        ReadError { path: path.to_owned(), fault: self }
    }
}

/// A fault, with the remedy for a file whose name tells the wrong format.
pub(super) fn other_format(what: impl fmt::Display) -> String {
    format!("{what}; see --input-format if its format is another")
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = shown_path(&self.path);
        match &self.fault {
            Fault::Io(_) => write!(f, "cannot read {path}"),
            Fault::UnknownFormat => {
                write!(
                    f,
                    "{path}: unknown format; known are {}: see --input-format",
                    FORMATS.join(", ")
                )
            }
            Fault::Line(line, what) => write!(f, "{path}, line {line}: {what}"),
            Fault::Byte(byte, what) => write!(f, "{path}, byte {byte}: {what}"),
            Fault::Broken(what) => write!(f, "{path}: {what}"),
            Fault::Outside(uri) => write!(
                f,
                "{path}: names the file {uri}, which is not in its own folder: see --allow-outside-files"
            ),
        }
    }
}

impl error::Error for ReadError {
    fn source(&self) -> Option<&(dyn error::Error + 'static)> {
        match &self.fault {
            Fault::Io(source) => Some(source),
            _ => None,
        }
    }
}
