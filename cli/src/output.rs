//! Where results go: standard output, or a file that appears once it is whole.

use anyhow::{Context, Result};
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, StdoutLock, Write, stdout};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::{Builder, NamedTempFile};

/// Standard output; when its reader has read enough, the rest is dropped and the command still ends as it should.
pub fn out() -> impl Write {
    Out { to: Some(stdout().lock()) }
}

struct Out {
    to: Option<StdoutLock<'static>>,
}

impl Out {
    fn attempt<T>(
        &mut self,
        on: impl FnOnce(&mut StdoutLock<'static>) -> io::Result<T>,
        dropped: T,
    ) -> io::Result<T> {
        match self.to.as_mut().map(on) {
            Some(Err(error)) if error.kind() != ErrorKind::BrokenPipe => {
                let told = format!("cannot write standard output: {error}");
                Err(io::Error::new(error.kind(), told))
            }
            Some(Ok(done)) => Ok(done),
            _ => {
                self.to = None;
                Ok(dropped)
            }
        }
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.attempt(|to| to.write(bytes), bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt(Write::flush, ())
    }
}

/// Files that are being written, or were.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The exit code of a command that was interrupted, as shells have it.
const INTERRUPTED: i32 = 130;

/// Has an interrupt, as by Ctrl-C, remove what is half written before it ends the process, and say so. A file that grows
/// beyond what the system allows ends no process: writing fails, as on a full disk.
///
/// # Errors
/// If the system takes no handler.
pub fn remove_half_written() -> Result<()> {
    fail_beyond_size_limit();
    ctrlc::set_handler(|| {
        let files = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        for file in files.iter() {
            // A complete file has another name by now.
            let _ = std::fs::remove_file(file);
        }
        eprintln!("interrupted; no file written");
        std::process::exit(INTERRUPTED);
    })?;
    Ok(())
}

#[cfg(unix)]
fn fail_beyond_size_limit() {
    #[expect(unsafe_code, reason = "the standard library ignores SIGPIPE, and not SIGXFSZ")]
    // SAFETY: no handler is installed, and nobody else in this process has asked for this signal.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

#[cfg(not(unix))]
fn fail_beyond_size_limit() {}

/// A file being written. Until [`Draft::finish`] it has another name, so that whatever goes wrong, no half
/// of it stands where a whole one is expected, or stood, or is still being read.
#[derive(Debug)]
pub struct Draft {
    path: PathBuf,
    to: BufWriter<Target>,
}

#[derive(Debug)]
enum Target {
    Temporary(NamedTempFile),
    /// A pipe or a device.
    Special(File),
}

impl Draft {
    /// Begins the file that `path` will name.
    ///
    /// # Errors
    /// If nothing can be written there; so for [`Draft::finish`].
    pub fn new(path: &Path) -> Result<Self> {
        // A link stays one.
        let path = &linked(path).with_context(|| format!("cannot write {}", path.display()))?;
        let special = path.metadata().is_ok_and(|found| !found.is_file());
        let target = if special {
            File::options().write(true).open(path).map(Target::Special)
        } else {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            temporary(folder.unwrap_or(Path::new(".")))
        };
        let target = target.with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { path: path.to_owned(), to: BufWriter::new(target) })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If the rest cannot be written, or the file cannot be renamed.
    pub fn finish(self) -> Result<()> {
        let path = self.path;
        let target = self.to.into_inner().map_err(io::IntoInnerError::into_error);
        let named = target.and_then(|target| match target {
            Target::Temporary(file) => Ok(file.persist(&path).map(drop)?),
            Target::Special(_) => Ok(()),
        });
        named.with_context(|| format!("cannot write {}", path.display()))
    }
}

/// The file that a link leads to, which need not be there; or the path itself.
fn linked(path: &Path) -> io::Result<PathBuf> {
    // As many links as Linux follows.
    let mut path = path.to_owned();
    for _ in 0..40 {
        if let Ok(whole) = path.canonicalize() {
            return Ok(whole);
        }
        let Ok(target) = path.read_link() else { return Ok(path) };
        path = path.parent().unwrap_or(Path::new("")).join(target);
    }
    Err(io::Error::other("a link leads back to itself"))
}

/// The lock is held until the name is known, so that no interrupt comes between.
fn temporary(folder: &Path) -> io::Result<Target> {
    let mut files = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    // With the permissions of any new file, and errors without the name that nobody asked for.
    let file = Builder::new().make_in(folder, |path| File::create_new(path))?;
    files.push(file.path().to_owned());
    Ok(Target::Temporary(file))
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.to.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Temporary(file) => file.as_file_mut().write(bytes),
            Self::Special(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Temporary(file) => file.as_file_mut().flush(),
            Self::Special(file) => file.flush(),
        }
    }
}
