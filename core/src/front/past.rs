//! What a frame remembers of the last: one cost for each node of its front, by path.

use super::FrontNode;
use crate::front::heap::sort;
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

    /// How many levels two paths go together.
    fn shared_levels(self, other: Self) -> u32 {
        let differ = (self.0 ^ other.0) & !63;
        (differ.leading_zeros() / 2).min(self.level()).min(other.level())
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

/// The inertia of a front. Fronts change the costs they are derived from, if only by the box tests that splitting
/// takes out of the walk, and as a walk takes two levels in a step; without some inertia a still scene may swing
/// between two of them.
pub const HOLD: f32 = 0.9;

/// The measured costs of the last front, in its depth-first order: 16 bytes a node.
///
/// Any BVTT node at or above that front finds in it what its whole subtree cost, so that a frame
/// refines by measured costs as far as the last one did and has to estimate only beyond.
#[derive(Clone, Copy, Debug)]
pub struct Past<'a> {
    entries: &'a [PastCost],
    hold: f32,
}

impl Default for Past<'_> {
    fn default() -> Self {
        Self::NOTHING
    }
}

impl<'a> Past<'a> {
    /// Nothing remembered: the first frame, or motion without coherence.
    pub const NOTHING: Past<'static> = Past { entries: &[], hold: HOLD };

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
            if let Some(entry) = memory.get_mut(node.index as usize) {
                *entry = PastCost { path: node.path, cost: cost(node), query: node.query };
            }
        }
        Ok(Self::new(memory.get(..nodes.len()).unwrap_or_default()))
    }

    /// Borrows again what [`Past::record`] wrote for a front of so many nodes.
    #[must_use]
    pub fn new(memory: &'a [PastCost]) -> Self {
        Self { entries: memory, hold: HOLD }
    }

    /// The same with another inertia than [`HOLD`]: a node that the last frame split is split again until its
    /// cost has fallen below this share of the bound, above 0 and at most 1.
    #[must_use]
    pub fn with_hold(self, hold: f32) -> Self {
        Self { hold, ..self }
    }

    pub(super) fn hold(self) -> f32 {
        self.hold
    }

    /// The whole cost of the last frame.
    #[must_use]
    pub fn cost(self) -> f64 {
        self.entries.iter().map(|e| f64::from(e.cost)).sum()
    }

    /// Changes the numbers of queries, where other ones will be asked than in the frame before: entry by
    /// entry of `memory`, which [`Past::record`] wrote, forgetting those whose query gets no number.
    /// Returns how many entries are left.
    ///
    /// # Complexity
    /// O(entries), and O(n log n) if the order of the queries changes; `number` is called once for
    /// each query.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::front::*;
    /// let mut memory = [PastCost::default(); 3];
    /// let node = |query, index| FrontNode { query, index, ..FrontNode::default() };
    /// Past::record(&mut memory, &[node(0, 0), node(1, 1), node(5, 2)], |_| 1.0)?;
    /// // The second query is gone, the third has moved up.
    /// let left = Past::renumber(&mut memory, |query| [Some(0), None, None, None, None, Some(1)][query as usize]);
    /// assert_eq!(Past::new(&memory[..left]).cost(), 2.0);
    /// # Ok::<(), pfront_core::CapacityError>(())
    /// ```
    pub fn renumber(memory: &mut [PastCost], mut number: impl FnMut(u32) -> Option<u32>) -> usize {
        let (mut left, mut last, mut before, mut sorted) = (0, None, 0, true);
        for read in 0..memory.len() {
            let Some(&entry) = memory.get(read) else { break };
            let (_, new) = match last {
                Some((old, new)) if old == entry.query => (old, new),
                _ => *last.insert((entry.query, number(entry.query))),
            };
            if let Some(query) = new
                && let Some(free) = memory.get_mut(left)
            {
                *free = PastCost { query, ..entry };
                sorted &= before <= query;
                before = query;
                left += 1;
            }
        }
        if !sorted {
            sort(memory.get_mut(..left).unwrap_or_default(), |entry| (entry.query, entry.path));
        }
        left
    }

    /// What is remembered of a whole query, for queries asked for in ascending order: `read` tells how
    /// far the last one reached.
    pub(super) fn of_query(self, query: u32, read: &mut usize) -> Self {
        let reached =
            self.entries.get(..*read).filter(|e| e.last().is_none_or(|e| e.query < query));
        let before = reached.map_or(0, <[_]>::len);
        let mut rest = Self { entries: self.entries.get(before..).unwrap_or_default(), ..self };
        let of_query = rest.advance(query, Path::ROOT);
        *read = self.entries.len() - rest.entries.len();
        of_query
    }

    /// What is remembered at and below a node, for nodes asked for in the order of a front: drops what
    /// lies before it, so that all together take one pass.
    #[inline]
    pub(super) fn advance(&mut self, query: u32, path: Path) -> Self {
        if self.entries.is_empty() {
            return *self;
        }
        let before = |e: &&PastCost| (e.query, e.path) < (query, path);
        let skipped = self.entries.iter().take_while(before).count();
        let rest = self.entries.get(skipped..).unwrap_or_default();
        let inside = |e: &&PastCost| e.query == query && e.path <= path.last();
        let count = rest.iter().take_while(inside).count();
        let (below, rest) = rest.split_at_checked(count).unwrap_or_default();
        self.entries = rest;
        Self { entries: below, ..*self }
    }

    /// Whether the memory of a node goes further down than the node.
    pub(super) fn goes_below(self, path: Path) -> bool {
        self.entries.last().is_some_and(|e| e.path > path)
    }

    /// The box tests with which the last frame split the node at `path`, above all this: had it not been
    /// split, it would have cost so much more.
    pub(super) fn spent_above(self, path: Path) -> f32 {
        const TESTS_PER_SPLIT: u32 = 4;
        let mut splits = 0;
        let (mut last, mut branch) = (path, path.level());
        for entry in self.entries {
            // New are the nodes from where this path leaves the last one down to its own.
            if last != path {
                branch = last.shared_levels(entry.path) + 1;
            }
            splits += entry.path.level().saturating_sub(branch);
            last = entry.path;
        }
        (TESTS_PER_SPLIT * splits) as f32
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
