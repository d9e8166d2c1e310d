//! What must hold of a front, for tests: call it after every change.

use super::Front;

impl Front<'_> {
    /// Checks that the nodes are numbered in order, sorted by query and path, pairwise disjoint, and
    /// have finite costs of at least 1.
    ///
    /// # Panics
    /// If one of these does not hold, or if the front has been dealt out, which reorders it.
    #[expect(clippy::panic, reason = "a test helper: panicking is its purpose")]
    pub fn assert_well_formed(&self) {
        for (i, node) in self.nodes().iter().enumerate() {
            if node.index as usize != i {
                panic!("node {i} is numbered {}", node.index);
            }
            if !(node.cost >= 1.0 && node.cost.is_finite()) {
                panic!("node {i} costs {}", node.cost);
            }
        }
        for (i, two) in self.nodes().windows(2).enumerate() {
            let ([x, y], ahead) = ([two[0], two[1]], two[0].query < two[1].query);
            // Of two nodes in depth-first order the second may only be below the first.
            if !ahead && (x.query > y.query || x.path.last() >= y.path) {
                panic!("nodes {i} and {} overlap or are out of order", i + 1);
            }
        }
    }
}
