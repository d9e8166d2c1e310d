//! The greedy partition of a front over p workers (Zhang & Kim 2014, section 3.3).
//!
//! The best p-partition is NP-hard. The greedy one takes nodes in descending order of cost and gives each to the worker
//! with the least so far (longest processing time first). The paper quotes (p+2)/(p+1) for it, which does not hold in the
//! worst case: costs 7, 7, 6, 6, 5, 5, 4, 4, 4 on four workers give 15 where 12 is possible. Two bounds do
//! hold: Graham's 4/3 − 1/(3p) over the optimum (*Bounds on Multiprocessing Timing Anomalies*, 1969), and a makespan of
//! at most (1 + ε)·W/p for a front whose costs are all at most ε·W/p.

use super::{Front, FrontNode};
use crate::sort::{sift_down, sort};

/// The part of a front that one worker gets. The caller's slice of these is the heap of the greedy partition.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// The predicted cost: the sum of the costs of its nodes.
    pub cost: f64,
    /// Its number, which is [`FrontNode::part`] of its nodes.
    pub number: u32,
}

impl<'a> Front<'a> {
    /// Assigns each node to one of `parts`, of which there is at least one: sets [`FrontNode::part`], and in `parts`, by
    /// number, the predicted costs. The largest is the predicted makespan. Returns the nodes in descending order of cost.
    ///
    /// The result depends on nothing but the nodes.
    ///
    /// # Panics
    /// If there are nodes and no parts.
    ///
    /// # Complexity
    /// O(N log N + N log p) for N nodes and p parts; no allocation.
    pub fn partition(self, parts: &mut [Part]) -> &'a mut [FrontNode] {
        let nodes = &mut self.nodes[..self.len];
        // Costs are positive, so that their bits sort as they do. Equal ones sort alike on every machine.
        sort(nodes, |node| (!node.cost.to_bits(), node.order()));
        clear(parts);
        let less =
            |x: &Part, y: &Part| (x.cost < y.cost) | ((x.cost == y.cost) & (x.number < y.number));
        for node in &mut *nodes {
            let least = &mut parts[0];
            node.part = least.number;
            least.cost += f64::from(node.cost);
            sift_down(parts, 0, less);
        }
        // The heap is not in the order of the numbers of parts, so the sums are written anew.
        clear(parts);
        for node in &*nodes {
            parts[node.part as usize].cost += f64::from(node.cost);
        }
        nodes
    }
}

fn clear(parts: &mut [Part]) {
    for (part, number) in parts.iter_mut().zip(0..) {
        *part = Part { cost: 0.0, number };
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use pfront_testkit::rng::{RngExt, seeded};
    use std::vec;
    use std::vec::Vec;

    fn partitioned(costs: &[f32], workers: usize) -> (Vec<FrontNode>, Vec<Part>) {
        let mut nodes = vec![FrontNode::default(); costs.len()];
        let mut front = Front::new(&mut nodes);
        for &cost in costs {
            front.push(FrontNode { cost, ..FrontNode::default() });
        }
        let mut parts = vec![Part::default(); workers];
        let nodes = front.partition(&mut parts).to_vec();
        (nodes, parts)
    }

    fn makespan(parts: &[Part]) -> f64 {
        parts.iter().fold(0.0, |most, part| most.max(part.cost))
    }

    #[test]
    fn small_costs_give_the_epsilon_bound() {
        let mut rng = seeded(3);
        for workers in [1, 2, 7, 64] {
            let costs: [f32; 600] = core::array::from_fn(|_| rng.random_range(1..=4096) as f32);
            let (nodes, parts) = partitioned(&costs, workers);
            assert!(nodes.is_sorted_by(|x, y| x.cost >= y.cost));
            let total: f64 = nodes.iter().map(|n| f64::from(n.cost)).sum();
            let mean = total / workers as f64;
            let epsilon = f64::from(nodes[0].cost) / mean;
            assert!(makespan(&parts) <= (1.0 + epsilon) * mean, "{workers}");
            for (part, number) in parts.iter().zip(0..) {
                let own = nodes.iter().filter(|n| n.part == number);
                let cost: f64 = own.map(|n| f64::from(n.cost)).sum();
                assert_eq!((cost, part.number), (part.cost, number));
            }
        }
    }

    /// Ties between equally busy parts go to the first in number.
    #[test]
    fn ties_go_by_number() {
        let (nodes, _) = partitioned(&[1.0; 8], 4);
        assert!(nodes.iter().map(|n| n.part).eq([0, 1, 2, 3, 0, 1, 2, 3]));
    }

    #[test]
    fn the_papers_bound_does_not_hold() {
        let (_, parts) = partitioned(&[7., 7., 6., 6., 5., 5., 4., 4., 4.], 4);
        assert_eq!(makespan(&parts), 15.0);
    }

    #[test]
    fn more_workers_than_nodes_leaves_some_idle() {
        let (_, parts) = partitioned(&[3.0, 1.0], 5);
        assert_eq!(makespan(&parts), 3.0);
        assert_eq!(parts.iter().filter(|part| part.cost == 0.0).count(), 3);
        assert!(partitioned(&[], 5).0.is_empty());
    }
}
