//! What a BVTT node is expected to cost, from how far its boxes overlap (eqs. 2–4).

use super::{FIRST_ALPHA, FrontNode};
use crate::Aabb;
use crate::bvtt::{NodePair, Query};

/// How the size of an overlap is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Extent {
    /// Its volume V (eq. 3).
    #[default]
    Volume,
    /// Its least edge, the penetration depth of two boxes: the alternative of section 3.2.1.
    Penetration,
}

/// The policy for α in |n| = α·V (eq. 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Alpha {
    /// The same for all nodes, eq. 3. In a first frame such that all nodes together cost what they do by
    /// density, so that the unit of length is of no account.
    Constant,
    /// Triangles per unit of extent in the two boxes of a starting node, added up, so that α·V is how
    /// many triangles would lie in the overlap if they were spread evenly; the same for all below it.
    #[default]
    Density,
}

/// How costs are estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Estimate {
    /// V.
    pub extent: Extent,
    /// α.
    pub alpha: Alpha,
}

impl Estimate {
    /// α·V of a starting node; comparable between the nodes of all queries. At least 0, and finite.
    pub(super) fn weight(self, query: &impl Query, n: NodePair) -> f64 {
        let margin = margin(query);
        let [a, b] = query.boxes(n);
        let both = self.extent.of(&intersection(&a, &b), margin);
        match self.alpha {
            Alpha::Constant => both,
            Alpha::Density => {
                let counts = query.triangles_below(n);
                let spread = |aabb: &Aabb, count: u32| {
                    let whole = self.extent.of(aabb, margin);
                    // Points without extent overlap as a whole or not at all.
                    let share = if whole > 0.0 { both / whole } else { 1.0 };
                    share.min(1.0) * f64::from(count)
                };
                spread(&a, counts[0]) + spread(&b, counts[1])
            }
        }
    }

    /// What a node is expected to cost in box tests, before anything has been walked: right to within a factor of
    /// three in half of all cases, and of thirty in nearly all. Sums over any cut through a BVTT, such as what is
    /// [pending](crate::bvtt::Cursor::pending), are worth as much.
    ///
    /// # Complexity
    /// O(depth), to count triangles.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::{front::Estimate, query::*};
    /// # fn rest(query: &impl Query, cursor: &Cursor) -> f64 {
    /// let estimate = Estimate::default();
    /// cursor.pending().iter().map(|n| estimate.cost(query, *n)).sum()
    /// # }
    /// ```
    #[must_use]
    pub fn cost(self, query: &impl Query, n: NodePair) -> f64 {
        FIRST_ALPHA * Self { alpha: Alpha::Density, ..self }.weight(query, n)
    }

    /// V of a node with these boxes, which is all that is asked below a starting node: counting triangles
    /// takes longer than all else, and tells no more there.
    fn overlap(self, query: &impl Query, [a, b]: &[Aabb; 2]) -> f64 {
        self.extent.of(&intersection(a, b), margin(query))
    }
}

impl Extent {
    /// The size of a box dilated by `margin` in all, so that flat ones count too.
    fn of(self, aabb: &Aabb, margin: f64) -> f64 {
        let edge = |k: usize| (f64::from(aabb.max[k]) - f64::from(aabb.min[k]) + margin).max(0.0);
        match self {
            Self::Volume => edge(0) * edge(1) * edge(2),
            Self::Penetration => edge(0).min(edge(1)).min(edge(2)),
        }
    }
}

/// Half the edge of a leaf: what boxes are dilated by.
fn margin(query: &impl Query) -> f64 {
    f64::from(query.leaf_edge()) * 0.5
}

/// Prices the children of a node whose cost is an estimate, on the scale of that estimate.
pub(super) fn reprice(
    query: &impl Query,
    estimate: Estimate,
    parent: FrontNode,
    children: &[[Aabb; 2]],
) -> [f32; 4] {
    let whole = estimate.overlap(query, &query.boxes(parent.pair));
    let scale = f64::from(parent.cost) / whole;
    if !(whole > 0.0 && scale.is_finite()) {
        return split(query, estimate, parent, children);
    }
    let mut costs = [0.0; 4];
    for (cost, boxes) in costs.iter_mut().zip(children) {
        // Rounding aside, a part has no more overlap than the whole.
        *cost = ((scale * estimate.overlap(query, boxes)) as f32).min(parent.cost);
    }
    // Where siblings lie in the same place, each overlaps as much as their parent. Were all to cost as much, a
    // front would grow dearer with every split and never fine enough. Half of that is taken for true.
    let sum: f32 = costs.iter().sum();
    if sum > parent.cost * (1.0 + 0.25 * children.len() as f32) {
        costs.map(|cost| cost * (parent.cost / sum))
    } else {
        costs
    }
}

/// Splits the cost of a node among its children by their overlap, evenly where that tells nothing.
pub(super) fn split(
    query: &impl Query,
    estimate: Estimate,
    parent: FrontNode,
    children: &[[Aabb; 2]],
) -> [f32; 4] {
    let mut weights = [0.0; 4];
    for (weight, boxes) in weights.iter_mut().zip(children) {
        *weight = estimate.overlap(query, boxes);
    }
    let sum: f64 = weights.iter().sum();
    let even = 1.0 / children.len().max(1) as f64;
    weights.map(|w| {
        let share = if sum > 0.0 && sum.is_finite() { w / sum } else { even };
        (f64::from(parent.cost) * share) as f32
    })
}

fn intersection(a: &Aabb, b: &Aabb) -> Aabb {
    let mut out = *a;
    for k in 0..3 {
        out.min[k] = a.min[k].max(b.min[k]);
        out.max[k] = a.max[k].min(b.max[k]);
    }
    out
}
