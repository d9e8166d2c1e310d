//! What a BVTT node is expected to cost, from how far its boxes overlap (eqs. 2–4).

use super::FrontNode;
use crate::Aabb;
use crate::query::{NodePair, Query};

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
    /// The same for all nodes, eq. 3.
    Constant,
    /// Triangles per unit of extent in the two boxes, added up, so that α·V is how many triangles
    /// would lie in the overlap if they were spread evenly.
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
    /// α·V of a BVTT node; comparable between nodes of one query. Boxes are dilated so that flat ones
    /// count too. At least 0, and finite.
    pub(super) fn weight(self, query: &impl Query, n: NodePair) -> f64 {
        let [a, b] = query.boxes(n);
        let margin = f64::from(query.leaf_edge()) * 0.5;
        let measure = |low: [f32; 3], high: [f32; 3]| {
            let edges =
                [0, 1, 2].map(|k| (f64::from(high[k]) - f64::from(low[k]) + margin).max(0.0));
            match self.extent {
                Extent::Volume => edges[0] * edges[1] * edges[2],
                Extent::Penetration => edges[0].min(edges[1]).min(edges[2]),
            }
        };
        let overlap = intersection(&a, &b);
        let both = measure(overlap.min, overlap.max);
        match self.alpha {
            Alpha::Constant => both,
            Alpha::Density => {
                let counts = query.triangles_below(n);
                [(a, counts[0]), (b, counts[1])]
                    .into_iter()
                    .map(|(aabb, count)| {
                        let whole = measure(aabb.min, aabb.max);
                        // Points without extent overlap as a whole or not at all.
                        let share = if whole > 0.0 { both / whole } else { 1.0 };
                        share.min(1.0) * f64::from(count)
                    })
                    .sum()
            }
        }
    }
}

/// Prices the children of a node whose cost is an estimate, on the scale of that estimate.
pub(super) fn reprice(
    query: &impl Query,
    estimate: Estimate,
    children: &[NodePair],
    parent: FrontNode,
) -> [f32; 4] {
    let whole = estimate.weight(query, parent.pair);
    let scale = f64::from(parent.cost) / whole;
    if !(whole > 0.0 && scale.is_finite()) {
        return split(query, estimate, children, parent.cost);
    }
    let mut costs = [1.0; 4];
    for (cost, &pair) in costs.iter_mut().zip(children) {
        // A part is not dearer than the whole, even if it is denser.
        *cost = ((scale * estimate.weight(query, pair)) as f32).min(parent.cost);
    }
    costs
}

/// Splits `rest` among siblings by their weights, evenly where these tell nothing.
pub(super) fn split(
    query: &impl Query,
    estimate: Estimate,
    siblings: &[NodePair],
    rest: f32,
) -> [f32; 4] {
    let mut weights = [0.0; 4];
    for (weight, &pair) in weights.iter_mut().zip(siblings) {
        *weight = estimate.weight(query, pair);
    }
    let sum: f64 = weights.iter().sum();
    let even = 1.0 / siblings.len().max(1) as f64;
    weights.map(|w| {
        let share = if sum > 0.0 && sum.is_finite() { w / sum } else { even };
        (f64::from(rest) * share) as f32
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
