//! Errors of the core as those of JavaScript, whose classes are in `js/errors.js`. All modules about meshes have this file.

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
