//! One vertex or face of a PLY file: what we want of it.

use crate::error::Fault;
use crate::source::Source;
use crate::text::Line;
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType};

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
pub(crate) const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Stands for −1, with which a strip ends and another begins.
pub(crate) const RESTART: u32 = u32::MAX;

#[derive(Default)]
pub(crate) struct Element {
    pub(crate) position: [f64; 3],
    pub(crate) corners: Vec<u32>,
}

impl Element {
    /// Straight to f32 or f64 whatever the type is, so that all is rounded once.
    pub(crate) fn from_text(
        line: &Line<'_>,
        element: &ElementDef,
        source: &mut Source,
    ) -> Result<Self, Fault> {
        let mut read = Self::default();
        let mut words = line.words();
        for (name, property) in &element.properties {
            let word = line.word(words.next())?;
            if let PropertyType::List(..) = property.data_type {
                let count: u32 = line.number(Some(word))?;
                let mut list = (0..count).map(|_| line.word(words.next()));
                if INDICES.contains(&&name[..]) {
                    let is_strip = element.name == "tristrips";
                    let corners = list.map(|word| match word? {
                        b"-1" if is_strip => Ok(RESTART),
                        word => line.number(Some(word)),
                    });
                    read.corners = corners.collect::<Result<_, _>>()?;
                } else {
                    list.try_for_each(|word| word.map(drop))?;
                }
            } else if let Some(k) = axis(name) {
                read.position[k] = line.coordinate(Some(word), source)?;
            }
        }
        Ok(read)
    }
}

/// For what is binary.
impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let number = match property {
            Property::Double(x) => Some(x),
            Property::Int(x) => Some(x.into()),
            Property::UInt(x) => Some(x.into()),
            _ => property.to_f32_lossy().map(f64::from),
        };
        if let (Some(k), Some(x)) = (axis(name), number) {
            self.position[k] = x;
        } else if INDICES.contains(&name) {
            let Some(corners) = indices(&property) else {
                return PropertyAccessResult::UnsupportedType;
            };
            self.corners = corners;
        }
        PropertyAccessResult::Set
    }
}

fn indices(property: &Property) -> Option<Vec<u32>> {
    fn restarting<T: Copy + Into<i64>>(list: &[T]) -> Option<Vec<u32>> {
        let index = |&index: &T| match index.into() {
            -1 => Some(RESTART),
            index => u32::try_from(index).ok(),
        };
        list.iter().map(index).collect()
    }
    match property {
        Property::ListChar(list) => restarting(list),
        Property::ListShort(list) => restarting(list),
        Property::ListInt(list) => restarting(list),
        _ => property.to_u32_list(),
    }
}

fn axis(name: &str) -> Option<usize> {
    AXES.iter().position(|&axis| axis == name)
}
