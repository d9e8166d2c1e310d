//! Contacts, and other lists that go to JavaScript. The small module has this file too.

use crate::values::{list, zeros};
use js_sys::{Float32Array, Uint8Array};
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Contact;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./values.js")]
extern "C" {
    /// Columns of contacts.
    #[wasm_bindgen(typescript_type = "Contacts")]
    pub type Contacts;
    #[wasm_bindgen(catch)]
    fn bytes(given: &JsValue) -> Result<Uint8Array, JsValue>;
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

pub(crate) fn octets(given: &JsValue) -> Result<Vec<u8>, JsValue> {
    let given = bytes(given)?;
    let mut list = zeros(given.length() as usize, 0)?;
    given.copy_to(&mut list);
    Ok(list)
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
