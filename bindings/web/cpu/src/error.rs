//! Errors of the library as those of JavaScript, whose classes are in `js/errors.js`.

use pfront_core::MeshError;
use pfront_core::pose::PoseError;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./errors.js")]
extern "C" {
    /// An error of the class of this name. The keys, apart by spaces, name what is at fault by these numbers.
    pub(crate) fn error(name: &str, message: &str, keys: &str, values: &[u32]) -> JsValue;
}

pub(crate) fn of_mesh(fault: &MeshError) -> JsValue {
    let (key, place) = match *fault {
        MeshError::NonFinite { vertex } | MeshError::Range { vertex } => ("vertex", vertex),
        MeshError::IndexOutOfRange { triangle, .. } => ("triangle", triangle),
        _ => ("", 0),
    };
    error("MeshError", &fault.to_string(), key, &[place as u32])
}

/// The texts are those of the library without floating-point numbers, whose formatting is large.
pub(crate) fn of_pose(fault: &PoseError) -> JsValue {
    match *fault {
        PoseError::NonFinite { row, column } => {
            let text = format!("entry {column} of row {row} of the pose is NaN or infinite");
            error("PoseError", &text, "row column", &[row as u32, column as u32])
        }
        PoseError::Range { row } => {
            let text = format!("row {row} of the pose takes the mesh beyond ±2^125");
            error("PoseError", &text, "row", &[row as u32])
        }
        _ => error("PoseError", "the pose is not possible", "", &[]),
    }
}

pub(crate) fn of_memory(needed: usize) -> JsValue {
    let text = format!("no memory for a list of {needed} bytes");
    error("MemoryError", &text, "needed", &[needed as u32])
}

#[cfg(feature = "all")]
pub(crate) use all::{not_solid, thrown};

#[cfg(feature = "all")]
mod all {
    use super::{error, of_memory, of_mesh, of_pose};
    use js_sys::Reflect;
    use pfront::{Error, NotSolid};
    use wasm_bindgen::JsValue;

    /// The error that says the same.
    pub(crate) fn thrown(fault: Error) -> JsValue {
        match fault {
            Error::Mesh(fault) => of_mesh(&fault),
            Error::Pose(fault) => of_pose(&fault),
            Error::Distance(_) => {
                error("DistanceError", "a distance is finite and not negative", "", &[])
            }
            Error::Memory { needed } => of_memory(needed),
            Error::Solid(fault) => of_solid(&fault),
            Error::StaleBody { id } => {
                let text = format!("{id} is not in the scene");
                error("StaleBody", &text, "body", &[id.to_bits() as u32])
            }
            Error::Blob(_) => error("BlobError", &fault.to_string(), "", &[]),
            _ => error("PfrontError", &fault.to_string(), "", &[]),
        }
    }

    fn of_solid(fault: &NotSolid) -> JsValue {
        let text = fault.to_string();
        match *fault {
            NotSolid::OpenEdge { triangle, edge } => {
                error("NotSolid", &text, "triangle edge", &[triangle, edge])
            }
            NotSolid::MeetsItself { pair } => error("NotSolid", &text, "a b", &[pair.a, pair.b]),
            _ => error("NotSolid", &text, "", &[]),
        }
    }

    /// The error that a mesh of a question, `a` or `b`, is no solid.
    pub(crate) fn not_solid(fault: Error, mesh: &str) -> JsValue {
        let error = thrown(fault);
        // An object of our own class takes a property.
        let _ = Reflect::set(&error, &"mesh".into(), &mesh.into());
        error
    }
}
