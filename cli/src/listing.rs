//! Writing hits: as text, as a picture, as curves.

use crate::args::{Format, Listing};
use crate::curve::{AnyContact, Curves};
use anyhow::{Context, Result};
use pfront::{AnyPose, Contact, Mesh, Model, TrianglePair};
use pfront_cli::json::{VERSION, json};
use pfront_cli::output::{Draft, out};
use pfront_files::escape::{escaped, is_shown, shown_path};
use pfront_files::{PaintedMesh, Source, write_painted};
use serde::{Serialize, Serializer};
use serde_json::json;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::iter::once;
use std::path::Path;

/// The colours of meshes in turn, and of triangles that meet.
pub(crate) const PLAIN: [[u8; 3]; 2] = [[172, 182, 196], [206, 196, 170]];
pub(crate) const HIT: [u8; 3] = [214, 40, 40];

/// A mesh or a body, and where its triangles come from.
pub(crate) struct Origin<'f> {
    pub(crate) name: String,
    pub(crate) source: &'f Source,
    /// The triangles of the file that are here, unless all are.
    pub(crate) triangles: Option<Vec<u32>>,
}

/// A file that was read, as JSON has it.
#[derive(Serialize)]
pub(crate) struct FileRow {
    name: String,
    vertices: usize,
    triangles: usize,
}

impl FileRow {
    /// A file with its models.
    pub(crate) fn new<'m>(path: &Path, models: impl IntoIterator<Item = &'m Model>) -> Self {
        let name = path.display().to_string();
        let mut row = Self { name, vertices: 0, triangles: 0 };
        models.into_iter().for_each(|model| row.add(model));
        row
    }

    pub(crate) fn add(&mut self, model: &Model) {
        self.vertices += model.mesh().vertex_count();
        self.triangles += model.mesh().triangles().len();
    }
}

impl<'f> Origin<'f> {
    /// The face of a triangle in its file.
    pub(crate) fn face(&self, triangle: u32) -> u32 {
        self.source.face(self.in_file(triangle))
    }

    /// The number of a triangle in its file.
    fn in_file(&self, triangle: u32) -> u32 {
        self.triangles.as_ref().map_or(triangle, |triangles| triangles[triangle as usize])
    }

    /// All of a file.
    pub(crate) fn of_file(source: &'f Source) -> Self {
        Self { name: String::new(), source, triangles: None }
    }
}

/// Two triangles that meet, and which origins they are of.
pub(crate) struct Hit {
    pub(crate) origins: [usize; 2],
    pub(crate) pair: TrianglePair,
    pub(crate) contact: Option<AnyContact>,
}

/// The kind of the rows of a listing.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A pair of triangles.
    Pairs,
    /// A pair of triangles, and the name of their file.
    Files,
    /// A pair of triangles, and the names of their bodies.
    Scene,
    /// Two origins, and the number of their pairs.
    Bodies,
}

/// The hits that a query found.
pub(crate) struct Found<'f> {
    pub(crate) files: Vec<FileRow>,
    pub(crate) origins: &'f [Origin<'f>],
    pub(crate) kind: Kind,
    /// The distance that was asked for, if one was.
    pub(crate) within: Option<f32>,
    pub(crate) hits: Box<dyn Iterator<Item = Hit> + 'f>,
}

/// A hit in the order of its columns.
#[derive(Serialize)]
struct Row<'f> {
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<&'f str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<[&'f str; 2]>,
    a: u32,
    b: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    faces: Option<[u32; 2]>,
    #[serde(flatten)]
    contact: Option<ContactRow>,
}

#[derive(Serialize)]
struct ContactRow {
    kind: &'static str,
    segment: [[Coordinate; 3]; 2],
    normals: [[Coordinate; 3]; 2],
}

/// A number with as few digits as tell it from others of its precision.
#[derive(Clone, Copy, Serialize)]
#[serde(untagged)]
enum Coordinate {
    F32(f32),
    F64(f64),
}

