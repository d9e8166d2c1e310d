//! What lies two levels below a node.

use super::Boxes;
use crate::Node;

/// The grandchildren of a node; where a child is a leaf, the child; of a leaf, the leaf itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Family {
    nodes: [u32; 4],
    len: usize,
    pub(crate) boxes: Boxes,
}

impl Family {
    #[inline(always)]
    pub(crate) fn below(tree: &[Node], node: u32) -> Self {
        let (mut nodes, mut len) = ([node; 4], 0);
        let parent = &tree[node as usize];
        if parent.is_leaf() {
            len = 1;
        } else {
            for index in [parent.first, parent.first + 1] {
                let child = &tree[index as usize];
                if child.is_leaf() {
                    nodes[len] = index;
                    len += 1;
                } else {
                    nodes[len] = child.first;
                    nodes[len + 1] = child.first + 1;
                    len += 2;
                }
            }
        }
        // Lanes to spare hold some node, which nobody asks for.
        let at = |lane: usize| &tree[nodes[lane] as usize];
        Self { nodes, len, boxes: Boxes::of_nodes([at(0), at(1), at(2), at(3)]) }
    }

    #[inline(always)]
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes[..self.len]
    }

    /// A bit for each lane in use.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }
}
