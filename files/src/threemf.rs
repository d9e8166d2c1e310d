//! 3MF, through `zip` and `quick-xml`: the items of the build, each a body with what its components place. Coordinates
//! stay as written, whatever the unit; one other than the millimeter is noted, and two in one package are refused. Extensions beside the production extension are passed over if they leave geometry alone.

mod xml;

use crate::budget::Budget;
use crate::error::Fault;
use crate::import::Import;
use crate::mesh::TriangleMesh;
use crate::text::{from_utf16, quote, utf16};
use glam::{DMat4, DVec3};
use quick_xml::events::{BytesStart, Event};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::io::{Cursor, Read};
use std::rc::Rc;
use std::str::FromStr;
use xml::Xml;
use zip::ZipArchive;

/// The part that a package begins with, unless its relations name another.
const START: &str = "3D/3dmodel.model";
const RELATIONS: &str = "_rels/.rels";
const IS_START: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// Parts of the namespaces of extensions that may be required.
const HARMLESS: [&str; 4] = ["/production/", "/material/", "/slice/", "/trianglesets/"];

/// The unit of a part that states none.
const MILLIMETER: &str = "millimeter";

/// Bytes of budget for each object that is read or placed: a bound for components that are made to be many.
const PLACED: usize = 256;

pub(crate) fn parse(bytes: &[u8], import: &mut Import) -> Result<(), Fault> {
    import.is_split = true;
    let broken = |error| Fault::broken(format!("no 3MF package: {error}"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    if archive.has_overlapping_entries().map_err(broken)? {
        return Err(Fault::broken("no 3MF package: its entries overlap"));
    }
    let mut package = Package { archive, packed: bytes.len(), parts: HashMap::new(), unit: None };
    let start = match package.archive.index_for_name(RELATIONS) {
        Some(_) => start(&package.unpacked(RELATIONS, &mut import.budget)?)?,
        None => None,
    };
    let start = package.load(&start.unwrap_or_else(|| START.to_owned()), import)?;
    let (mut empty, mut first_empty) = (0, String::new());
    for item in &start.items {
        let part = package.part(&item.placed, &start, import)?;
        let name = part.objects.get(&item.placed.object);
        let name = name.and_then(|object| object.name.as_ref()).or(item.name.as_ref()).cloned();
        let name = name.unwrap_or_else(|| format!("object {}", item.placed.object));
        let before = import.mesh.triangles.len();
        import.begin_body(name.clone())?;
        package.place(part, &item.placed, import)?;
        if import.mesh.triangles.len() == before {
            empty += 1;
            if empty == 1 {
                first_empty = name;
            }
        }
    }
    if empty > 0 {
        let what = format!("items without triangles: {empty}, the first of them {first_empty}");
        import.notes.push(what);
    }
    Ok(())
}

struct Package<'b> {
    archive: ZipArchive<Cursor<&'b [u8]>>,
    /// Packed bytes that may still add to the budget: as many as the archive has.
    packed: usize,
    parts: HashMap<String, Rc<Part>>,
    /// The unit of the first part.
    unit: Option<String>,
}

/// A part with a model.
#[derive(Default)]
struct Part {
    path: String,
    /// The parts that were read before it.
    number: usize,
    objects: HashMap<u32, Object>,
    items: Vec<Item>,
    unit: Option<String>,
}

#[derive(Default)]
struct Object {
    name: Option<String>,
    mesh: TriangleMesh,
    components: Vec<Placed>,
}

struct Item {
    placed: Placed,
    name: Option<String>,
}

/// An object of a part, or of the same part, and where it stands.
struct Placed {
    path: Option<String>,
    object: u32,
    transform: DMat4,
}

/// An object that is being placed, and which of its components comes next.
struct Level {
    part: Rc<Part>,
    object: u32,
    world: DMat4,
    next: usize,
}

impl Part {
    fn object(&self, object: u32) -> Result<&Object, Fault> {
        let missing = || Fault::broken(format!("{}: there is no object {object}", self.path));
        self.objects.get(&object).ok_or_else(missing)
    }
}

impl Package<'_> {
    /// The bytes of a part of the package.
    fn unpacked(&mut self, path: &str, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
        let fault = |what: String| Fault::broken(format!("{path}: {what}"));
        // Names of parts are the same in capitals.
        let is_named = |name: &Cow<'_, str>| name.eq_ignore_ascii_case(path);
        let name = self.archive.file_names().flatten().find(is_named).map(String::from);
        let part = self
            .archive
            .by_name(name.as_deref().unwrap_or(path))
            .map_err(|error| fault(error.to_string()))?;
        let (packed, stated) = (part.compressed_size() as usize, part.size() as usize);
        let packed = packed.min(self.packed);
        self.packed -= packed;
        // A part of numbers is some four times as long as it is packed, and no more is believed.
        budget.add_file(stated.min(packed.saturating_mul(4)));
        budget.check(stated)?;
        let mut bytes = Vec::new();
        let most = budget.left().saturating_add(1) as u64;
        part.take(most).read_to_end(&mut bytes).map_err(|error| fault(error.to_string()))?;
        budget.take(bytes.len())?;
        match utf16(&bytes) {
            Some(is_big) => Ok(from_utf16(bytes, is_big)?.into_bytes()),
            None => Ok(bytes),
        }
    }

    /// Reads a part, unless it is read already.
    fn load(&mut self, path: &str, import: &mut Import) -> Result<Rc<Part>, Fault> {
        if let Some(part) = self.parts.get(path) {
            return Ok(part.clone());
        }
        let bytes = self.unpacked(path, &mut import.budget)?;
        let mut part = model(path, &bytes, import)?;
        part.number = self.parts.len();
        let unit = part.unit.as_deref().unwrap_or(MILLIMETER);
        let quoted = quote(unit.as_bytes());
        match &self.unit {
            None if unit == MILLIMETER => {}
            None => import.notes.push(format!("the unit is {quoted}: coordinates stay as written")),
            Some(first) if first == unit => {}
            Some(first) => {
                let first = quote(first.as_bytes());
                return Err(Fault::broken(format!("{path}: the unit is {quoted}, not {first}")));
            }
        }
        self.unit.get_or_insert_with(|| unit.to_owned());
        let part = Rc::new(part);
        self.parts.insert(path.to_owned(), part.clone());
        Ok(part)
    }

    /// The part with an object that a part places.
    fn part(
        &mut self,
        placed: &Placed,
        own: &Rc<Part>,
        import: &mut Import,
    ) -> Result<Rc<Part>, Fault> {
        let Some(path) = &placed.path else { return Ok(own.clone()) };
        // The time to look for a path is bounded along with the memory.
        import.budget.take(path.len())?;
        self.load(path, import)
    }

    /// Adds the triangles of an object of `part` and of its components, however deep they are.
    fn place(&mut self, part: Rc<Part>, item: &Placed, import: &mut Import) -> Result<(), Fault> {
        let mut levels: Vec<Level> = Vec::new();
        let mut open = HashSet::new();
        let mut below = Some((part, item.object, item.transform));
        loop {
            if let Some((part, object, world)) = below.take() {
                if !open.insert((part.number, object)) {
                    let what = format!("{}: object {object} has components of itself", part.path);
                    return Err(Fault::broken(what));
                }
                add(part.object(object)?, &world, import)?;
                levels.push(Level { part, object, world, next: 0 });
            }
            let Some(level) = levels.last_mut() else { return Ok(()) };
            let part = level.part.clone();
            match part.object(level.object)?.components.get(level.next) {
                Some(component) => {
                    level.next += 1;
                    let world = level.world * component.transform;
                    let other = self.part(component, &part, import)?;
                    below = Some((other, component.object, world));
                }
                None => {
                    open.remove(&(part.number, level.object));
                    levels.pop();
                }
            }
        }
    }
}

