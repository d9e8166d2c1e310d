//! The BVH of a model, and when it is built anew.

use super::moves::Moves;
use super::passes::Passes;
use pfront_core::bvh::node_bound;
use pfront_core::bvh::{
    self, Below, BuildOptions, BvhStorage, REBUILD_RATIO, SahItem, refit_moved, survey_bound,
};
use pfront_core::{Bvh, Mesh, Node};

#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// What a partial refit goes by; empty until there is one, and when the last refit was not.
    table: Vec<Below>,
    /// The quality figure right after the last build, and as it is.
    built: f32,
    quality: f32,
}

impl Tree {
    pub(super) fn build(mesh: Mesh<'_>, options: &BuildOptions, passes: &Passes) -> Self {
        let mut tree = Self::default();
        tree.rebuild(mesh, options, passes);
        tree
    }

    /// Takes over a tree of these positions that was checked, and makes its boxes tight, as those of a build are.
    pub(super) fn adopt(
        mesh: Mesh<'_>,
        mut nodes: Vec<Node>,
        order: Vec<u32>,
        passes: &Passes,
    ) -> Self {
        let built = (passes.refit)(mesh, &mut nodes, &order);
        Self { nodes, order, table: Vec::new(), built, quality: built }
    }

    /// Builds the tree anew for these positions.
    pub(super) fn rebuild(&mut self, mesh: Mesh<'_>, options: &BuildOptions, passes: &Passes) {
        let n = mesh.triangles().len();
        self.nodes.resize(node_bound(n), Node::EMPTY);
        self.order.resize(n, 0);
        self.table.clear();
        let mut scratch = vec![SahItem::default(); bvh::sah_scratch_bound(n)];
        let storage = BvhStorage { nodes: &mut self.nodes, order: &mut self.order };
        let built = (passes.sah)(mesh, options, storage, &mut scratch);
        // With buffers of the right size it never fails.
        debug_assert!(built.is_ok(), "{:?}", built.err());
        let used = built.map_or(0, |bvh| bvh.nodes().len());
        self.nodes.truncate(used);
        self.nodes.shrink_to_fit();
        self.built = (passes.quality)(mesh, &mut self.nodes, &self.order);
        self.quality = self.built;
    }

    /// Fits the tree to positions that have moved since it did; builds it anew if it was worn then.
    pub(super) fn fit(
        &mut self,
        mesh: Mesh<'_>,
        options: &BuildOptions,
        moves: &Moves,
        passes: &Passes,
    ) {
        if self.is_worn() {
            return self.rebuild(mesh, options, passes);
        }
        let Some(moved) = moves.few() else {
            self.table.clear();
            self.quality = (passes.refit)(mesh, &mut self.nodes, &self.order);
            return;
        };
        let (nodes, order) = (&mut self.nodes, &self.order);
        let fitted = if self.table.is_empty() {
            self.table.resize(survey_bound(nodes.len()), Below::default());
            bvh::survey(mesh, nodes, order, &mut self.table, &passes.both)
        } else {
            refit_moved(mesh, nodes, order, moved, &mut self.table, &passes.both)
        };
        debug_assert!(fitted.is_ok(), "{fitted:?}");
        self.quality = fitted.unwrap_or(self.quality);
    }

    /// Whether it is time to build the tree anew.
    pub(super) fn is_worn(&self) -> bool {
        self.quality > self.built * REBUILD_RATIO
    }

    #[inline]
    pub(super) fn bvh<'a>(&'a self, mesh: Mesh<'a>) -> Bvh<'a> {
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }

    /// Makes room for what a partial refit goes by, whatever tree a rebuild will make.
    pub(super) fn reserve(&mut self) {
        let rows = survey_bound(node_bound(self.order.len()));
        self.table.reserve(rows - self.table.len());
    }

    pub(super) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.order.capacity() * size_of::<u32>()
            + self.table.capacity() * size_of::<Below>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::passes::ONE_THREAD;
    use pfront_scenes::icosphere;

    #[test]
    fn the_quality_is_known_after_few_moves_and_many() {
        let ball = icosphere(2_000);
        let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
        let options = BuildOptions::default();
        let mut tree = Tree::build(mesh, &options, &ONE_THREAD);
        let mut before = ball.positions.clone();
        // Flatter from time to time, so that the figure changes but little.
        for (round, moving) in [9, 5, 1_000, 7, 0, 1_000, 1_000, 30].into_iter().enumerate() {
            let mut after = before.clone();
            after.iter_mut().take(moving).for_each(|p| p[2] *= 0.9);
            let mut moves = Moves::default();
            moves.add(&before, &after);
            assert_eq!(moves.few().is_some(), moving < 100);
            let mesh = mesh.with_positions(&after).unwrap();
            tree.fit(mesh, &options, &moves, &ONE_THREAD);
            let expected = bvh::quality(&tree.bvh(mesh));
            assert!((tree.quality - expected).abs() < 1e-5 * expected, "round {round}");
            before = after;
        }
        assert!(!tree.is_worn(), "never rebuilt");
    }
}
