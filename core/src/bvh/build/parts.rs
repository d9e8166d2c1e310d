//! Work on disjoint slices, side by side where it pays.
//!
//! Every pass over many triangles halves them until a half is small, whether or not there is anyone to
//! take the other half: what comes out does not depend on who did it.
//!
//! The nodes are numbered as a walk from left to right meets them: the children of a node, all that
//! lies below the left one, all that lies below the right one. Where that second stretch begins is
//! known only when the first is finished. So if both grow at once, the right one begins where it would
//! if the left side had leaves of one triangle, and is moved up afterwards. A node is moved once for
//! every level of large runs above it at most.

use crate::bvh::Join;
use crate::bvh::{Node, node_bound};
use crate::index::split;

/// No more triangles are worth dividing: a pass over them takes some 50 µs. The meshes of tests are
/// small, and under miri tiny.
pub(super) const PART: usize = match (cfg!(test), cfg!(miri)) {
    (false, _) => 1 << 14,
    (true, false) => 1 << 6,
    (true, true) => 2,
};

/// Whether so many triangles are worth dividing. Without std hardly anyone is there to take the other half,
/// and a loop over all of them takes less machine code and stack.
pub(super) fn worth_dividing(triangles: usize) -> bool {
    cfg!(any(feature = "std", test)) && triangles > PART
}

/// Who runs the parts: the caller's `join`, or one after the other.
#[derive(Clone, Copy)]
pub(super) struct Parts<'j> {
    join: Option<&'j Join<'j>>,
}

/// A node to be written, and the free nodes for what lies below it.
pub(super) struct Room<'n> {
    pub(super) node: &'n mut Node,
    pub(super) below: &'n mut [Node],
    /// The index of the first node `below`.
    pub(super) base: usize,
}

impl<'n> Room<'n> {
    /// For a whole tree, if there is any room.
    ///
    /// The root takes slot 0; slot 1 stays empty so that siblings start at even indices.
    pub(super) fn of_root(nodes: &'n mut [Node]) -> Option<Self> {
        let (node, rest) = nodes.split_first_mut()?;
        let (unused, below) = split(rest, 1);
        unused.fill(Node::EMPTY);
        Some(Self { node, below, base: 2 })
    }
}

/// How many nodes a tree takes with so many used below its root.
pub(super) fn nodes_of_tree(below: usize) -> usize {
    if below == 0 { 1 } else { 2 + below }
}

impl<'j> Parts<'j> {
    pub(super) fn new(join: Option<&'j Join<'j>>) -> Self {
        Self { join }
    }

    /// Runs two tasks over `size` triangles together. What `join` leaves out is done after it.
    pub(super) fn both<A: Send, B: Send>(
        self,
        size: usize,
        mut a: impl FnMut() -> A + Send,
        mut b: impl FnMut() -> B + Send,
    ) -> (A, B) {
        let Some(join) = self.join.filter(|_| worth_dividing(size)) else { return (a(), b()) };
        let (mut of_a, mut of_b) = (None, None);
        join(&mut || of_a = Some(a()), &mut || of_b = Some(b()));
        (of_a.unwrap_or_else(a), of_b.unwrap_or_else(b))
    }

    /// Lets two siblings over so many triangles be built below a node; returns how many nodes that
    /// took, as `left` and `right` do for what lies below them.
    #[inline]
    pub(super) fn siblings(
        self,
        triangles: [usize; 2],
        below: &mut [Node],
        base: usize,
        mut left: impl FnMut(Room<'_>) -> usize + Send,
        mut right: impl FnMut(Room<'_>) -> usize + Send,
    ) -> usize {
        let Some(([first, second], rest)) = below.split_first_chunk_mut() else { return 0 };
        let base = base + 2;
        let size = triangles[0] + triangles[1];
        if self.join.is_none() || !worth_dividing(size) {
            let used = left(Room { node: first, below: rest, base });
            let (_, below) = split(rest, used);
            return 2 + used + right(Room { node: second, below, base: base + used });
        }
        let room = node_bound(triangles[0]) - 2;
        let (on_left, on_right) = split(rest, room);
        let (left_used, right_used) = self.both(
            size,
            || left(Room { node: first, below: on_left, base }),
            || right(Room { node: second, below: on_right, base: base + room }),
        );
        let gap = room - left_used;
        if gap > 0 {
            *second = moved_up(second, gap);
            for index in left_used..left_used + right_used {
                let node = rest.get(index + gap).map(|node| moved_up(node, gap));
                if let (Some(slot), Some(node)) = (rest.get_mut(index), node) {
                    *slot = node;
                }
            }
        }
        2 + left_used + right_used
    }
}

/// The node if what lies below it begins so many slots earlier.
fn moved_up(node: &Node, slots: usize) -> Node {
    let slots = if node.is_leaf() { 0 } else { slots as u32 };
    Node { first: node.first - slots, ..*node }
}
