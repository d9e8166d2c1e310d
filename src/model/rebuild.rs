//! A tree that is built while the old one is in use, a little with each refit.

use super::passes::Parallel;
use pfront_core::bvh::{BuildOptions, BvhStorage, SahSteps, node_bound};
use pfront_core::{Mesh, Node};

/// A build under way.
#[derive(Clone, Debug)]
pub(super) struct Rebuild {
    steps: SahSteps,
    /// Memory that grows with the steps: pages that nobody has touched cost nothing.
    items: Vec<Node>,
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// By how many nodes or items memory grows: a few pages.
const PART: usize = 1 << 10;

impl Rebuild {
    /// A build of which nothing is done; `None` if there is no memory for it.
    pub(super) fn new(mesh: Mesh<'_>) -> Option<Self> {
        let n = mesh.triangles().len();
        let (mut items, mut nodes, mut order) = (Vec::new(), Vec::new(), Vec::new());
        items.try_reserve_exact(n).ok()?;
        nodes.try_reserve_exact(node_bound(n)).ok()?;
        order.try_reserve_exact(n).ok()?;
        order.resize(n, 0);
        Some(Self { steps: SahSteps::new(), items, nodes, order })
    }

    pub(super) fn is_done(&self, mesh: Mesh<'_>) -> bool {
        self.steps.is_done(mesh)
    }

    /// Goes through so large a part of the triangles, one over `part`. To go through all of them takes about half as long as to
    /// refit the tree: loading is one such round, and each level of the tree two, in which runs of triangles are looked at
    /// and then divided. A refit on several threads or of few vertices takes less time, and then this has to, too.
    pub(super) fn advance(
        &mut self,
        mesh: Mesh<'_>,
        options: BuildOptions<'_>,
        parallel: Parallel,
        part: usize,
    ) {
        let n = mesh.triangles().len();
        let options = BuildOptions { join: parallel, ..options };
        let Self { steps, items, nodes, order } = self;
        let mut left = n / part.max(1);
        while !steps.is_done(mesh) {
            if items.len() < n {
                items.resize((items.len() + PART).min(n), Node::EMPTY);
            }
            if nodes.len() < steps.nodes() + 2 {
                let room = (nodes.len() + PART).min(node_bound(n));
                nodes.resize(room.max(steps.nodes() + 2), Node::EMPTY);
            }
            let storage = BvhStorage { nodes, order };
            let gone = steps.step(mesh, &options, storage, items);
            debug_assert!(gone.is_ok(), "there is room for a step");
            let Ok(gone) = gone else { break };
            match left.checked_sub(gone) {
                Some(less) if less > 0 => left = less,
                _ => break,
            }
        }
    }

    /// The nodes, whose boxes are still to be fitted, and the order of a tree that is done.
    pub(super) fn into_tree(self) -> (Vec<Node>, Vec<u32>) {
        let Self { steps, mut nodes, order, .. } = self;
        nodes.truncate(steps.nodes());
        nodes.shrink_to_fit();
        (nodes, order)
    }

    pub(super) fn bytes(&self) -> usize {
        (self.items.capacity() + self.nodes.capacity()) * size_of::<Node>()
            + self.order.capacity() * size_of::<u32>()
    }
}
