//! Triangle pairs that are hard to decide, in families. The caller seeds the generator.

mod in_f64;
mod make;
mod motion;

pub use in_f64::{InF64, Triangle64};
pub use motion::MotionFamily;

use crate::{Point, Triangle};
use rand::{Rng, RngExt};

/// One way of making triangle pairs hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// Corners uniform in the unit cube.
    Random,
    /// Edges of 0.01 near each other: two fine surfaces.
    MeshLike,
    /// A corner of one ±1e-3 from the inside of the other.
    VertexFaceGap3,
    /// The same with ±1e-5.
    VertexFaceGap5,
    /// The same with ±1e-7.
    VertexFaceGap7,
    /// The same with ±1e-8.
    VertexFaceGap8,
    /// The same with ±1e-9.
    VertexFaceGap9,
    /// Two edges that pass each other at 0 to 1e-6.
    EdgeEdgeGap,
    /// The same at ±1e-3.
    EdgeEdgeGap3,
    /// The same at ±1e-5.
    EdgeEdgeGap5,
    /// The same at ±1e-7.
    EdgeEdgeGap7,
    /// The same at ±1e-8.
    EdgeEdgeGap8,
    /// The same at ±1e-9.
    EdgeEdgeGap9,
    /// Both in one axis-aligned plane.
    CoplanarAxis,
    /// Both in one plane, rotated and then rounded.
    CoplanarRotated,
    /// A corner in common.
    SharedVertex,
    /// An edge in common, the other corners close to one plane or not.
    SharedEdge,
    /// A corner of one on an edge of the other, rounded.
    TJunction,
    /// An edge of one through a corner of the other, rounded.
    EdgeThroughVertex,
    /// Triangles 1e-6 wide.
    Sliver,
    /// One or both are segments or points, near or on the other.
    Degenerate,
    /// All coordinates near 1e7, where f32 has steps of 1.
    Offset,
    /// A pair of another family scaled by 1e-20 to 1e20.
    Scaled,
    /// The two triangles, or the three axes, scaled differently.
    MixedScale,
    /// Coordinates close to the largest f32.
    Huge,
    /// Coordinates of a few steps of the smallest subnormal.
    Subnormal,
    /// Coordinates in −3..=3: every degenerate combination comes up.
    Lattice,
    /// The same triangle twice, corners in any order, perhaps one bit off.
    Duplicate,
    /// Any finite bit pattern.
    RawBits,
}

impl Family {
    /// Every family.
    pub const ALL: [Family; 29] = [
        Family::Random,
        Family::MeshLike,
        Family::VertexFaceGap3,
        Family::VertexFaceGap5,
        Family::VertexFaceGap7,
        Family::VertexFaceGap8,
        Family::VertexFaceGap9,
        Family::EdgeEdgeGap,
        Family::EdgeEdgeGap3,
        Family::EdgeEdgeGap5,
        Family::EdgeEdgeGap7,
        Family::EdgeEdgeGap8,
        Family::EdgeEdgeGap9,
        Family::CoplanarAxis,
        Family::CoplanarRotated,
        Family::SharedVertex,
        Family::SharedEdge,
        Family::TJunction,
        Family::EdgeThroughVertex,
        Family::Sliver,
        Family::Degenerate,
        Family::Offset,
        Family::Scaled,
        Family::MixedScale,
        Family::Huge,
        Family::Subnormal,
        Family::Lattice,
        Family::Duplicate,
        Family::RawBits,
    ];

    /// The families whose coordinates are of moderate size, which others scale and move.
    const MODERATE: [Family; 13] = [
        Family::Random,
        Family::MeshLike,
        Family::VertexFaceGap7,
        Family::EdgeEdgeGap,
        Family::CoplanarAxis,
        Family::CoplanarRotated,
        Family::SharedVertex,
        Family::SharedEdge,
        Family::TJunction,
        Family::EdgeThroughVertex,
        Family::Sliver,
        Family::Degenerate,
        Family::Lattice,
    ];

    /// The name, as in the source.
    pub fn name(self) -> String {
        format!("{self:?}")
    }

    /// A pair of triangles with finite coordinates.
    pub fn pair(self, rng: &mut impl Rng) -> (Triangle, Triangle) {
        let [a, b] = make::pair(self, rng);
        let [a, b] = [a, b].map(|t| shuffled(t, rng));
        if rng.random() { (a, b) } else { (b, a) }
    }

    /// Two triangles of one mesh: six positions, those of a pair, and three indices for each
    /// triangle, which repeat or share indices in every combination.
    pub fn indexed(self, rng: &mut impl Rng) -> ([Point; 6], [u32; 3], [u32; 3]) {
        let (a, b) = self.pair(rng);
        let positions = [a[0], a[1], a[2], b[0], b[1], b[2]];
        let range = if rng.random() { 0..6 } else { 1..5 };
        let any = |rng: &mut _| [0; 3].map(|_| RngExt::random_range(rng, range.clone()));
        let (mut ta, mut tb): ([u32; 3], [u32; 3]) = (any(rng), any(rng));
        if rng.random() {
            // Without repeats, with `shared` common vertices.
            let shared = rng.random_range(0..=3u32);
            let shift = rng.random_range(0..6u32);
            (ta, tb) = ([0, 1, 2], [3 - shared, 4 - shared, 5 - shared]);
            [ta, tb] = [ta, tb].map(|t| shuffled(t.map(|v| (v + shift) % 6), rng));
        }
        (positions, ta, tb)
    }
}

fn shuffled<T: Copy>(t: [T; 3], rng: &mut impl Rng) -> [T; 3] {
    let [i, swap] = [rng.random_range(0..3usize), rng.random_range(0..2usize)];
    [t[i], t[(i + 1 + swap) % 3], t[(i + 2 - swap) % 3]]
}
