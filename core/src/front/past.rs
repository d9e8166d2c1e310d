//! What a frame remembers of the last: one cost for each node of its front, by path.

use super::FrontNode;
use bytemuck::{Pod, Zeroable};

/// The way from the root of a BVTT to a node: the child taken at each level, 2 bits each from the top,
/// and the level in the low 6 bits. Sorting paths gives the depth-first order of the tree.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct Path(u64);

impl Path {
    /// The path to the root.
    pub const ROOT: Self = Self(0);

    /// The most levels a path can tell; a front never goes deeper.
    pub const MAX_LEVEL: u32 = 29;

    /// How far below the root the node lies.
    #[must_use]
    pub fn level(self) -> u32 {
        (self.0 & 63) as u32
    }

    /// The path to child number `child`, 0 to 3, of a node above [`Path::MAX_LEVEL`].
    #[must_use]
    pub fn child(self, child: u32) -> Self {
        let level = self.level();
        Self((self.0 + 1) | u64::from(child) << (62 - 2 * level))
    }

    /// The path of the ancestor at `level`, or the node itself if that is not above it: with the depth
    /// of a starting front, the paper's backward index.
    #[must_use]
    pub fn ancestor(self, level: u32) -> Self {
        if level >= self.level() {
            return self;
        }
        let keep = !(u64::MAX >> (2 * level));
        Self(self.0 & keep | u64::from(level))
    }

    /// The largest path of the subtree below the node.
    pub(super) fn last(self) -> Self {
        Self(self.0 | u64::MAX >> (2 * self.level()))
    }
}

/// What one front node cost in the last frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PastCost {
    path: Path,
    cost: f32,
    query: u32,
}

/// The measured costs of the last front, in its depth-first order: 16 bytes a node.
///
/// Any BVTT node at or above that front finds in it what its whole subtree cost, so that a frame
/// refines by measured costs as far as the last one did and has to estimate only beyond.
#[derive(Clone, Copy, Debug, Default)]
pub struct Past<'a> {
    entries: &'a [PastCost],
}

impl<'a> Past<'a> {
    /// Nothing remembered: the first frame, or motion without coherence.
    pub const NOTHING: Past<'static> = Past { entries: &[] };

    /// Writes down a frame: `nodes` are all nodes of its front in any order, and `cost` tells what the
    /// walk from a node really did.
    ///
    /// # Errors
    /// [`crate::CapacityError`] if `memory` is shorter than the front.
    pub fn record(
        memory: &'a mut [PastCost],
        nodes: &[FrontNode],
        cost: impl Fn(&FrontNode) -> f32,
    ) -> Result<Self, crate::CapacityError> {
        crate::CapacityError::check("memory", nodes.len(), memory.len())?;
        for node in nodes {
            memory[node.index as usize] =
                PastCost { path: node.path, cost: cost(node), query: node.query };
        }
        Ok(Self { entries: &memory[..nodes.len()] })
    }

    /// Borrows again what [`Past::record`] wrote for a front of so many nodes.
    #[must_use]
    pub fn new(memory: &'a [PastCost]) -> Self {
        Self { entries: memory }
    }

    /// The whole cost of the last frame.
    #[must_use]
    pub fn cost(self) -> f64 {
        self.entries.iter().map(|e| f64::from(e.cost)).sum()
    }

    /// What is remembered of one query.
    pub(super) fn of_query(self, query: u32) -> Self {
        let first = self.entries.partition_point(|e| e.query < query);
        let end = self.entries.partition_point(|e| e.query <= query);
        Self { entries: &self.entries[first..end] }
    }

    /// What is remembered below a child of the node that `self` was narrowed to.
    pub(super) fn below(self, path: Path) -> Self {
        let first = self.entries.partition_point(|e| e.path < path);
        let end = self.entries.partition_point(|e| e.path <= path.last());
        Self { entries: &self.entries[first..end] }
    }

    /// Whether the memory of a node goes further down than the node.
    pub(super) fn goes_below(self, path: Path) -> bool {
        self.entries.last().is_some_and(|e| e.path > path)
    }

    pub(super) fn is_empty(self) -> bool {
        self.entries.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_sort_depth_first() {
        let root = Path::ROOT;
        let order = [
            root,
            root.child(0),
            root.child(0).child(0),
            root.child(0).child(3),
            root.child(1),
            root.child(3).child(2),
        ];
        assert!(order.is_sorted());
        assert_eq!(order[5].ancestor(1), root.child(3));
        assert_eq!(order[5].ancestor(0), root);
        assert_eq!(order[1].ancestor(7), order[1]);
        assert!(root.child(0).last() > order[3] && root.child(0).last() < order[4]);
        let deepest = (0..Path::MAX_LEVEL).fold(root, |p, _| p.child(3));
        assert_eq!(deepest.level(), Path::MAX_LEVEL);
        assert_eq!(deepest.ancestor(1), root.child(3));
    }
}
