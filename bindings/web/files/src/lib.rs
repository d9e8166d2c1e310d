//! Mesh files for JavaScript, read as the command reads them.

use js_sys::{Float32Array, Float64Array, Uint32Array};
use pfront_files::{MeshFile, ReadOptions, TriangleMesh, read_bytes};
use std::path::Path;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./errors.js")]
extern "C" {
    fn error(name: &str, message: &str, keys: &str, values: &[u32]) -> JsValue;
}

/// A mesh as a file has it.
#[wasm_bindgen]
pub struct Contents {
    file: MeshFile,
    is_f64: bool,
}

#[wasm_bindgen]
impl Contents {
    /// Reads the bytes of a file; the format is told by how they begin, if it is not given. Coordinates are rounded to f32 if they
    /// are not wanted in f64.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8], format: Option<String>, is_f64: bool) -> Result<Self, JsValue> {
        let options = ReadOptions { format, in_f32: !is_f64, ..ReadOptions::default() };
        let read = read_bytes(bytes, &options).and_then(|read| read.into_mesh(Path::new("bytes")));
        match read {
            Ok(file) => Ok(Self { file, is_f64 }),
            Err(fault) => Err(error("FileError", &fault.to_string(), "", &[])),
        }
    }

    /// Coordinates, three for each vertex.
    pub fn positions(&self) -> JsValue {
        let TriangleMesh { positions, .. } = &self.file.mesh;
        let positions = positions.as_flattened();
        if self.is_f64 {
            return Float64Array::from(positions).into();
        }
        let narrow: Vec<f32> = positions.iter().map(|&x| x as f32).collect();
        Float32Array::from(&narrow[..]).into()
    }

    /// Indices, three for each triangle.
    pub fn triangles(&self) -> Uint32Array {
        Uint32Array::from(self.file.mesh.triangles.as_flattened())
    }

    /// The names of the bodies.
    pub fn names(&self) -> Vec<String> {
        self.file.source.bodies().to_vec()
    }

    /// The triangles of a body.
    pub fn body(&self, body: usize) -> Uint32Array {
        let bodies = self.file.source.triangles(self.file.mesh.triangles.len());
        Uint32Array::from(bodies.get(body).map_or(&[][..], |triangles| triangles))
    }

    /// Lines about what was passed over or rounded.
    pub fn notes(&self) -> Vec<String> {
        self.file.notes.clone()
    }
}
