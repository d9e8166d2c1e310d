//! Triangle tests of the literature, to compare with: written from the papers, as one would, in the
//! arithmetic their readers use. None is ours, none shares code with ours.
//!
//! - Möller, *A Fast Triangle-Triangle Intersection Test* (JGT 2(2), 1997), with the ε of its section on
//!   robustness and without: `moller`;
//! - Guigue & Devillers, *Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates*
//!   (JGT 8(1), 2003), in f32 and in f64: `orientation`;
//! - the theorem of separating axes (Gottschalk, Lin & Manocha, *OBBTree*, 1996, for triangles): `axes`;
//! - what parry3d itself does for two triangles, GJK.

mod axes;
mod moller;
mod orientation;
mod parry;

use crate::judge::Test;
use pfront_testkit::families::Triangle64;

/// The one that is right for f32 in f64, of triangles in f64.
pub const IN_F64: Test<Triangle64> =
    Test { name: "Guigue-Devillers, f64", meets: orientation::meet::<f64, f64> };

/// All of them.
pub fn tests() -> Vec<Test> {
    vec![
        Test { name: "Möller 1997, ε = 1e-6", meets: |a, b| moller::meet(a, b, 1e-6) },
        Test { name: "Möller 1997, ε = 0", meets: |a, b| moller::meet(a, b, 0.0) },
        Test { name: "Guigue-Devillers, f32", meets: orientation::meet::<f32, f32> },
        Test { name: "Guigue-Devillers, f64", meets: orientation::meet::<f64, f32> },
        Test { name: "17 separating axes, f32", meets: axes::meet },
        Test { name: "parry3d's own (GJK), f32", meets: parry::meet },
    ]
}