impl ContactRow {
    fn new(contact: &AnyContact) -> Self {
        let Contact { is_flat, normals, segment } = contact.widened();
        let kind = if is_flat { "flat" } else { "crossing" };
        let coordinate = |x: f64| match contact {
            AnyContact::F32(_) => Coordinate::F32(x as f32),
            AnyContact::F64(_) => Coordinate::F64(x),
        };
        let segment = segment.map(|end| end.map(coordinate));
        Self { kind, segment, normals: normals.map(|normal| normal.map(Coordinate::F32)) }
    }
}

impl<'f> Found<'f> {
    /// Writes to where the options say. `meshes` are those of the origins, and their poses.
    pub(crate) fn write(self, listing: &Listing, meshes: &[(Mesh<'_>, AnyPose)]) -> Result<()> {
        let format = listing.format()?;
        let Some(path) = listing.file() else {
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
            writeln!(out(), "{said}; see {}", shown_path(path))?;
        }
        Ok(())
    }

    fn paint(self, to: &mut impl Write, meshes: &[(Mesh<'_>, AnyPose)]) -> io::Result<String> {
        let mut marks: Vec<_> =
            meshes.iter().map(|(mesh, _)| vec![0; mesh.triangles().len()]).collect();
        let mut hits = 0;
        for Hit { origins: [a, b], pair, .. } in self.hits {
            marks[a][pair.a as usize] = 1;
            marks[b][pair.b as usize] = 1;
            hits += 1;
        }
        let is_f64 = meshes.iter().any(|(mesh, pose)| mesh.is_f64() || pose.is_f64());
        let posed: Vec<_> = meshes.iter().map(|(mesh, pose)| posed(*mesh, pose, is_f64)).collect();
        let colours = PLAIN.map(|plain| [plain, HIT]);
        let parts = meshes.iter().zip(&posed).zip(&marks).zip(colours.iter().cycle());
        let painted: Vec<_> = parts
            .map(|((((mesh, _), positions), marks), colours)| PaintedMesh {
                positions,
                triangles: mesh.triangles(),
                marks,
                colours,
            })
            .collect();
        write_painted(to, &painted)?;
        Ok(count(hits, "pair"))
    }

    fn draw(self, to: &mut impl Write) -> io::Result<String> {
        let curves = Curves::of(self.hits.filter_map(|hit| hit.contact));
        curves.write(to)?;
        Ok(count(curves.len(), "polyline"))
    }

    fn print(self, listing: &Listing, format: Format, to: &mut impl Write) -> io::Result<()> {
        if self.kind == Kind::Bodies {
            return self.print_bodies(format, listing, to);
        }
        let columns = self.columns(format, listing);
        let Self { files, origins, kind, within, hits } = self;
        let (is_scene, has_file) = (kind == Kind::Scene, kind == Kind::Files);
        let has_bodies = is_scene || listing.source && has_bodies(origins);
        let row = |Hit { origins: two, pair, contact }: Hit| {
            let [x, y] = two.map(|origin| &origins[origin]);
            let [a, b] = [x.in_file(pair.a), y.in_file(pair.b)];
            let body = |origin: &'f Origin<'f>, triangle| match is_scene {
                true => &origin.name[..],
                false => origin.source.body(triangle).unwrap_or_default(),
            };
            Row {
                file: has_file.then_some(&x.name),
                bodies: has_bodies.then(|| [body(x, a), body(y, b)]),
                a: pair.a,
                b: pair.b,
                faces: listing.source.then(|| [x.source.face(a), y.source.face(b)]),
                contact: contact.as_ref().map(ContactRow::new),
            }
        };
        if format == Format::Json {
            begin_json(to, &files, within)?;
            write!(to, "\"{}\":", if listing.contacts { "contacts" } else { "pairs" })?;
            let mut count = 0;
            let hits = hits.inspect(|_| count += 1);
            let mut json = json(&mut *to);
            if has_bodies || has_file || listing.contacts || listing.source {
                json.collect_seq(hits.map(row))?;
            } else {
                json.collect_seq(hits.map(|hit| [hit.pair.a, hit.pair.b]))?;
            }
            writeln!(to, ",\"count\":{count}}}")?;
            return to.flush();
        }
        columns.write(to, titles(has_file, has_bodies, listing))?;
        let mut rows = 0;
        for row in hits.map(row) {
            columns.write(to, row.cells())?;
            rows += 1;
        }
        if !columns.csv {
            writeln!(to, "{}", count(rows, "pair"))?;
        }
        to.flush()
    }
}

impl Found<'_> {
    fn print_bodies(
        self,
        format: Format,
        listing: &Listing,
        to: &mut impl Write,
    ) -> io::Result<()> {
        let columns = self.columns(format, listing);
        let mut pairs = BTreeMap::<[usize; 2], u64>::new();
        for Hit { origins, .. } in self.hits {
            *pairs.entry(origins).or_default() += 1;
        }
        let name = |body: usize| &self.origins[body].name[..];
        let rows = pairs.iter().map(|(two, pairs)| (two.map(name), *pairs));
        if format == Format::Json {
            let rows = rows.map(|(bodies, pairs)| json!({ "bodies": bodies, "pairs": pairs }));
            begin_json(to, &self.files, self.within)?;
            write!(to, "\"bodies\":")?;
            json(&mut *to).collect_seq(rows)?;
            writeln!(to, ",\"count\":{}}}", pairs.len())?;
            return to.flush();
        }
        let titles = [Cell::Name("body_a"), Cell::Name("body_b"), Cell::Title("pairs", 10)];
        columns.write(to, titles.into_iter())?;
        for ([a, b], pairs) in rows {
            columns.write(to, [Cell::Name(a), Cell::Name(b), Cell::Index(pairs)].into_iter())?;
        }
        if !columns.csv {
            writeln!(to, "{} of bodies", count(pairs.len(), "pair"))?;
        }
        to.flush()
    }

    fn columns(&self, format: Format, listing: &Listing) -> Columns {
        let own = self.origins.iter().map(|origin| &origin.name);
        let bodies = self.origins.iter().flat_map(|origin| origin.source.bodies());
        let names = own.chain(bodies.filter(|_| listing.source));
        let width = names.map(|name| escaped(name).chars().count()).max();
        let width = width.unwrap_or(0).max("body_a".len());
        Columns { csv: format == Format::Csv, width }
    }
}

fn has_bodies(origins: &[Origin<'_>]) -> bool {
    origins.iter().any(|origin| !origin.source.bodies().is_empty())
}

/// Writes the beginning of a JSON object, which the caller goes on with.
fn begin_json(to: &mut impl Write, files: &[FileRow], within: Option<f32>) -> io::Result<()> {
    write!(to, "{{\"version\":{VERSION},\"files\":")?;
    json(&mut *to).collect_seq(files)?;
    write!(to, ",")?;
    if let Some(distance) = within {
        write!(to, "\"within\":")?;
        distance.serialize(&mut json(&mut *to))?;
        write!(to, ",")?;
    }
    Ok(())
}

/// The positions of a mesh as it is posed, in f64 if that is so of its query.
pub(crate) fn posed(mesh: Mesh<'_>, pose: &AnyPose, is_f64: bool) -> Vec<[f64; 3]> {
    match (pose, mesh.positions_f64()) {
        (AnyPose::F32(pose), None) if !is_f64 => {
            mesh.shadow().iter().map(|&p| pose.apply(p).map(f64::from)).collect()
        }
        (pose, Some(positions)) => positions.iter().map(|&p| pose.to_f64().apply(p)).collect(),
        (pose, None) => {
            let pose = pose.to_f64();
            mesh.shadow().iter().map(|&p| pose.apply(p.map(f64::from))).collect()
        }
    }
}

/// How rows of text look.
struct Columns {
    csv: bool,
    /// The width of the column of names.
    width: usize,
}

/// A piece of a row.
enum Cell<'c> {
    /// The title of a column so wide.
    Title(&'c str, usize),
    Name(&'c str),
    Kind(&'static str),
    Index(u64),
    Coordinate(Coordinate),
}

fn titles(
    has_file: bool,
    has_bodies: bool,
    listing: &Listing,
) -> impl Iterator<Item = Cell<'static>> {
    let columns = |two: [&'static str; 2], cell: fn(&'static str) -> Cell<'static>, shown: bool| {
        two.into_iter().map(cell).filter(move |_| shown)
    };
    let index = |title| Cell::Title(title, 10);
    let contacts = COORDINATES.iter().map(|title| Cell::Title(title, 13));
    let contacts =
        once(Cell::Kind("kind")).chain(contacts).take(if listing.contacts { 13 } else { 0 });
    once(Cell::Name("file"))
        .filter(move |_| has_file)
        .chain(columns(["body_a", "body_b"], Cell::Name, has_bodies))
        .chain(columns(["a", "b"], index, true))
        .chain(columns(["face_a", "face_b"], index, listing.source))
        .chain(contacts)
}

impl Row<'_> {
    fn cells(&self) -> impl Iterator<Item = Cell<'_>> {
        let contact = self.contact.iter().flat_map(|ContactRow { kind, segment, normals }| {
            let numbers = segment.iter().chain(normals).flatten();
            once(Cell::Kind(kind)).chain(numbers.map(|&x| Cell::Coordinate(x)))
        });
        let names = self.file.into_iter().chain(self.bodies.into_iter().flatten());
        names
            .map(Cell::Name)
            .chain(
                [self.a, self.b]
                    .into_iter()
                    .chain(self.faces.into_iter().flatten())
                    .map(|index| Cell::Index(index.into())),
            )
            .chain(contact)
    }
}

impl Columns {
    fn write<'c>(
        &self,
        to: &mut impl Write,
        row: impl Iterator<Item = Cell<'c>>,
    ) -> io::Result<()> {
        let Self { csv, width } = *self;
        for (place, cell) in row.enumerate() {
            if place > 0 {
                to.write_all(if csv { b"," } else { b" " })?;
            }
            match cell {
                Cell::Title(text, _) | Cell::Kind(text) if csv => write!(to, "{text}"),
                Cell::Name(name) if csv => write!(to, "{}", quoted(name)),
                Cell::Index(index) if csv => write!(to, "{index}"),
                Cell::Coordinate(Coordinate::F32(x)) if csv => write!(to, "{x}"),
                Cell::Coordinate(Coordinate::F64(x)) if csv => write!(to, "{x}"),
                Cell::Title(text, width) => write!(to, "{text:>width$}"),
                Cell::Kind(kind) => write!(to, "{kind:<8}"),
                Cell::Name(name) => write!(to, "{:<width$}", escaped(name)),
                Cell::Index(index) => write!(to, "{index:>10}"),
                Cell::Coordinate(Coordinate::F32(x)) => write!(to, "{x:>13.6e}"),
                Cell::Coordinate(Coordinate::F64(x)) => write!(to, "{x:>13.6e}"),
            }?;
        }
        writeln!(to)
    }
}

/// A word as CSV has it: ends of lines are quoted, and other characters that a terminal does not show are escaped.
fn quoted(word: &str) -> Cow<'_, str> {
    let is_kept = |character| is_shown(character) || matches!(character, '\n' | '\r' | '\t');
    if !word.chars().all(is_kept) {
        return Cow::Owned(quoted(&escaped(word)).into_owned());
    }
    if word.contains([',', '"', '\n', '\r']) {
        return Cow::Owned(format!("\"{}\"", word.replace('"', "\"\"")));
    }
    Cow::Borrowed(word)
}

const COORDINATES: [&str; 12] =
    ["x0", "y0", "z0", "x1", "y1", "z1", "nx_a", "ny_a", "nz_a", "nx_b", "ny_b", "nz_b"];

pub(crate) fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}
