//! PLY, text and binary, through `ply-rs-bw`: x, y and z of `vertex`, `vertex_indices` (or
//! `vertex_index`) of `face`; other elements and properties are passed over.

use super::MeshData;
use super::error::Fault;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult};

const AXES: [&str; 3] = ["x", "y", "z"];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(super) fn parse(bytes: &[u8]) -> Result<MeshData, Fault> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader)?;
    let mut mesh = MeshData::default();
    for element in header.elements.values() {
        match &element.name[..] {
            "vertex" => {
                AXES.iter().try_for_each(|&axis| has(element, &[axis]))?;
                let parser = Parser::<Vertex>::new();
                let vertices = parser.read_payload_for_element(&mut reader, element, &header)?;
                mesh.positions.extend(vertices.iter().map(|vertex| vertex.0));
            }
            "face" => {
                has(element, &INDICES)?;
                let parser = Parser::<Face>::new();
                let faces = parser.read_payload_for_element(&mut reader, element, &header)?;
                for (Face(corners), number) in faces.iter().zip(0_usize..) {
                    if corners.len() < 3 {
                        let what = format!("face {number} has {} corners", corners.len());
                        return Err(Fault::broken(what));
                    }
                    mesh.push_fan(corners);
                }
            }
            // Any number of them would take no bytes.
            name if element.properties.is_empty() => {
                return Err(Fault::broken(format!("element {name} has no properties")));
            }
            _ => {
                let parser = Parser::<Skipped>::new();
                parser.read_payload_for_element(&mut reader, element, &header)?;
            }
        }
    }
    Ok(mesh)
}

fn has(element: &ElementDef, names: &[&str]) -> Result<(), Fault> {
    if names.iter().any(|&name| element.properties.contains_key(name)) {
        return Ok(());
    }
    Err(Fault::broken(format!("a {} has no {}", element.name, names.join(" or "))))
}

struct Vertex([f32; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(k) = AXES.iter().position(|&axis| axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        // A double is rounded.
        let Some(x) = property.to_f32_lossy() else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0[k] = x;
        PropertyAccessResult::Set
    }
}

struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !INDICES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        // A negative index is of a wrong type too.
        let Some(corners) = property.to_u32_list() else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0 = corners;
        PropertyAccessResult::Set
    }
}

struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

impl From<ParseError> for Fault {
    fn from(error: ParseError) -> Self {
        Self::broken(error.to_string())
    }
}
