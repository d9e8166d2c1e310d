//! Writing hits: as text, as a picture, as curves.

use crate::args::{Format, Listing};
use crate::curve::Curves;
use anyhow::{Context, Result};
use pfront::{Contact, Mesh, TrianglePair};
use pfront_cli::mesh::{PaintedMesh, Source, write_painted};
use pfront_cli::output::{Draft, out};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

/// The colours of meshes in turn, and of triangles that meet.
const PLAIN: [[u8; 3]; 2] = [[172, 182, 196], [206, 196, 170]];
const HIT: [u8; 3] = [214, 40, 40];

/// A mesh or a body, and where its triangles come from.
pub(crate) struct Origin<'f> {
    pub(crate) name: String,
    pub(crate) source: &'f Source,
    /// The triangle of the file that is the first here.
    pub(crate) first: u32,
}

impl<'f> Origin<'f> {
    /// All of a file.
    pub(crate) fn of_file(source: &'f Source) -> Self {
        Self { name: String::new(), source, first: 0 }
    }
}

/// Two triangles that meet, and which origins they are of.
pub(crate) struct Hit {
    pub(crate) origins: [usize; 2],
    pub(crate) pair: TrianglePair,
    pub(crate) contact: Option<Contact>,
}

/// What a query found.
pub(crate) struct Found<'f> {
    pub(crate) origins: &'f [Origin<'f>],
    /// Whether hits tell the names of their origins.
    pub(crate) is_scene: bool,
    pub(crate) hits: Box<dyn Iterator<Item = Hit> + 'f>,
}

