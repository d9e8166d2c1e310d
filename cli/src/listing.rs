//! Printing triangle pairs, as text or as a picture.

use crate::args::{Format, Listing};
use anyhow::{Context, Result};
use pfront::{Contact, Mesh, TrianglePair};
use pfront_cli::mesh::{PaintedMesh, write_painted};
use pfront_cli::output::{Draft, out};
use serde::{Serialize, Serializer};
use std::io::{BufWriter, Write};
use std::path::Path;

/// The colours of the first and the second mesh, and of triangles that meet.
const PLAIN: [[u8; 3]; 2] = [[172, 182, 196], [206, 196, 170]];
const HIT: [u8; 3] = [214, 40, 40];

/// What a query found.
pub(crate) enum Found<'f> {
    Pairs(&'f [TrianglePair]),
    Contacts(&'f [(TrianglePair, Contact)]),
}

/// What JSON gets, without a copy of it.
#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum Json<'f> {
    Pairs(&'f [[u32; 2]]),
    #[serde(serialize_with = "rows")]
    Contacts(&'f [(TrianglePair, Contact)]),
}

fn rows<S: Serializer>(contacts: &[(TrianglePair, Contact)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(contacts.iter().map(Row::new))
}

/// A contact in the order of its columns.
#[derive(Serialize)]
struct Row {
    a: u32,
    b: u32,
    kind: &'static str,
    segment: [[f32; 3]; 2],
    normals: [[f32; 3]; 2],
}

impl Row {
    fn new((pair, contact): &(TrianglePair, Contact)) -> Self {
        let kind = if contact.is_flat { "flat" } else { "crossing" };
        Self { a: pair.a, b: pair.b, kind, segment: contact.segment, normals: contact.normals }
    }

    fn numbers(&self) -> impl Iterator<Item = &f32> {
        self.segment.iter().chain(&self.normals).flatten()
    }
}

impl Found<'_> {
    /// Prints to where the options say.
    pub(crate) fn print(&self, listing: &Listing) -> Result<()> {
        let Some(path) = &listing.out else {
            return Ok(self.write(listing.format(), &mut BufWriter::new(out()))?);
        };
        let mut file = Draft::new(path)?;
        let written = self.write(listing.format(), &mut file);
        written.with_context(|| format!("cannot write {}", path.display()))?;
        file.finish()
    }

    /// Paints the two meshes in the frame of the first, or the only one.
    pub(crate) fn paint(&self, path: &Path, meshes: &[Mesh<'_>]) -> Result<()> {
        let mut hits: Vec<Vec<bool>> =
            meshes.iter().map(|mesh| vec![false; mesh.triangles().len()]).collect();
        let mut mark = |pair: &TrianglePair| {
            hits[0][pair.a as usize] = true;
            hits[meshes.len() - 1][pair.b as usize] = true;
        };
        match self {
            Self::Pairs(pairs) => pairs.iter().for_each(mark),
            Self::Contacts(contacts) => contacts.iter().for_each(|(pair, _)| mark(pair)),
        }
        let parts = meshes.iter().zip(&hits).zip(PLAIN);
        let painted: Vec<_> = parts
            .map(|((mesh, hit), plain)| PaintedMesh {
                positions: mesh.positions(),
                triangles: mesh.triangles(),
                hit,
                colours: [plain, HIT],
            })
            .collect();
        let mut file = Draft::new(path)?;
        let written = write_painted(&mut file, &painted);
        written.with_context(|| format!("cannot write {}", path.display()))?;
        file.finish()?;
        writeln!(out(), "{}; see {}", count(self.len()), path.display())?;
        Ok(())
    }

    fn len(&self) -> usize {
        match self {
            Self::Pairs(pairs) => pairs.len(),
            Self::Contacts(contacts) => contacts.len(),
        }
    }

    fn write(&self, format: Format, to: &mut impl Write) -> std::io::Result<()> {
        match (self, format) {
            (Self::Pairs(pairs), Format::Table) => {
                writeln!(to, "{:>10} {:>10}", "a", "b")?;
                pairs.iter().try_for_each(|p| writeln!(to, "{:>10} {:>10}", p.a, p.b))?;
                writeln!(to, "{}", count(pairs.len()))?;
            }
            (Self::Contacts(contacts), Format::Table) => {
                write!(to, "{:>10} {:>10} {:<8}", "a", "b", "kind")?;
                COLUMNS.iter().try_for_each(|name| write!(to, " {name:>13}"))?;
                writeln!(to)?;
                for row in contacts.iter().map(Row::new) {
                    write!(to, "{:>10} {:>10} {:<8}", row.a, row.b, row.kind)?;
                    row.numbers().try_for_each(|x| write!(to, " {x:>13.6e}"))?;
                    writeln!(to)?;
                }
                writeln!(to, "{}", count(contacts.len()))?;
            }
            (Self::Pairs(pairs), Format::Csv) => {
                writeln!(to, "a,b")?;
                pairs.iter().try_for_each(|p| writeln!(to, "{},{}", p.a, p.b))?;
            }
            (Self::Contacts(contacts), Format::Csv) => {
                writeln!(to, "a,b,kind,{}", COLUMNS.join(","))?;
                for row in contacts.iter().map(Row::new) {
                    write!(to, "{},{},{}", row.a, row.b, row.kind)?;
                    row.numbers().try_for_each(|x| write!(to, ",{x}"))?;
                    writeln!(to)?;
                }
            }
            (Self::Pairs(pairs), Format::Json) => {
                serde_json::to_writer(&mut *to, &Json::Pairs(bytemuck::cast_slice(pairs)))?;
                writeln!(to)?;
            }
            (Self::Contacts(contacts), Format::Json) => {
                serde_json::to_writer(&mut *to, &Json::Contacts(contacts))?;
                writeln!(to)?;
            }
        }
        to.flush()
    }
}

const COLUMNS: [&str; 12] =
    ["x0", "y0", "z0", "x1", "y1", "z1", "nx_a", "ny_a", "nz_a", "nx_b", "ny_b", "nz_b"];

fn count(pairs: usize) -> String {
    format!("{pairs} {}", if pairs == 1 { "pair" } else { "pairs" })
}
