//! 3MF, through `zip` and `quick-xml`: the items of the build, each a body with what its components place, in the units of
//! the file. Extensions beside the production extension are passed over if they leave geometry alone.

use crate::budget::Budget;
use crate::error::Fault;
use crate::import::Import;
use crate::mesh::TriangleMesh;
use crate::source::Source;
use crate::text::coordinate;
use glam::{DMat4, DVec3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::io::{Cursor, Read};
use std::str::FromStr;
use zip::ZipArchive;

/// The part that a package begins with, unless its relations name another.
const START: &str = "3D/3dmodel.model";
const RELATIONS: &str = "_rels/.rels";
const IS_START: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// Parts of the namespaces of extensions that may be required.
const HARMLESS: [&str; 4] = ["/production/", "/material/", "/slice/", "/trianglesets/"];

/// Deeper components are refused.
const DEEPEST: usize = 64;

/// Bytes of budget for each object that is placed: a bound for components that are made to be many.
const PLACED: usize = 256;

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    import.is_split = true;
    let archive = ZipArchive::new(Cursor::new(bytes));
    let archive = archive.map_err(|error| Fault::broken(format!("no 3MF package: {error}")))?;
    let mut package = Package { archive, parts: HashMap::new() };
    let start = match package.archive.index_for_name(RELATIONS) {
        Some(_) => start(&package.unpacked(RELATIONS, &mut import.budget)?)?,
        None => None,
    };
    let start = start.unwrap_or_else(|| START.to_owned());
    package.load(&start, import)?;
    let items = package.parts.get(&start).map(|part| part.items.clone()).unwrap_or_default();
    for item in items {
        let path = item.placed.path.unwrap_or_else(|| start.clone());
        let name = package.load(&path, import)?.objects.get(&item.placed.object);
        let name = name.and_then(|object| object.name.clone()).or(item.name);
        let name = name.unwrap_or_else(|| format!("object {}", item.placed.object));
        import.begin_body(name)?;
        package.place(&path, item.placed.object, &item.placed.transform, 0, import)?;
    }
    Ok(())
}

struct Package<'b> {
    archive: ZipArchive<Cursor<&'b [u8]>>,
    parts: HashMap<String, Part>,
}

/// A part with a model.
#[derive(Default)]
struct Part {
    objects: HashMap<u32, Object>,
    items: Vec<Item>,
}

#[derive(Default)]
struct Object {
    name: Option<String>,
    mesh: TriangleMesh,
    components: Vec<Placed>,
}

#[derive(Clone)]
struct Item {
    placed: Placed,
    name: Option<String>,
}

/// An object of a part, or of the same part, and where it stands.
#[derive(Clone)]
struct Placed {
    path: Option<String>,
    object: u32,
    transform: DMat4,
}

impl Package<'_> {
    /// The bytes of a part of the package.
    fn unpacked(&mut self, path: &str, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
        let fault = |what: String| Fault::broken(format!("{path}: {what}"));
        let part = self.archive.by_name(path).map_err(|error| fault(error.to_string()))?;
        let (packed, stated) = (part.compressed_size() as usize, part.size() as usize);
        // A part of numbers is some four times as long as it is packed, and no more is believed.
        budget.add_file(stated.min(packed.saturating_mul(4)));
        budget.check(stated)?;
        let mut bytes = Vec::new();
        let most = budget.left().saturating_add(1) as u64;
        part.take(most).read_to_end(&mut bytes).map_err(|error| fault(error.to_string()))?;
        budget.take(bytes.len())?;
        Ok(bytes)
    }

    /// Reads a part, unless it is read already.
    fn load(&mut self, path: &str, import: &mut Import) -> Result<&Part, Fault> {
        if !self.parts.contains_key(path) {
            let bytes = self.unpacked(path, &mut import.budget)?;
            let part = model(path, &bytes, import)?;
            self.parts.insert(path.to_owned(), part);
        }
        self.parts.get(path).ok_or_else(|| Fault::broken(format!("there is no part {path}")))
    }

    /// Adds the triangles of an object and of its components.
    fn place(
        &mut self,
        path: &str,
        object: u32,
        world: &DMat4,
        depth: usize,
        import: &mut Import,
    ) -> Result<(), Fault> {
        if depth > DEEPEST {
            return Err(Fault::broken(format!("object {object} has components of itself")));
        }
        import.budget.take(PLACED)?;
        let found = self.load(path, import)?.objects.get(&object);
        let missing = || Fault::broken(format!("{path}: there is no object {object}"));
        let found = found.ok_or_else(missing)?;
        let Import { mesh, budget, source, .. } = &mut *import;
        let (vertices, triangles) = (found.mesh.positions.len(), found.mesh.triangles.len());
        budget.check_growth(mesh, vertices, triangles)?;
        let first = mesh.positions.len() as u32;
        let moves = *world != DMat4::IDENTITY;
        mesh.positions.extend(found.mesh.positions.iter().map(|&p| {
            let placed = if moves { world.transform_point3(DVec3::from(p)).to_array() } else { p };
            if source.in_f32 { placed.map(|x| f64::from(x as f32)) } else { placed }
        }));
        mesh.triangles.extend(found.mesh.triangles.iter().map(|t| t.map(|v| first + v)));
        for component in found.components.clone() {
            let Placed { path: other, object, transform } = component;
            let other = other.as_deref().unwrap_or(path);
            self.place(other, object, &(*world * transform), depth + 1, import)?;
        }
        Ok(())
    }
}

