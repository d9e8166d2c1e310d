//! Values that come from JavaScript, and those that go there. All modules about meshes have this file.

use crate::error::of_memory;
use js_sys::{Float32Array, Float64Array, Uint32Array};
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./values.js")]
extern "C" {
    /// Coordinates, three for each vertex.
    #[wasm_bindgen(typescript_type = "Float32Array | Float64Array")]
    pub type Positions;
    /// Indices, three for each triangle.
    #[wasm_bindgen(typescript_type = "Uint32Array | Uint16Array | Uint8Array")]
    pub type Triangles;
    /// A matrix by columns.
    #[wasm_bindgen(typescript_type = "number[] | Float32Array | Float64Array")]
    pub type Matrix;
    #[wasm_bindgen(catch, js_name = isF64)]
    fn is_f64(positions: &JsValue) -> Result<bool, JsValue>;
    #[wasm_bindgen(catch)]
    fn indices(triangles: &JsValue) -> Result<Uint32Array, JsValue>;
    #[wasm_bindgen(catch)]
    fn numbers(matrix: &JsValue) -> Result<Float64Array, JsValue>;
    #[wasm_bindgen(catch, js_name = copyU32)]
    fn copy_u32(list: &[u32]) -> Result<Uint32Array, JsValue>;
}

/// Positions of f32, or none if they are of f64.
pub(crate) fn coordinates_f32(positions: &Positions) -> Result<Option<Vec<[f32; 3]>>, JsValue> {
    if is_f64(positions)? {
        return Ok(None);
    }
    let given: &Float32Array = positions.unchecked_ref();
    let mut list = zeros(given.length() as usize / 3, [0.0; 3])?;
    given.copy_to(list.as_flattened_mut());
    Ok(Some(list))
}

pub(crate) fn corners(triangles: &Triangles) -> Result<Vec<[u32; 3]>, JsValue> {
    let given = indices(triangles)?;
    let mut list = zeros(given.length() as usize / 3, [0; 3])?;
    given.copy_to(list.as_flattened_mut());
    Ok(list)
}

/// The entries of a matrix, and whether they are in f64; without one, the identity.
pub(crate) fn columns(matrix: Option<&Matrix>) -> Result<([f64; 16], bool), JsValue> {
    let mut columns = [0.0; 16];
    let Some(matrix) = matrix else {
        [0, 5, 10, 15].into_iter().for_each(|i| columns[i] = 1.0);
        return Ok((columns, false));
    };
    numbers(matrix)?.copy_to(&mut columns);
    Ok((columns, matrix.is_instance_of::<Float64Array>()))
}

pub(crate) fn pose_f32(columns: &[f64; 16]) -> Pose {
    Pose::from_cols_array(&columns.map(|x| x as f32))
}

pub(crate) fn pairs_out(pairs: &[TrianglePair]) -> Result<Uint32Array, JsValue> {
    u32_out(bytemuck::cast_slice(pairs))
}

pub(crate) fn u32_out(list: &[u32]) -> Result<Uint32Array, JsValue> {
    copy_u32(list)
}

/// An empty list with room for so many.
pub(crate) fn list<T>(n: usize) -> Result<Vec<T>, JsValue> {
    let mut list = Vec::new();
    let needed = n.saturating_mul(size_of::<T>());
    list.try_reserve_exact(n).map_err(|_| of_memory(needed))?;
    Ok(list)
}

pub(crate) fn zeros<T: Clone>(n: usize, zero: T) -> Result<Vec<T>, JsValue> {
    let mut list = list(n)?;
    list.resize(n, zero);
    Ok(list)
}
