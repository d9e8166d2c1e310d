//! Errors of the library as those of JavaScript, whose classes are in `js/errors.js`.

use js_sys::Reflect;
use pfront::{Error, MeshError, NotSolid, PoseError};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./errors.js")]
extern "C" {
    /// An error of the class of this name. The keys, apart by spaces, name what is at fault by these numbers.
    fn error(name: &str, message: &str, keys: &str, values: &[u32]) -> JsValue;
}

/// The error that says the same.
pub(crate) fn thrown(fault: impl Into<Error>) -> JsValue {
    let fault = fault.into();
    let message = fault.to_string();
    match fault {
        Error::Mesh(fault) => {
            let (key, place) = match fault {
                MeshError::NonFinite { vertex } | MeshError::Range { vertex } => ("vertex", vertex),
                MeshError::IndexOutOfRange { triangle, .. } => ("triangle", triangle),
                _ => ("", 0),
            };
            error("MeshError", &message, key, &[place as u32])
        }
        Error::Pose(fault) => match fault {
            PoseError::NonFinite { row, column } => {
                error("PoseError", &message, "row column", &[row as u32, column as u32])
            }
            PoseError::Range { row } => error("PoseError", &message, "row", &[row as u32]),
            _ => error("PoseError", &message, "", &[]),
        },
        Error::Solid(fault) => match fault {
            NotSolid::OpenEdge { triangle, edge } => {
                error("NotSolid", &message, "triangle edge", &[triangle, edge])
            }
            NotSolid::MeetsItself { pair } => error("NotSolid", &message, "a b", &[pair.a, pair.b]),
            _ => error("NotSolid", &message, "", &[]),
        },
        Error::StaleBody { id } => {
            error("StaleBody", &format!("{id} is not in the scene"), "body", &[id.to_bits() as u32])
        }
        Error::Blob(_) => error("BlobError", &message, "", &[]),
        Error::Distance(_) => error("DistanceError", &message, "", &[]),
        Error::Memory { needed } => error("MemoryError", &message, "needed", &[needed as u32]),
        _ => error("PfrontError", &message, "", &[]),
    }
}

/// The error that a mesh of a question, `a` or `b`, is no solid.
pub(crate) fn not_solid(fault: Error, mesh: &str) -> JsValue {
    let error = thrown(fault);
    // An object of our own class takes a property.
    let _ = Reflect::set(&error, &"mesh".into(), &mesh.into());
    error
}
