//! Values that the small module has not: coordinates in f64, and distances.

use crate::thrown::thrown;
use crate::values::{Matrix, Positions, columns, coordinates_f32, pose_f32, zeros};
use js_sys::Float64Array;
use pfront::{AnyPose, Distance, Gap, Pose64};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "./values.js")]
extern "C" {
    /// The smallest distance.
    #[wasm_bindgen(typescript_type = "Gap")]
    pub type JsGap;

    #[wasm_bindgen(catch, js_name = copyF64)]
    fn copy_f64(list: &[f64]) -> Result<Float64Array, JsValue>;
    #[wasm_bindgen(catch)]
    fn gap(
        pair: &[u32],
        interval: &[f64],
        points: &[f64],
        body: Option<u32>,
    ) -> Result<JsGap, JsValue>;
}

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r"
/** The smallest distance of two meshes, and where it is. */
export interface Gap {
  /** The least and the greatest that it can be; both 0 where triangles intersect. */
  interval: Float64Array;
  /** The nearest triangles. */
  pair: Uint32Array;
  /** The nearest points of both, six numbers. */
  points: Float64Array;
  /** Of a scene: the nearest body. */
  body?: number;
}";

/// Coordinates in the precision in which they were given.
pub(crate) enum Coordinates {
    F32(Vec<[f32; 3]>),
    F64(Vec<[f64; 3]>),
}

pub(crate) fn coordinates(positions: &Positions) -> Result<Coordinates, JsValue> {
    if let Some(list) = coordinates_f32(positions)? {
        return Ok(Coordinates::F32(list));
    }
    let given: &Float64Array = positions.unchecked_ref();
    let mut list = zeros(given.length() as usize / 3, [0.0; 3])?;
    given.copy_to(list.as_flattened_mut());
    Ok(Coordinates::F64(list))
}

/// The pose of a matrix: in f64 if that is a `Float64Array`, and rounded to f32 if not; without one, the identity.
pub(crate) fn pose(matrix: Option<&Matrix>) -> Result<AnyPose, JsValue> {
    Ok(match columns(matrix)? {
        (columns, true) => Pose64::from_cols_array(&columns).into(),
        (columns, false) => pose_f32(&columns).into(),
    })
}

/// The least distance in f32 that is not less than this one.
pub(crate) fn distance(given: f64) -> Result<f32, JsValue> {
    Distance::at_least(given).map(Distance::get).map_err(|fault| thrown(fault.into()))
}

pub(crate) fn f64_out(list: &[f64]) -> Result<Float64Array, JsValue> {
    copy_f64(list)
}

pub(crate) fn gap_out(found: &Gap, body: Option<u32>) -> Result<JsGap, JsValue> {
    let pair = [found.pair.a, found.pair.b];
    gap(&pair, &found.interval, found.points.as_flattened(), body)
}
