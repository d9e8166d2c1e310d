//! Printing triangle pairs, as text or as a picture.

use crate::args::{Format, Listing};
use anyhow::{Context, Result};
use pfront::{Contact, ContactKind, Mesh, TrianglePair};
use pfront_cli::mesh::{PaintedMesh, write_painted};
use serde::Serialize;
use std::fs::File;
use std::io::{BufWriter, Write, stdout};
use std::path::Path;

/// The colours of the first and the second mesh, and of triangles that meet.
const PLAIN: [[u8; 3]; 2] = [[172, 182, 196], [206, 196, 170]];
const HIT: [u8; 3] = [214, 40, 40];

/// What a query found.
pub(crate) enum Found<'f> {
    Pairs(&'f [TrianglePair]),
    Contacts(&'f [(TrianglePair, Contact)]),
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
        let kind = match contact.kind {
            ContactKind::Crossing => "crossing",
            ContactKind::Flat => "flat",
        };
        Self { a: pair.a, b: pair.b, kind, segment: contact.segment, normals: contact.normals }
    }

    fn numbers(&self) -> impl Iterator<Item = &f32> {
        self.segment.iter().chain(&self.normals).flatten()
    }
}

impl Found<'_> {
    /// Prints to where the options say, or paints `meshes`: the two in the frame of the first, or the
    /// only one.
    pub(crate) fn print(&self, listing: &Listing, meshes: &[Mesh<'_>]) -> Result<()> {
        match &listing.out {
            None => Ok(self.write(listing.format, &mut BufWriter::new(stdout().lock()))?),
            Some(path) if is_picture(path) => self.paint(path, meshes),
            Some(path) => {
                let context = || format!("writing {}", path.display());
                let mut file = File::create(path).map(BufWriter::new).with_context(context)?;
                self.write(listing.format, &mut file).with_context(context)
            }
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
                let pairs: &[[u32; 2]] = bytemuck::cast_slice(pairs);
                serde_json::to_writer(&mut *to, &serde_json::json!({ "pairs": pairs }))?;
                writeln!(to)?;
            }
            (Self::Contacts(contacts), Format::Json) => {
                let rows: Vec<Row> = contacts.iter().map(Row::new).collect();
                serde_json::to_writer(&mut *to, &serde_json::json!({ "contacts": rows }))?;
                writeln!(to)?;
            }
        }
        to.flush()
    }

    fn pairs(&self) -> Vec<TrianglePair> {
        match self {
            Self::Pairs(pairs) => pairs.to_vec(),
            Self::Contacts(contacts) => contacts.iter().map(|(pair, _)| *pair).collect(),
        }
    }

    fn paint(&self, path: &Path, meshes: &[Mesh<'_>]) -> Result<()> {
        let mut hits: Vec<Vec<bool>> =
            meshes.iter().map(|mesh| vec![false; mesh.triangles().len()]).collect();
        for pair in self.pairs() {
            hits[0][pair.a as usize] = true;
            hits[meshes.len() - 1][pair.b as usize] = true;
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
        let written = write_painted(path, &painted);
        written.with_context(|| format!("writing {}", path.display()))?;
        writeln!(stdout(), "{}; see {}", count(self.pairs().len()), path.display())?;
        Ok(())
    }
}

const COLUMNS: [&str; 12] =
    ["x0", "y0", "z0", "x1", "y1", "z1", "nx_a", "ny_a", "nz_a", "nx_b", "ny_b", "nz_b"];

fn count(pairs: usize) -> String {
    format!("{pairs} {}", if pairs == 1 { "pair" } else { "pairs" })
}

fn is_picture(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"))
}
