//! The estimated cost of a BVTT node, from the overlap of its boxes (eqs. 2–4).
//!
//! V is the volume of the overlap of the two boxes, dilated by half the edge of a leaf, so that flat and touching boxes
//! have one too. α is the density of triangles: α·V is how many triangles would lie in the overlap if those of either box
//! were spread evenly.

use super::FrontNode;
use crate::Aabb;
use crate::bvtt::{Estimated, NodePair, Query};

/// The cost in box tests of a triangle that may lie in an overlap. A policy: a factor of all estimates changes no partition. It
/// only counts where estimates stand beside measured costs, and there they are rough anyway.
const TESTS_PER_TRIANGLE: f64 = 16.0;

/// Estimates the cost of a node in box tests before anything below it has been visited. A single estimate may be off by
/// an order of magnitude. Sums over any cut through a BVTT, such as the node pairs that are
/// [pending](crate::bvtt::Cursor::pending), are as good. At least 0 and finite.
///
/// # Complexity
/// O(depth), to count triangles.
#[must_use]
pub fn estimate(query: &impl Query, n: NodePair) -> f64 {
    cost_of(query, n)
}

fn cost_of(query: &impl Estimated, n: NodePair) -> f64 {
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
    query: &impl Estimated,
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
fn margin(query: &impl Estimated) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree of one node pair, whose boxes are these.
    struct Boxes([Aabb; 2], f32);

    impl Estimated for Boxes {
        fn boxes(&self, _: NodePair) -> [Aabb; 2] {
            self.0
        }
        fn triangles_below(&self, _: NodePair) -> [u32; 2] {
            [32, 64]
        }
        fn leaf_edge(&self) -> f32 {
            self.1
        }
    }

    const fn aabb(min: [f32; 3], max: [f32; 3]) -> Aabb {
        Aabb { min, max }
    }

    /// Cubes of edge 3 that overlap in 1 × 2 × 0, all dilated by half a leaf's edge of 2.
    #[test]
    fn estimates_follow_the_overlap() {
        let (a, b) = (aabb([0.0; 3], [3.0; 3]), aabb([2.0, 1.0, 3.0], [5.0, 4.0, 6.0]));
        let share = 2.0 * 3.0 * 1.0 / 64.0;
        assert_eq!(cost_of(&Boxes([a, b], 2.0), NodePair::ROOT), 16.0 * share * (32.0 + 64.0));
        let point = aabb([1.0; 3], [1.0; 3]);
        assert_eq!(cost_of(&Boxes([point; 2], 0.0), NodePair::ROOT), 16.0 * (32.0 + 64.0));
    }

    /// Costs of children that overlap by these lengths, below a parent that costs 9 and overlaps by 10.
    fn shares<const N: usize>(is_measured: bool, overlaps: [f32; N]) -> [f32; N] {
        let slab = |x: f32| [aabb([0.0; 3], [x, 1.0, 1.0]); 2];
        let parent = FrontNode { cost: 9.0, ..FrontNode::default() };
        let query = Boxes(slab(10.0), 0.0);
        let costs = costs_of_children(&query, &parent, is_measured, &overlaps.map(slab));
        core::array::from_fn(|i| costs[i])
    }

    #[test]
    fn children_share_the_cost_of_their_parent() {
        // A measured cost less 1 is divided, an estimate is scaled by the overlap,
        assert_eq!(shares(true, [2.5, 7.5]), [2.0, 6.0]);
        assert_eq!(shares(false, [5.0]), [4.5]);
        assert_eq!(shares(false, [7.0, 7.0]), [6.3; 2]);
        // unless the children lie in the same place. Where nothing overlaps all get the same.
        assert_eq!(shares(false, [10.0; 4]), [2.25; 4]);
        assert_eq!(shares(true, [0.0; 4]), [2.0; 4]);
    }
}
