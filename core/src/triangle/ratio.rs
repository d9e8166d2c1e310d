//! Where a segment cuts a plane, with a bound of the error.

use crate::exact::difference;
use crate::exact::filter64::{ERROR_3D, UNDERFLOW_3D, larger};
use crate::exact::integer::orient3d_ratio;
use crate::scalar::Scalar;

/// The fraction of the segment from p to q, whose ends are on different sides, at which it cuts the plane of a triangle; and a bound
/// of its error.
pub(crate) fn fraction<C: Scalar>(t: &[[C; 3]; 3], p: &[C; 3], q: &[C; 3]) -> [f64; 2] {
    let [u, v, to_p, to_q] = [&t[1], &t[2], p, q].map(|x| difference(x, &t[0]));
    let normal = u.cross(v);
    let extent = larger(larger(u.abs(), v.abs()), larger(to_p.abs(), to_q.abs()));
    let error = extent.x * extent.y * extent.z * ERROR_3D + UNDERFLOW_3D;
    let (before, after) = (normal.dot(to_p), normal.dot(to_q));
    // They are of different signs, or 0.
    let whole = before.abs() + after.abs();
    let radius = error / (whole - 2.0 * error);
    if whole > 4.0 * error && radius < 5e-14 {
        return [before / (before - after), radius + 4.0 * f64::EPSILON];
    }
    [orient3d_ratio(t.each_ref(), p, q).clamp(0.0, 1.0), 1e-14]
}