/// Adds the triangles of an object, without those of its components.
fn add(object: &Object, world: &DMat4, import: &mut Import) -> Result<(), Fault> {
    import.budget.take(PLACED)?;
    let TriangleMesh { positions, triangles } = &object.mesh;
    import.budget.check_growth(&import.mesh, positions.len(), triangles.len())?;
    let first = import.push_placed(positions, world);
    import.mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| first + v)));
    Ok(())
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
    let mut part = Part { path: path.to_owned(), ..Part::default() };
    let mut object = None;
    let mut lattices = 0;
    // The prefix of the elements of the core specification, with its colon.
    let mut prefix = String::new();
    while let Some(event) = xml.next()? {
        let (element, is_empty) = match event {
            Event::Start(element) => (element, false),
            Event::Empty(element) => (element, true),
            Event::End(end) if end.name().as_ref().strip_prefix(&prefix[..]) == Some("object") => {
                close(&mut part, &mut object, &mut import.budget)?;
                continue;
            }
            _ => continue,
        };
        let name = element.name();
        if element.local_name().as_ref() == "model" {
            prefix = name.as_ref().trim_end_matches("model").to_owned();
        }
        match (name.as_ref().strip_prefix(&prefix[..]).unwrap_or_default(), &mut object) {
            ("model", _) => {
                check_required(&xml, &element)?;
                part.unit = xml.text(&element, "unit")?;
            }
            ("object", Some((id, _))) => {
                return Err(xml.fault(format!("object {id} has another object in it")));
            }
            ("object", None) => {
                let name = match xml.text(&element, "name")? {
                    None => xml.text(&element, "partnumber")?,
                    name => name,
                };
                let id = xml.natural(&element, "id")?;
                if part.objects.contains_key(&id) {
                    return Err(xml.fault(format!("there are two objects {id}")));
                }
                import.budget.take(PLACED + name.as_ref().map_or(0, String::len))?;
                object = Some((id, Object { name, ..Object::default() }));
                if is_empty {
                    close(&mut part, &mut object, &mut import.budget)?;
                }
            }
            ("vertex", Some((_, Object { mesh, .. }))) => {
                mesh.positions.push(xml.position(&element)?);
                import.budget.check_growth(&import.mesh, mesh.positions.len(), 0)?;
            }
            ("triangle", Some((_, Object { mesh, .. }))) => {
                let mut corners = [0; 3];
                for (corner, name) in corners.iter_mut().zip(["v1", "v2", "v3"]) {
                    *corner = xml.natural(&element, name)?;
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
                components.push(placed(&xml, &element, &mut import.budget)?);
            }
            ("item", None) => {
                let name = xml.text(&element, "partnumber")?;
                import.budget.take(name.as_ref().map_or(0, String::len))?;
                let placed = placed(&xml, &element, &mut import.budget)?;
                part.items.push(Item { placed, name });
            }
            (_, Some(_)) if element.local_name().as_ref() == "beamlattice" => lattices += 1,
            _ => {}
        }
    }
    if let Some((id, _)) = object {
        return Err(xml.fault(format!("object {id} has no end")));
    }
    import.note(&format!("{path}: beam lattices are passed over"), lattices);
    Ok(part)
}

