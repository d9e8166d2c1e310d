//! The estimated cost of a BVTT node, from the overlap of its boxes (eqs. 2–4).
//!
//! V is the volume of the overlap of the two boxes, dilated by half the edge of a leaf, so that flat and touching boxes
//! have one too. α is the density of triangles: α·V is how many triangles would lie in the overlap if those of either box
//! were spread evenly.

use super::FrontNode;
use crate::Aabb;
use crate::bvtt::{NodePair, Query};

/// The cost in box tests of a triangle that may lie in an overlap.
const TESTS_PER_TRIANGLE: f64 = 16.0;

/// Estimates the cost of a node in box tests before anything below it has been visited. A single estimate may be off by
/// an order of magnitude. Sums over any cut through a BVTT, such as the node pairs that are
/// [pending](crate::bvtt::Cursor::pending), are as good. At least 0 and finite.
///
/// # Complexity
/// O(depth), to count triangles.
#[must_use]
pub fn estimate(query: &impl Query, n: NodePair) -> f64 {
    let margin = margin(query);
    let [a, b] = query.boxes(n);
    let counts = query.triangles_below(n);
    let overlap = volume(&intersection(&a, &b), margin);
    let inside = |aabb: &Aabb, count: u32| {
        let own = volume(aabb, margin);
        // Points overlap as a whole or not at all.
        let share = if own > 0.0 { overlap / own } else { 1.0 };
        share.min(1.0) * f64::from(count)
    };
    TESTS_PER_TRIANGLE * (inside(&a, counts[0]) + inside(&b, counts[1]))
}

/// Divides the cost of a node among its overlapping children.
///
/// A measured cost |n| is shared by overlap volume, as |n| − 1 in eq. 3. An estimate is not, since that would carry its
/// error down: the estimate of a child is its parent's times the child's overlap volume over its parent's.
pub(super) fn costs_of_children(
    query: &impl Query,
    parent: &FrontNode,
    is_measured: bool,
    boxes: &[[Aabb; 2]],
) -> [f32; 4] {
    let margin = margin(query);
    let overlap = |[a, b]: &[Aabb; 2]| volume(&intersection(a, b), margin);
    let mut volumes = [0.0; 4];
    for (volume, boxes) in volumes.iter_mut().zip(boxes) {
        *volume = overlap(boxes);
    }
    let (sum, count) = (volumes.iter().sum::<f64>(), boxes.len().max(1) as f64);
    let parent_volume = overlap(&query.boxes(parent.pair));
    // Siblings in the same place overlap as much as their parent, each. If each cost as much as the parent, the sum
    // would grow with every split and no front would meet its bound. So estimates that add up to more than
    // 1 + count / 4 times the parent's are shared too.
    let is_share =
        is_measured || !(parent_volume > 0.0 && sum <= parent_volume * (1.0 + 0.25 * count));
    let divisor = if is_share { sum } else { parent_volume };
    let cost = f64::from(if is_measured { parent.cost - 1.0 } else { parent.cost });
    volumes.map(|volume| {
        let share = volume / divisor;
        // Evenly where volumes tell nothing; rounding aside, a child has no more overlap than its parent.
        (cost * if share.is_finite() { share.min(1.0) } else { 1.0 / count }) as f32
    })
}

/// Half the edge of a leaf, by which boxes are dilated in all.
fn margin(query: &impl Query) -> f64 {
    f64::from(query.leaf_edge()) * 0.5
}

fn volume(aabb: &Aabb, margin: f64) -> f64 {
    let edge = |k: usize| (f64::from(aabb.max[k]) - f64::from(aabb.min[k]) + margin).max(0.0);
    edge(0) * edge(1) * edge(2)
}

fn intersection(a: &Aabb, b: &Aabb) -> Aabb {
    let mut out = *a;
    for k in 0..3 {
        out.min[k] = a.min[k].max(b.min[k]);
        out.max[k] = a.max[k].min(b.max[k]);
    }
    out
}
