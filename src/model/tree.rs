//! The BVH of a model, and when it is built anew.

use super::moves::{MANY, Moves};
use super::passes::{Parallel, threads};
use super::rebuild::Rebuild;
use crate::Error;
use crate::memory::{copy, filled, reserve};
use pfront_core::bvh::{
    self, BuildOptions, BvhStorage, REBUILD_RATIO, Refit, RefitRow, node_bound,
};
use pfront_core::one_ring::{Certified, fan_bound};
use pfront_core::{Bvh, Mesh, Node};
use std::mem::take;
use std::sync::OnceLock;

/// The quality figure of a tree that is [worn out](Tree::is_worn_out), over that when it was built. A frame may take twice its
/// best time, and there it does so without a build.
const WORN_OUT: f32 = 2.0;

#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// The state of partial refits; empty until there is one, and when the last refit was not partial.
    table: Vec<RefitRow>,
    /// The quality figure right after the last build, and as it is.
    built: f32,
    quality: f32,
    /// The tree that takes the place of this one when it is done, if this one is worn.
    next: Option<Box<Rebuild>>,
    /// Marks of nodes around vertices of many triangles, made when they are first asked for.
    fans: OnceLock<Vec<u32>>,
}

impl Tree {
    /// # Errors
    /// [`Error::Memory`].
    pub(super) fn build(
        mesh: Mesh<'_>,
        options: BuildOptions<'_>,
        parallel: Parallel,
    ) -> Result<Self, Error> {
        let mut tree = Self::default();
        tree.rebuild(mesh, options, parallel)?;
        Ok(tree)
    }