/// Ends an object, whose mesh takes its part of the budget.
fn close(
    part: &mut Part,
    object: &mut Option<(u32, Object)>,
    budget: &mut Budget,
) -> Result<(), Fault> {
    let Some((id, mut object)) = object.take() else { return Ok(()) };
    let TriangleMesh { positions, triangles } = &mut object.mesh;
    budget.take(size_of_val(&positions[..]) + size_of_val(&triangles[..]))?;
    positions.shrink_to_fit();
    triangles.shrink_to_fit();
    part.objects.insert(id, object);
    Ok(())
}

/// Checks that extensions that are required leave geometry alone.
fn check_required(xml: &Xml<'_>, element: &BytesStart<'_>) -> Result<(), Fault> {
    let required = xml.text(element, "requiredextensions")?.unwrap_or_default();
    let namespaces = xml.namespaces(element)?;
    for prefix in required.split_whitespace() {
        let space = namespaces.get(prefix).map_or("", |space| space);
        if !HARMLESS.iter().any(|part| space.contains(part)) {
            let what = format!("requires the extension {prefix} ({space}), which is not read");
            return Err(xml.fault(what));
        }
    }
    Ok(())
}

/// An object and where it stands.
fn placed(xml: &Xml<'_>, element: &BytesStart<'_>, budget: &mut Budget) -> Result<Placed, Fault> {
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
    let path = xml.path(element)?.map(|path| within_package(&path));
    budget.take(PLACED + path.as_ref().map_or(0, String::len))?;
    Ok(Placed { path, object: xml.natural(element, "objectid")?, transform })
}