/// The part that relations say a package begins with.
fn start(bytes: &[u8]) -> Result<Option<String>, Fault> {
    let mut xml = Xml::new(RELATIONS, bytes);
    while let Some(event) = xml.next()? {
        if let Event::Start(element) | Event::Empty(element) = event
            && element.local_name().as_ref() == "Relationship"
            && xml.text(&element, "Type")?.as_deref() == Some(IS_START)
        {
            return Ok(xml.text(&element, "Target")?.map(|path| within_package(&path)));
        }
    }
    Ok(None)
}

/// The name of a part in the archive.
fn within_package(path: &str) -> String {
    path.trim_start_matches('/').to_owned()
}

/// Reads a part with a model.
fn model(path: &str, bytes: &[u8], import: &mut Import) -> Result<Part, Fault> {
    let mut xml = Xml::new(path, bytes);
    let mut part = Part::default();
    let mut object = None;
    while let Some(event) = xml.next()? {
        let (element, is_empty) = match event {
            Event::Start(element) => (element, false),
            Event::Empty(element) => (element, true),
            Event::End(end) if end.name().as_ref() == "object" => {
                close(&mut part, &mut object);
                continue;
            }
            _ => continue,
        };
        match (element.name().as_ref(), &mut object) {
            ("model", _) => check_required(&xml, &element)?,
            ("object", _) => {
                let name = xml.text(&element, "name")?.filter(|name| !name.is_empty());
                let name = match name {
                    None => xml.text(&element, "partnumber")?.filter(|name| !name.is_empty()),
                    name => name,
                };
                let id = xml.number(&element, "id")?;
                object = Some((id, Object { name, ..Object::default() }));
                if is_empty {
                    close(&mut part, &mut object);
                }
            }
            ("vertex", Some((_, Object { mesh, .. }))) => {
                mesh.positions.push(xml.position(&element, &mut import.source)?);
                import.budget.check_growth(&import.mesh, mesh.positions.len(), 0)?;
            }
            ("triangle", Some((_, Object { mesh, .. }))) => {
                let mut corners = [0; 3];
                for (corner, name) in corners.iter_mut().zip(["v1", "v2", "v3"]) {
                    *corner = xml.number(&element, name)?;
                    let all = mesh.positions.len();
                    if *corner as usize >= all {
                        return Err(xml.fault(format!("there is no vertex {corner} among {all}")));
                    }
                }
                mesh.triangles.push(corners);
                let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
                import.budget.check_growth(&import.mesh, vertices, triangles)?;
            }
            ("component", Some((_, Object { components, .. }))) => {
                import.budget.take(PLACED)?;
                components.push(placed(&xml, &element)?);
            }
            ("item", None) => {
                import.budget.take(PLACED)?;
                let name = xml.text(&element, "partnumber")?.filter(|name| !name.is_empty());
                part.items.push(Item { placed: placed(&xml, &element)?, name });
            }
            (name, Some(_)) if name.ends_with(":beamlattice") => {
                import.notes.push(format!("{path}: a beam lattice is passed over"));
            }
            _ => {}
        }
    }
    for Object { mesh, .. } in part.objects.values() {
        import.budget.take(size_of_val(&mesh.positions[..]) + size_of_val(&mesh.triangles[..]))?;
    }
    Ok(part)
}

