//! Dealing the nodes of a front out to p workers (Zhang & Kim 2014, section 3.3).
//!
//! The best p-partition is NP-hard; the greedy one takes nodes in descending order of cost and gives
//! each to the worker with the least so far (longest processing time first). The paper quotes
//! (p+2)/(p+1) for it. That does not hold in the worst case: costs 7, 7, 6, 6, 5, 5, 4, 4, 4 on four
//! workers give 15 where 12 is possible. What holds is Graham's 4/3 − 1/(3p) over the optimum (*Bounds
//! on Multiprocessing Timing Anomalies*, 1969), and, more useful here, that a front whose costs are
//! all at most ε·W/p gives a makespan of at most (1 + ε)·W/p.

use crate::front::FrontNode;
use crate::front::heap::{sift_down, sort};

/// What one worker has been dealt. The caller's slice of these is the heap.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Sum of the costs of its nodes.
    pub cost: f64,
    /// The worker.
    pub part: u32,
}

/// Sorts `nodes` by cost, dearest first, and deals them to `loads.len()` workers, of which there is
/// at least one: sets [`FrontNode::part`] of each node, and leaves in `loads` the predicted cost of each
/// worker, in no particular order. Returns the largest, the predicted makespan.
///
/// The result does not depend on the order of `nodes`, as long as their pairs differ.
///
/// # Complexity
/// O(N log N + N log p) for N nodes and p workers; no allocation.
///
/// # Examples
/// ```
/// use pfront_core::{front::FrontNode, partition::{Load, greedy}};
/// let node = |cost| FrontNode { cost, ..FrontNode::default() };
/// let mut nodes = [7., 7., 6., 6., 5., 5., 4., 4., 4.].map(node);
/// let mut loads = [Load::default(); 4];
/// assert_eq!(greedy(&mut nodes, &mut loads), 15.0);
/// ```
pub fn greedy(nodes: &mut [FrontNode], loads: &mut [Load]) -> f64 {
    for (part, load) in loads.iter_mut().enumerate() {
        *load = Load { cost: 0.0, part: part as u32 };
    }
    dearest_first(nodes);
    let less = |x: &Load, y: &Load| (x.cost < y.cost) | ((x.cost == y.cost) & (x.part < y.part));
    for node in nodes {
        let Some(least) = loads.first_mut() else { return 0.0 };
        node.part = least.part;
        least.cost += f64::from(node.cost);
        sift_down(loads, 0, less);
    }
    loads.iter().fold(0.0, |most, load| most.max(load.cost))
}

/// Sorts nodes by cost, dearest first; equal ones by query and pair.
///
/// # Complexity
/// O(N log N), with std O(N) if they are in order; no allocation.
pub fn dearest_first(nodes: &mut [FrontNode]) {
    // One number to compare, without branches.
    sort(nodes, |n| {
        // Costs are positive, so that their bits sort as they do.
        let place = u128::from(n.query) << 64 | u128::from(n.pair.a) << 32 | u128::from(n.pair.b);
        u128::from(!n.cost.to_bits()) << 96 | place
    });
}

/// How many workers can still help, eq. 6 of the paper: the whole cost over the dearest node, since
/// that node bounds the makespan however many workers there are. At least 1.
#[must_use]
pub fn p_optimal(nodes: &[FrontNode]) -> u32 {
    let (mut sum, mut most) = (0.0, 0.0);
    for node in nodes {
        let cost = f64::from(node.cost);
        sum += cost;
        most = if cost > most { cost } else { most };
    }
    if most > 0.0 {
        let ratio = sum / most;
        let whole = ratio as u32;
        if f64::from(whole) < ratio { whole + 1 } else { whole.max(1) }
    } else {
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvtt::NodePair;

    fn nodes<const N: usize>(costs: [f32; N]) -> [FrontNode; N] {
        let mut index = 0;
        costs.map(|cost| {
            index += 1;
            FrontNode { cost, pair: NodePair { a: index, b: 0 }, ..FrontNode::default() }
        })
    }

    #[test]
    fn small_costs_give_the_epsilon_bound() {
        let mut state = 3_u32;
        for workers in [1, 2, 7, 64] {
            let front: [f32; if cfg!(miri) { 130 } else { 600 }] = core::array::from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                1.0 + (state >> 20) as f32
            });
            let mut front = nodes(front);
            let mut loads = [Load::default(); 64];
            let makespan = greedy(&mut front, &mut loads[..workers]);
            assert!(front.is_sorted_by(|x, y| (-x.cost, x.pair.a) < (-y.cost, y.pair.a)));
            let total: f64 = front.iter().map(|n| f64::from(n.cost)).sum();
            let mean = total / workers as f64;
            let epsilon = f64::from(front[0].cost) / mean;
            assert!(makespan <= (1.0 + epsilon) * mean, "{workers}");
            for load in &loads[..workers] {
                let own = front.iter().filter(|n| n.part == load.part);
                assert_eq!(own.map(|n| f64::from(n.cost)).sum::<f64>(), load.cost);
            }
        }
    }

    #[test]
    fn more_workers_than_nodes_leaves_some_idle() {
        let mut front = nodes([3.0, 1.0]);
        let mut loads = [Load::default(); 5];
        assert_eq!(greedy(&mut front, &mut loads), 3.0);
        assert_eq!(loads.iter().filter(|l| l.cost == 0.0).count(), 3);
        assert_eq!(p_optimal(&front), 2);
        assert_eq!(p_optimal(&[]), 1);
    }

    #[test]
    fn the_deal_does_not_depend_on_the_order() {
        let mut one = nodes([5.0, 5.0, 3.0, 3.0, 3.0, 1.0]);
        let mut other = one;
        other.reverse();
        let mut loads = [Load::default(); 2];
        greedy(&mut one, &mut loads);
        greedy(&mut other, &mut loads);
        assert_eq!(one, other);
    }
}
