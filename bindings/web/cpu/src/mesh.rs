//! Meshes with their BVHs.

use crate::contacts::{bytes_out, f32_out, octets};
use crate::thrown::{not_solid, thrown};
use crate::values::{Positions, Triangles, corners, u32_out};
use crate::wide::{Coordinates, coordinates, f64_out};
use js_sys::{Float64Array, Uint8Array, Uint32Array};
use pfront::{Model, Solid};
use std::cell::OnceCell;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// A triangle mesh with the BVH that queries traverse.
#[wasm_bindgen]
pub struct Mesh {
    pub(crate) model: Arc<Model>,
    /// Made when a question about solids is first asked.
    solid: OnceCell<Solid>,
}

impl Mesh {
    fn of(model: Model) -> Self {
        Self { model: Arc::new(model), solid: OnceCell::new() }
    }

    /// The solid of the mesh that is `a` or `b` in a question.
    pub(crate) fn solid(&self, name: &str) -> Result<&Solid, JsValue> {
        if let Some(solid) = self.solid.get() {
            return Ok(solid);
        }
        let made = Solid::new(self.model.clone()).map_err(|fault| not_solid(fault, name))?;
        Ok(self.solid.get_or_init(|| made))
    }
}

#[wasm_bindgen]
impl Mesh {
    /// Checks a mesh and builds its BVH. Positions in a `Float64Array` are taken in f64, to the bit.
    ///
    /// Throws a `MeshError` with the `vertex` or the `triangle` at fault.
    #[wasm_bindgen(constructor)]
    pub fn new(positions: &Positions, triangles: &Triangles) -> Result<Self, JsValue> {
        let triangles = corners(triangles)?;
        let model = match coordinates(positions)? {
            Coordinates::F32(positions) => Model::new(positions, triangles),
            Coordinates::F64(positions) => Model::from_f64(positions, triangles),
        };
        model.map(Self::of).map_err(thrown)
    }

    /// Reads a mesh and its BVH out of the bytes of a `.pfb`, which `pfront bake` writes. Throws a `BlobError` or a `MeshError`.
    #[wasm_bindgen(js_name = fromBlob)]
    pub fn from_blob(
        #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    ) -> Result<Self, JsValue> {
        Model::from_blob(&octets(bytes)?).map(Self::of).map_err(thrown)
    }

    /// The bytes of a `.pfb`.
    #[wasm_bindgen(js_name = toBlob)]
    pub fn to_blob(&self) -> Result<Uint8Array, JsValue> {
        bytes_out(&self.model.to_blob().map_err(thrown)?)
    }

    /// Moves the vertices, and refits the BVH. Bodies of scenes keep the mesh that they have. Throws a `MeshError`.
    #[wasm_bindgen(js_name = setPositions)]
    pub fn set_positions(&mut self, positions: &Positions) -> Result<(), JsValue> {
        let positions = coordinates(positions)?;
        self.solid = OnceCell::new();
        if Arc::get_mut(&mut self.model).is_none() {
            self.model = Arc::new(self.model.try_clone().map_err(thrown)?);
        }
        // Nobody else has it now.
        let model = Arc::make_mut(&mut self.model);
        let moved = match positions {
            Coordinates::F32(positions) => model.set_positions(&positions),
            Coordinates::F64(positions) => model.set_positions(&positions),
        };
        moved.map_err(thrown)
    }

    /// A copy of the positions.
    #[wasm_bindgen(getter, unchecked_return_type = "Float32Array | Float64Array")]
    pub fn positions(&self) -> Result<JsValue, JsValue> {
        let mesh = self.model.mesh();
        if !self.model.is_f64() {
            return Ok(f32_out(mesh.shadow().as_flattened())?.into());
        }
        if let Some(positions) = mesh.positions_f64() {
            return Ok(f64_out(positions.as_flattened())?.into());
        }
        // Each is a number of f32.
        let narrow: JsValue = f32_out(mesh.shadow().as_flattened())?.into();
        Ok(Float64Array::new(&narrow).into())
    }

    /// A copy of the corners of triangles.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> Result<Uint32Array, JsValue> {
        u32_out(self.model.mesh().triangles().as_flattened())
    }

    /// The number of triangles.
    #[wasm_bindgen(getter, js_name = triangleCount)]
    pub fn triangle_count(&self) -> usize {
        self.model.mesh().triangles().len()
    }

    /// The number of vertices.
    #[wasm_bindgen(getter, js_name = vertexCount)]
    pub fn vertex_count(&self) -> usize {
        self.model.mesh().vertex_count()
    }
}
