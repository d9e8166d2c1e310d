//! Values that come from JavaScript, and those that go there. The small module has this file too.

use crate::error::of_memory;
use js_sys::{Float32Array, Float64Array, Uint8Array, Uint32Array};
use pfront_core::Pose;
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Contact;
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
    /// Columns of contacts.
    #[wasm_bindgen(typescript_type = "Contacts")]
    pub type Contacts;
    #[wasm_bindgen(catch, js_name = isF64)]
    fn is_f64(positions: &JsValue) -> Result<bool, JsValue>;
    #[wasm_bindgen(catch)]
    fn indices(triangles: &JsValue) -> Result<Uint32Array, JsValue>;
    #[wasm_bindgen(catch)]
    fn bytes(given: &JsValue) -> Result<Uint8Array, JsValue>;
    #[wasm_bindgen(catch)]
    fn numbers(matrix: &JsValue) -> Result<Float64Array, JsValue>;
    #[wasm_bindgen(catch, js_name = copyU32)]
    fn copy_u32(list: &[u32]) -> Result<Uint32Array, JsValue>;
    #[wasm_bindgen(catch, js_name = copyF32)]
    fn copy_f32(list: &[f32]) -> Result<Float32Array, JsValue>;
    #[wasm_bindgen(catch, js_name = copyU8)]
    fn copy_u8(list: &[u8]) -> Result<Uint8Array, JsValue>;
    #[wasm_bindgen(catch)]
    fn contacts(
        pairs: &[u32],
        segments: &[f32],
        normals: &[f32],
        flat: &[u8],
        bodies: Option<&[u32]>,
    ) -> Result<Contacts, JsValue>;
}

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r"
export namespace Mesh {
  /** The mesh of a BufferGeometry of three.js, with its index or without; its draw range and groups are not looked at. */
  function fromGeometry(geometry: { attributes: { [name: string]: any }; index: any }): Mesh;
}
/** Where triangles meet: a row of each array for each pair, in their order. */
export interface Contacts {
  /** Two triangle indices a row. */
  pairs: Uint32Array;
  /** Two end points, six numbers a row. */
  segments: Float32Array;
  /** The unit normals of both triangles, six numbers a row. */
  normals: Float32Array;
  /** 1 for triangles that lie in one plane, whose segment is the longest chord of what they share. */
  flat: Uint8Array;
  /** Of a scene: two bodies a row. */
  bodies?: Uint32Array;
}";

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

pub(crate) fn octets(given: &JsValue) -> Result<Vec<u8>, JsValue> {
    let given = bytes(given)?;
    let mut list = zeros(given.length() as usize, 0)?;
    given.copy_to(&mut list);
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
    copy_u32(bytemuck::cast_slice(pairs))
}

pub(crate) fn u32_out(list: &[u32]) -> Result<Uint32Array, JsValue> {
    copy_u32(list)
}

pub(crate) fn f32_out(list: &[f32]) -> Result<Float32Array, JsValue> {
    copy_f32(list)
}

pub(crate) fn bytes_out(list: &[u8]) -> Result<Uint8Array, JsValue> {
    copy_u8(list)
}

pub(crate) fn contacts_out<'c>(
    found: impl ExactSizeIterator<Item = (TrianglePair, &'c Contact)>,
    bodies: Option<&[u32]>,
) -> Result<Contacts, JsValue> {
    let n = found.len();
    let (mut pairs, mut segments) = (list(n)?, list(n)?);
    let (mut normals, mut flat) = (list(n)?, list(n)?);
    for (pair, contact) in found {
        pairs.push(pair);
        segments.push(contact.segment);
        normals.push(contact.normals);
        flat.push(u8::from(contact.is_flat));
    }
    let [segments, normals] = [&segments, &normals].map(|rows| rows.as_flattened().as_flattened());
    contacts(bytemuck::cast_slice(&pairs), segments, normals, &flat, bodies)
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
