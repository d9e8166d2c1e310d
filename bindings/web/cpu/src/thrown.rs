//! Errors of the library as those of JavaScript.

use crate::error::{error, of_memory, of_mesh, of_pose};
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