/// A hit in the order of its columns.
#[derive(Serialize)]
struct Row<'f> {
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<[&'f str; 2]>,
    a: u32,
    b: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    faces: Option<[u32; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nodes: Option<[Option<&'f str>; 2]>,
    #[serde(flatten)]
    contact: Option<ContactRow>,
}

#[derive(Serialize)]
struct ContactRow {
    kind: &'static str,
    segment: [[f32; 3]; 2],
    normals: [[f32; 3]; 2],
}

impl ContactRow {
    fn new(contact: &Contact) -> Self {
        let kind = if contact.is_flat { "flat" } else { "crossing" };
        Self { kind, segment: contact.segment, normals: contact.normals }
    }
}

impl<'f> Found<'f> {
    /// Writes to where the options say. `meshes` are those of the origins, as they are posed.
    pub(crate) fn write(self, listing: &Listing, meshes: &[Mesh<'_>]) -> Result<()> {
        let format = listing.format()?;
        let Some(path) = &listing.out else {
            self.print(listing, format, &mut BufWriter::new(out()))?;
            return Ok(());
        };
        let mut file = Draft::new(path)?;
        let written = match format {
            Format::Picture => self.paint(&mut file, meshes).map(Some),
            Format::Curves => self.draw(&mut file).map(Some),
            _ => self.print(listing, format, &mut file).map(|()| None),
        };
        let said = written.with_context(|| format!("cannot write {}", path.display()))?;
        file.finish()?;
        if let Some(said) = said {
            writeln!(out(), "{said}; see {}", path.display())?;
        }
        Ok(())
    }

    fn paint(self, to: &mut impl Write, meshes: &[Mesh<'_>]) -> io::Result<String> {
        let mut marks: Vec<_> =
            meshes.iter().map(|mesh| vec![false; mesh.triangles().len()]).collect();
        let mut hits = 0;
        for Hit { origins: [a, b], pair, .. } in self.hits {
            marks[a][pair.a as usize] = true;
            marks[b][pair.b as usize] = true;
            hits += 1;
        }
        let parts = meshes.iter().zip(&marks).zip(PLAIN.into_iter().cycle());
        let painted: Vec<_> = parts
            .map(|((mesh, hit), plain)| PaintedMesh {
                positions: mesh.positions(),
                triangles: mesh.triangles(),
                hit,
                colours: [plain, HIT],
            })
            .collect();
        write_painted(to, &painted)?;
        Ok(count(hits, "pair"))
    }

    fn draw(self, to: &mut impl Write) -> io::Result<String> {
        let curves = Curves::of(self.hits.filter_map(|hit| Some(hit.contact?.segment)));
        curves.write(to)?;
        Ok(count(curves.len(), "polyline"))
    }

    fn print(self, listing: &Listing, format: Format, to: &mut impl Write) -> io::Result<()> {
        let Self { origins, is_scene, hits } = self;
        let has_nodes =
            listing.source && origins.iter().any(|origin| origin.source.nodes().next().is_some());
        let row = |Hit { origins: two, pair, contact }: Hit| {
            let [x, y] = two.map(|origin| &origins[origin]);
            let [a, b] = [x.first + pair.a, y.first + pair.b];
            Row {
                bodies: is_scene.then(|| [&x.name[..], &y.name]),
                a: pair.a,
                b: pair.b,
                faces: listing.source.then(|| [x.source.face(a), y.source.face(b)]),
                nodes: has_nodes.then(|| [x.source.node(a), y.source.node(b)]),
                contact: contact.as_ref().map(ContactRow::new),
            }
        };
        if format == Format::Json {
            write!(to, "{{\"{}\":", if listing.contacts { "contacts" } else { "pairs" })?;
            let mut json = serde_json::Serializer::new(&mut *to);
            if is_scene || listing.contacts || listing.source {
                json.collect_seq(hits.map(row))?;
            } else {
                json.collect_seq(hits.map(|hit| [hit.pair.a, hit.pair.b]))?;
            }
            writeln!(to, "}}")?;
            return to.flush();
        }
        let width = origins.iter().map(|origin| origin.name.chars().count()).max();
        let width = width.unwrap_or(0).max("body_a".len());
        let columns = Columns { csv: format == Format::Csv, width };
        columns.names(to, is_scene, listing, has_nodes)?;
        let mut rows = 0;
        for row in hits.map(row) {
            columns.row(to, &row)?;
            rows += 1;
        }
        if !columns.csv {
            writeln!(to, "{}", count(rows, "pair"))?;
        }
        to.flush()
    }
}

/// How rows of text look.
struct Columns {
    csv: bool,
    /// That of names.
    width: usize,
}

impl Columns {
    fn names(
        &self,
        to: &mut impl Write,
        is_scene: bool,
        listing: &Listing,
        has_nodes: bool,
    ) -> io::Result<()> {
        if is_scene {
            self.words(to, ["body_a", "body_b"])?;
            self.gap(to)?;
        }
        self.numbers(to, ["a", "b"])?;
        if listing.source {
            self.gap(to)?;
            self.numbers(to, ["face_a", "face_b"])?;
        }
        if has_nodes {
            self.gap(to)?;
            self.words(to, ["node_a", "node_b"])?;
        }
        if listing.contacts {
            write!(to, "{}", if self.csv { ",kind" } else { " kind    " })?;
            COORDINATES.iter().try_for_each(|name| match self.csv {
                true => write!(to, ",{name}"),
                false => write!(to, " {name:>13}"),
            })?;
        }
        writeln!(to)
    }

    fn row(&self, to: &mut impl Write, row: &Row<'_>) -> io::Result<()> {
        if let Some(names) = row.bodies {
            self.words(to, names)?;
            self.gap(to)?;
        }
        self.numbers(to, [row.a, row.b])?;
        if let Some(faces) = row.faces {
            self.gap(to)?;
            self.numbers(to, faces)?;
        }
        if let Some(nodes) = row.nodes {
            self.gap(to)?;
            self.words(to, nodes.map(Option::unwrap_or_default))?;
        }
        if let Some(ContactRow { kind, segment, normals }) = &row.contact {
            let mut numbers = segment.iter().chain(normals).flatten();
            if self.csv {
                write!(to, ",{kind}")?;
                numbers.try_for_each(|x| write!(to, ",{x}"))?;
            } else {
                write!(to, " {kind:<8}")?;
                numbers.try_for_each(|x| write!(to, " {x:>13.6e}"))?;
            }
        }
        writeln!(to)
    }

    fn numbers<T: std::fmt::Display>(&self, to: &mut impl Write, [a, b]: [T; 2]) -> io::Result<()> {
        if self.csv { write!(to, "{a},{b}") } else { write!(to, "{a:>10} {b:>10}") }
    }

    fn words(&self, to: &mut impl Write, two: [&str; 2]) -> io::Result<()> {
        let ([a, b], width) = (two.map(quoted), self.width);
        if self.csv {
            return write!(to, "{a},{b}");
        }
        let [a, b] = two;
        write!(to, "{a:<width$} {b:<width$}")
    }

    fn gap(&self, to: &mut impl Write) -> io::Result<()> {
        write!(to, "{}", if self.csv { ',' } else { ' ' })
    }
}

/// A word as CSV has it.
fn quoted(word: &str) -> Cow<'_, str> {
    if word.contains([',', '"', '\n', '\r']) {
        return Cow::Owned(format!("\"{}\"", word.replace('"', "\"\"")));
    }
    Cow::Borrowed(word)
}

const COORDINATES: [&str; 12] =
    ["x0", "y0", "z0", "x1", "y1", "z1", "nx_a", "ny_a", "nz_a", "nx_b", "ny_b", "nz_b"];

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}
