//! The files that a document may name: those in its own folder.

use crate::error::{Fault, Remedy};
use crate::escape::{escaped, shown_path};
use std::path::{Component, Path, PathBuf};

/// The most characters of a URI that an error shows.
const MOST_SHOWN: usize = 200;

/// The folder of a document, and whether its files may lie elsewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Folder<'p> {
    /// `None` if the document has none, as standard input.
    pub(crate) path: Option<&'p Path>,
    /// Whether files outside of it are read too.
    pub(crate) allows_outside: bool,
}

impl Folder<'_> {
    /// The file that a URI names, all links resolved.
    ///
    /// # Errors
    /// If it is none, or does not lie in the folder and must.
    pub(crate) fn file(&self, uri: &str) -> Result<PathBuf, Fault> {
        let quoted = || format!("'{}'", escaped(&uri.chars().take(MOST_SHOWN).collect::<String>()));
        // The name of a drive is no scheme.
        let is_scheme = |scheme: &str| scheme.len() > 1 && !scheme.contains('/');
        if uri.split_once(':').is_some_and(|(scheme, _)| is_scheme(scheme)) {
            return Err(Fault::broken(format!(
                "unsupported URI {}: a file is named by its path from the document",
                quoted()
            )));
        }
        let outside = || {
            let what = format!("names the file {}, which is not in its own folder", quoted());
            Fault::broken(what).or(Remedy::OutsideFiles)
        };
        let name = unescaped(uri).unwrap_or_else(|| uri.into());
        let allows = |path: &Path| self.allows_outside || self.path.is_some() && is_below(path);
        if !allows(Path::new(&name)) {
            return Err(outside());
        }
        let folder = self.path.filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        let named = folder.join(&name);
        let missing = || Fault::broken(format!("there is no file {}", shown_path(&named)));
        let file = named.canonicalize().map_err(|_| missing())?;
        let folder = folder.canonicalize().map_err(|_| missing())?;
        if !self.allows_outside && !file.starts_with(folder) {
            return Err(outside());
        }
        // A device may never end, and a pipe never begin.
        if file.is_file() { Ok(file) } else { Err(missing()) }
    }
}

/// Whether a path leads no higher than where it begins, but for links.
fn is_below(path: &Path) -> bool {
    let mut depth = 0_usize;
    path.components().all(|component| match component {
        Component::Normal(_) => {
            depth += 1;
            true
        }
        Component::CurDir => true,
        Component::ParentDir => depth.checked_sub(1).inspect(|less| depth = *less).is_some(),
        Component::RootDir | Component::Prefix(_) => false,
    })
}

/// With the bytes that `%20` and the like stand for; nothing if they are no text.
fn unescaped(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes: Vec<u8> = parts.next()?.into();
    for part in parts {
        let (escaped, plain) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(escaped, 16).ok()?);
        bytes.extend(plain.bytes());
    }
    String::from_utf8(bytes).ok()
}