    /// A copy, without the state of partial refits.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub(super) fn try_clone(&self) -> Result<Self, Error> {
        let (nodes, order) = (copy(&self.nodes)?, copy(&self.order)?);
        let (table, fans, next) = (Vec::new(), OnceLock::new(), None);
        Ok(Self { nodes, order, table, fans, next, ..*self })
    }

    /// Takes over a tree of these positions that was checked, and makes its boxes tight, as those of a build are.
    pub(super) fn adopt(
        mesh: Mesh<'_>,
        nodes: Vec<Node>,
        order: Vec<u32>,
        parallel: Parallel,
    ) -> Self {
        let mut tree = Self { nodes, order, ..Self::default() };
        tree.refit(mesh, Refit { join: parallel, ..Refit::default() });
        tree.built = tree.quality;
        tree
    }

    /// Builds the tree anew for these positions.
    ///
    /// # Errors
    /// [`Error::Memory`]; the tree is as it was.
    pub(super) fn rebuild(
        &mut self,
        mesh: Mesh<'_>,
        options: BuildOptions<'_>,
        parallel: Parallel,
    ) -> Result<(), Error> {
        let n = mesh.triangles().len();
        let [nodes, order] = [node_bound(n) - self.nodes.len(), n - self.order.len()];
        let mut scratch = filled(Node::EMPTY, n)?;
        reserve(&mut self.nodes, nodes)?;
        reserve(&mut self.order, order)?;
        self.nodes.resize(node_bound(n), Node::EMPTY);
        self.order.resize(n, 0);
        self.table.clear();
        let storage = BvhStorage { nodes: &mut self.nodes, order: &mut self.order };
        let options = BuildOptions { join: parallel, ..options };
        let built = bvh::sah(mesh, &options, storage, &mut scratch);
        // With buffers of the right size it never fails.
        debug_assert!(built.is_ok(), "{:?}", built.err());
        let used = built.map_or(0, |bvh| bvh.nodes().len());
        self.nodes.truncate(used);
        self.nodes.shrink_to_fit();
        // Changes no box of a new tree.
        self.refit(mesh, Refit { join: parallel, ..Refit::default() });
        self.built = self.quality;
        self.fans = OnceLock::new();
        self.next = None;
        Ok(())
    }

    /// Whether the next [`Tree::fit`] makes another tree of it, if there is memory.
    pub(super) fn is_due(&self, mesh: Mesh<'_>) -> bool {
        self.is_worn_out() || self.next.as_ref().is_some_and(|next| next.is_done(mesh))
    }

    /// Adds to certificates the marks by which queries skip the fans around vertices of many triangles, if there is memory for
    /// them.
    pub(super) fn with_fans<'a>(
        &'a self,
        certified: Certified<'a>,
        mesh: Mesh<'a>,
    ) -> Certified<'a> {
        let bvh = self.bvh(mesh);
        if let Some(fans) = self.fans.get() {
            return certified.with_fans_unchecked(&bvh, fans);
        }
        let Ok(mut marks) = filled(0, fan_bound(bvh.nodes().len())) else { return certified };
        let is_marked = certified.with_fans(&bvh, &mut marks).is_ok();
        debug_assert!(is_marked, "the marks have their size");
        certified.with_fans_unchecked(&bvh, self.fans.get_or_init(|| marks))
    }

    /// Fits the tree to positions that have moved since it did. If it is [due](Tree::is_due), it is another one then; if it is
    /// worn, a part of another one is built. Without memory for another one it stays, only slower.
    pub(super) fn fit(
        &mut self,
        mesh: Mesh<'_>,
        options: BuildOptions<'_>,
        moves: &Moves,
        parallel: Parallel,
    ) {
        if self.is_worn_out() && self.rebuild(mesh, options, parallel).is_ok() {
            return;
        }
        if let Some(next) = self.next.take_if(|next| next.is_done(mesh)) {
            (self.nodes, self.order) = next.into_tree();
            self.table.clear();
            self.fans = OnceLock::new();
            self.refit(mesh, Refit { join: parallel, ..Refit::default() });
            self.built = self.quality;
            return;
        }
        self.refit_moved(mesh, moves, parallel);
        if self.next.is_none() && self.is_worn() {
            self.next = Rebuild::new(mesh).map(Box::new);
        }
        if let Some(next) = &mut self.next {
            // A refit of few vertices looks at a part of the tree.
            let part = threads(parallel) * if moves.few().is_some() { MANY } else { 1 };
            next.advance(mesh, options, parallel, part);
        }
    }

    fn refit_moved(&mut self, mesh: Mesh<'_>, moves: &Moves, parallel: Parallel) {
        let rows = (self.nodes.len() / 2).saturating_sub(self.table.len());
        let moved = moves.few().filter(|_| reserve(&mut self.table, rows).is_ok());
        let Some(moved) = moved else {
            self.table.clear();
            return self.refit(mesh, Refit { join: parallel, ..Refit::default() });
        };
        // The first refit of few vertices fills the table.
        let moved = if self.table.is_empty() { None } else { Some(moved) };
        let mut table = take(&mut self.table);
        table.resize(self.nodes.len() / 2, RefitRow::default());
        self.refit(mesh, Refit { join: parallel, table: &mut table, moved });
        self.table = table;
    }

    fn refit(&mut self, mesh: Mesh<'_>, options: Refit<'_>) {
        let fitted = bvh::refit(mesh, &mut self.nodes, &self.order, options);
        // With a table of the right size it never fails.
        debug_assert!(fitted.is_ok(), "{fitted:?}");
        self.quality = fitted.unwrap_or(self.quality);
    }

    /// Whether it is time to build the tree anew, over some frames.
    pub(super) fn is_worn(&self) -> bool {
        self.quality > self.built * REBUILD_RATIO
    }

    /// Whether it is time to build the tree anew at once: it takes twice as many tests as it did.
    pub(super) fn is_worn_out(&self) -> bool {
        self.quality > self.built * WORN_OUT
    }

    #[inline]
    pub(super) fn bvh<'a>(&'a self, mesh: Mesh<'a>) -> Bvh<'a> {
        Bvh::new_unchecked(mesh, &self.nodes, &self.order)
    }

    /// Makes room for what a partial refit goes by, whatever tree a rebuild will make.
    pub(super) fn reserve(&mut self) {
        let rows = node_bound(self.order.len()) / 2;
        // Without it, refits are whole ones.
        let _ = self.table.try_reserve(rows - self.table.len());
    }

    pub(super) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.order.capacity() * size_of::<u32>()
            + self.table.capacity() * size_of::<RefitRow>()
            + self.next.as_ref().map_or(0, |next| next.bytes())
            + self.fans.get().map_or(0, Vec::capacity) * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::passes::ONE_THREAD;
    use pfront_testkit::scenes::icosphere;

    #[test]
    fn the_quality_is_known_after_few_moves_and_many() {
        let ball = icosphere(2_000);
        let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
        let options = BuildOptions::default();
        let mut tree = Tree::build(mesh, options, ONE_THREAD).unwrap();
        let mut before = ball.positions.clone();
        // Flatter from time to time, so that the figure changes but little.
        for (round, moving) in [9, 5, 1_000, 7, 0, 1_000, 1_000, 30].into_iter().enumerate() {
            let mut after = before.clone();
            after.iter_mut().take(moving).for_each(|p| p[2] *= 0.9);
            let mut moves = Moves::default();
            moves.add(&before, &after);
            assert_eq!(moves.few().is_some(), moving < 100);
            let mesh = mesh.with_positions(&after).unwrap();
            tree.fit(mesh, options, &moves, ONE_THREAD);
            let expected = bvh::quality(&tree.bvh(mesh));
            assert!((tree.quality - expected).abs() < 1e-5 * expected, "round {round}");
            before = after;
        }
        assert!(!tree.is_worn(), "never rebuilt");
    }

    #[test]
    fn a_worn_tree_is_replaced_after_some_fits() {
        let ball = icosphere(2_000);
        let corners = ball.triangles.as_flattened().iter().map(|&v| ball.positions[v as usize]);
        let corners: Vec<_> = corners.collect();
        let triangles: Vec<_> = (0..2_000).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mesh = Mesh::new(&corners, &triangles).unwrap();
        let options = BuildOptions::default();
        let mut tree = Tree::build(mesh, options, ONE_THREAD).unwrap();
        let first = tree.order.clone();
        let mut moves = Moves::default();
        moves.add_all();
        let (mut apart, mut fits) = (0.0, 0);
        while tree.order == first {
            // Triangles fly apart until the tree is worn, and hardly any further then.
            apart += if tree.next.is_none() { 1e-4 } else { 1e-7 };
            let flown = corners.iter().enumerate().map(|(i, p)| {
                let way = [1, 7, 13].map(|by| (i / 3 * by * 37 % 101) as f32);
                [0, 1, 2].map(|k| p[k] + apart * way[k])
            });
            let flown: Vec<_> = flown.collect();
            let mesh = mesh.with_positions(&flown).unwrap();
            let is_due = tree.is_due(mesh);
            tree.fit(mesh, options, &moves, ONE_THREAD);
            assert_eq!(tree.order != first, is_due, "foretold");
            tree.bvh(mesh).assert_well_formed();
            fits += usize::from(tree.next.is_some());
            assert!(apart < 1.0 && !tree.is_worn_out());
        }
        // Loading takes one, and each of some eight levels or more two.
        assert!((10..100).contains(&fits), "{fits}");
        assert!(!tree.is_worn() && tree.next.is_none());
    }
}
