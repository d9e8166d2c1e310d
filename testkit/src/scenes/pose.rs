//! Poses: built and multiplied in f64, rounded once.

use crate::Rows;
use glam::{DAffine3, DMat3, DVec3};

/// Rounds a transform to f32.
pub fn round(world_from_object: DAffine3) -> Rows {
    let rows = world_from_object.matrix3.transpose();
    let t = world_from_object.translation;
    let row = |r: DVec3, t: f64| [r.x as f32, r.y as f32, r.z as f32, t as f32];
    [row(rows.x_axis, t.x), row(rows.y_axis, t.y), row(rows.z_axis, t.z)]
}

/// Rotation about y, z towards x.
pub(crate) fn about_y(angle: f64) -> DAffine3 {
    let (sin, cos) = libm::sincos(angle);
    let columns = [DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)];
    DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2]))
}

/// Rotation about z, x towards y.
pub(crate) fn about_z(angle: f64) -> DAffine3 {
    let (sin, cos) = libm::sincos(angle);
    let columns = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z];
    DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2]))
}

/// Translation by `offset`.
pub(crate) fn shift(offset: DVec3) -> DAffine3 {
    DAffine3::from_translation(offset)
}
