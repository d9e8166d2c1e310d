//! How hits are written, and where to.

use anyhow::{Result, bail, ensure};
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(crate) struct Listing {
    /// Print one JSON object
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print comma-separated values, with a line of names
    #[arg(long)]
    csv: bool,
    /// Also where they meet: a segment and the normals of both triangles, in the frame of the first mesh; pairs that --within
    /// finds apart are left out
    #[arg(long)]
    pub(crate) contacts: bool,
    /// Also the faces of the files, from 0, and the bodies of the files that the triangles come from
    #[arg(long)]
    pub(crate) source: bool,
    /// Exit with code 1 if something intersects, or is within the distance of --within
    #[arg(long)]
    pub(crate) fail: bool,
    /// Write into a file: .json and .csv as by these options, .ply the meshes with the triangles that meet in red,
    /// .obj the curves in which they intersect; - is standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// The form in which hits are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Aligned columns, then the number of pairs.
    Table,
    /// One object: pairs, or contacts.
    Json,
    /// Comma-separated, with a line of names.
    Csv,
    /// A picture: meshes with marked triangles.
    Picture,
    /// Polylines.
    Curves,
}

impl Format {
    /// Whether it is no text.
    pub(crate) fn is_drawn(self) -> bool {
        matches!(self, Self::Picture | Self::Curves)
    }
}

impl Listing {
    /// The file to write, if it is not standard output.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.out.as_deref().filter(|path| *path != Path::new("-"))
    }

    /// Whether contacts are asked for, or what is made of them.
    pub(crate) fn needs_contacts(&self) -> Result<bool> {
        Ok(self.contacts || self.format()? == Format::Curves)
    }

    /// The format that is asked for.
    ///
    /// # Errors
    /// If the extension tells no format, or options ask for another, or for more than a picture or curves can show.
    pub(crate) fn format(&self) -> Result<Format> {
        let asked = match self {
            Self { json: true, .. } => Some(Format::Json),
            Self { csv: true, .. } => Some(Format::Csv),
            _ => None,
        };
        let Some(path) = self.file() else { return Ok(asked.unwrap_or(Format::Table)) };
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let named = match (extension.to_str(), asked) {
            (Some("json"), _) => Format::Json,
            (Some("csv"), _) => Format::Csv,
            (Some("ply"), _) => Format::Picture,
            (Some("obj"), _) => Format::Curves,
            (_, Some(asked)) => asked,
            _ => bail!(
                "--out {}: the extension tells the format, and can be .json, .csv, .ply or .obj",
                path.display()
            ),
        };
        ensure!(
            !named.is_drawn() || asked.is_none() && !self.contacts && !self.source,
            "--out {} is drawn: leave out --json, --csv, --contacts and --source",
            path.display()
        );
        ensure!(
            asked.is_none_or(|asked| asked == named),
            "--out {} has the extension of another format: leave out --json and --csv",
            path.display()
        );
        Ok(named)
    }
}