/// Ends an object.
fn close(part: &mut Part, object: &mut Option<(u32, Object)>) {
    if let Some((id, object)) = object.take() {
        part.objects.insert(id, object);
    }
}

/// Checks that extensions that are required leave geometry alone.
fn check_required(xml: &Xml<'_>, element: &BytesStart<'_>) -> Result<(), Fault> {
    let required = xml.text(element, "requiredextensions")?.unwrap_or_default();
    for prefix in required.split_whitespace() {
        let space = xml.text(element, &format!("xmlns:{prefix}"))?.unwrap_or_default();
        if !HARMLESS.iter().any(|part| space.contains(part)) {
            let what = format!("requires the extension {prefix} ({space}), which is not read");
            return Err(xml.fault(what));
        }
    }
    Ok(())
}

/// An object and where it stands.
fn placed(xml: &Xml<'_>, element: &BytesStart<'_>) -> Result<Placed, Fault> {
    let transform = match xml.text(element, "transform")? {
        None => DMat4::IDENTITY,
        Some(text) => {
            let numbers = text.split_whitespace().map(f64::from_str);
            let numbers: Result<Vec<_>, _> = numbers.collect();
            let numbers = numbers.ok().and_then(|numbers| <[f64; 12]>::try_from(numbers).ok());
            let m = numbers.ok_or_else(|| xml.fault("a transform is not of twelve numbers"))?;
            let column = |k: usize, w| DVec3::new(m[k], m[k + 1], m[k + 2]).extend(w);
            DMat4::from_cols(column(0, 0.0), column(3, 0.0), column(6, 0.0), column(9, 1.0))
        }
    };
    let path = xml.text(element, "p:path")?.map(|path| within_package(&path));
    Ok(Placed { path, object: xml.number(element, "objectid")?, transform })
}

/// The XML of a part.
struct Xml<'x> {
    path: &'x str,
    bytes: &'x [u8],
    reader: Reader<&'x [u8]>,
}

impl<'x> Xml<'x> {
    fn new(path: &'x str, bytes: &'x [u8]) -> Self {
        Self { path, bytes, reader: Reader::from_reader(bytes) }
    }

    fn next(&mut self) -> Result<Option<Event<'x>>, Fault> {
        match self.reader.read_event() {
            Ok(Event::Eof) => Ok(None),
            Ok(event) => Ok(Some(event)),
            Err(error) => Err(self.fault(error.to_string())),
        }
    }

    /// The line of the file that is being read.
    fn line(&self) -> usize {
        let read = self.bytes.get(..self.reader.buffer_position() as usize);
        1 + read.unwrap_or_default().iter().filter(|&&byte| byte == b'\n').count()
    }

    fn fault(&self, what: impl std::fmt::Display) -> Fault {
        Fault::line(self.line(), format!("{what} (in {})", self.path))
    }

    /// An attribute, with its entities resolved.
    fn text(&self, element: &BytesStart<'_>, name: &str) -> Result<Option<String>, Fault> {
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if attribute.key.as_ref() == name {
                let text = quick_xml::escape::unescape(&attribute.value);
                let text = text.map_err(|error| self.fault(error))?;
                return Ok(Some(text.into_owned()));
            }
        }
        Ok(None)
    }

    /// An attribute that has to be there.
    fn number<T: FromStr>(&self, element: &BytesStart<'_>, name: &str) -> Result<T, Fault> {
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            if attribute.key.as_ref() == name {
                let number = attribute.value.trim().parse().ok();
                return number.ok_or_else(|| self.fault(format!("{name} is no number")));
            }
        }
        Err(self.fault(format!("{name} is missing")))
    }

    fn position(&self, element: &BytesStart<'_>, source: &mut Source) -> Result<[f64; 3], Fault> {
        let mut position = [None; 3];
        for attribute in element.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.fault(error))?;
            let axis = ["x", "y", "z"].iter().position(|axis| attribute.key.as_ref() == *axis);
            if let Some(axis) = axis {
                let number = coordinate(attribute.value.trim().as_bytes(), source);
                position[axis] =
                    Some(number.ok_or_else(|| self.fault("a coordinate is no number"))?);
            }
        }
        let [Some(x), Some(y), Some(z)] = position else {
            return Err(self.fault("a vertex without x, y or z"));
        };
        Ok([x, y, z])
    }
}
