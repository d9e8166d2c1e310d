//! Meshes that are hard to divide evenly.

use pfront_testkit::MeshData;

/// A height field over the unit square: 2·side² triangles. Flat, all its boxes are without volume.
pub(super) fn grid(side: u32, height: impl Fn(f32, f32) -> f32) -> MeshData {
    let at = |i: u32| i as f32 / side as f32;
    let points = (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j)));
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
    MeshData {
        positions: points.map(|(i, j)| [at(i), at(j), height(at(i), at(j))]).collect(),
        triangles: cells
            .flat_map(|c| [[c, c + 1, c + side + 1], [c + 1, c + side + 2, c + side + 1]])
            .collect(),
    }
}

/// Each triangle half the size of the last: its tree is a chain of nodes.
pub(super) fn chain() -> MeshData {
    let shrinking = (0..60).map(|i| 0.5_f32.powi(i));
    MeshData::of(shrinking.map(|s| [[s, 0.0, 0.0], [s, s, 0.0], [s, 0.0, s]]))
}

/// One triangle, through the unit sphere.
pub(super) fn wedge() -> MeshData {
    MeshData::of([[[-1.5, 0.1, 0.1], [1.5, 0.2, 0.1], [0.1, 1.5, 0.3]]])
}

/// Thin triangles side by side along a diagonal of the unit cube, from `lower` to 1 − `lower` in z: the box
/// of each is nearly the whole cube, so that of two such bundles all boxes overlap, and next to no triangles
/// meet. Where in the bundle each lies is a low-discrepancy sequence (Roberts 2018), to be the same
/// everywhere.
pub(super) fn needles(count: u32, lower: f32) -> MeshData {
    let spread = |step: f64, i: u32| (0.2 * (step * f64::from(i)).fract()) as f32;
    let corners = |i: u32| {
        let (x, y) = (spread(0.754_877_666, i), spread(0.569_840_291, i));
        let upper = 1.0 - lower;
        [[x, y, lower], [x + 0.8, y + 0.8, upper], [x + 0.8, y + 0.8001, upper]]
    };
    MeshData::of((0..count).map(corners))
}
