//! The check that arrays are a BVH of a mesh.
//!
//! One preorder pass settles the structure without marking nodes. Children come after their parent, so every
//! path ends; the range of a leaf must begin where that of the leaf before it ended, so a node
//! reached twice is caught at its first leaf, and a tangled graph cannot take longer than a tree.

use super::arrays::{Bvh, preorder};
use super::{MAX_DEPTH, MAX_LEAF_SIZE};
use crate::aabb::Bounds;
use crate::{BvhError, CapacityError};

impl Bvh<'_> {
    pub(super) fn check(&self, scratch: &mut [u32]) -> Result<(), BvhError> {
        let (found, expected) = (self.order.len(), self.mesh.triangles().len());
        if found != expected {
            return Err(BvhError::Length { array: "order", expected, found });
        }
        check_permutation(self.order, scratch)?;
        let bounds = |index: usize| {
            let bounds = self.nodes[index].bounds();
            let is_finite = bounds.min.is_finite() && bounds.max.is_finite();
            if is_finite { Ok(bounds) } else { Err(BvhError::Box { node: index }) }
        };
        let (mut reached, mut covered) = (0, 0);
        preorder(self.nodes, |index, depth| {
            let node = &self.nodes[index];
            reached += 1;
            let content = if node.is_leaf() {
                let (first, count) = (node.first, node.count);
                let in_range = count as usize <= self.order.len() - covered;
                if first as usize != covered || count > MAX_LEAF_SIZE || !in_range {
                    return Err(BvhError::Leaf { node: index });
                }
                covered += count as usize;
                let triangles = self.order[first as usize..][..count as usize].iter();
                triangles.fold(Bounds::EMPTY, |all, &t| all.union(&self.mesh.bounds(t)))
            } else {
                let left = node.left() as usize;
                let in_range = left > index && left + 1 < self.nodes.len();
                if !in_range || !left.is_multiple_of(2) || depth == MAX_DEPTH {
                    return Err(BvhError::Child { node: index });
                }
                bounds(left)?.union(&bounds(left + 1)?)
            };
            let Bounds { min, max } = bounds(index)?;
            let contains = (min.cmple(content.min) & content.max.cmple(max)).all();
            if contains { Ok(()) } else { Err(BvhError::Box { node: index }) }
        })?;
        if covered != self.order.len() {
            return Err(BvhError::Order { entry: covered });
        }
        // The reached nodes are all different, and slot 1 is never among them.
        let expected = reached + usize::from(reached > 1);
        let found = self.nodes.len();
        if found != expected {
            return Err(BvhError::Length { array: "nodes", expected, found });
        }
        Ok(())
    }
}

/// Whether `order` holds each of 0 … its length − 1 once; a pass marks as many as `scratch` can.
fn check_permutation(order: &[u32], scratch: &mut [u32]) -> Result<(), BvhError> {
    if !order.is_empty() && scratch.is_empty() {
        let needed = order.len().div_ceil(u32::BITS as usize);
        return Err(CapacityError { buffer: "scratch", needed, capacity: 0 }.into());
    }
    if let Some(entry) = order.iter().position(|&t| t as usize >= order.len()) {
        return Err(BvhError::Order { entry });
    }
    let window = scratch.len().saturating_mul(u32::BITS as usize);
    for start in (0..order.len()).step_by(window.max(1)) {
        scratch.fill(0);
        for (entry, &triangle) in order.iter().enumerate() {
            // Triangles outside the window have their pass.
            let offset = (triangle as usize).wrapping_sub(start);
            if let Some(word) = scratch.get_mut(offset / u32::BITS as usize) {
                let mark = 1 << (offset % u32::BITS as usize);
                if *word & mark != 0 {
                    return Err(BvhError::Order { entry });
                }
                *word |= mark;
            }
        }
    }
    Ok(())
}
