//! Refitting no more of a tree than has moved.
//!
//! Vertices that are near in space mostly have near indices too, so that a pair of siblings knows by the
//! smallest and the largest index below it whether anything there can have moved: a descent from the root
//! passes over what has not. Where it has, the triangles of a leaf are asked for the vertices themselves.
//! A row of a table for each pair of siblings holds that range and what the pair and all below it add to the
//! [`quality()`](super::quality()), which thus is summed up anew where boxes are, and drifts nowhere.

use super::refit::{Areas, Join, PART};
use crate::bvh::Node;
use crate::index::{at, range, split};
use crate::vertex_set::{Moved, holds, holds_any, moved_bound};
use crate::{CapacityError, Mesh};

/// What a refit knows of two siblings and all that lies below them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Below {
    areas: Areas,
    /// The smallest and the largest index of a vertex.
    range: [u32; 2],
}

/// How many rows the table of a tree of so many nodes has.
#[must_use]
pub const fn survey_bound(nodes: usize) -> usize {
    nodes.saturating_sub(2) / 2
}

/// [`refit_with`](super::refit_with) that fills the table which [`refit_moved`] goes by.
///
/// # Errors
/// [`CapacityError`] if `table` has fewer rows than [`survey_bound`].
///
/// # Panics
/// As [`refit_with`](super::refit_with).
///
/// # Complexity
/// O(triangles).
pub fn survey(
    mesh: Mesh<'_>,
    nodes: &mut [Node],
    order: &[u32],
    table: &mut [Below],
    join: &Join<'_>,
) -> Result<f32, CapacityError> {
    CapacityError::check("table", survey_bound(nodes.len()), table.len())?;
    Ok(Pass { mesh, order, moved: None, join }.whole(nodes, table))
}

/// [`refit_with`](super::refit_with) of a tree that fitted before some vertices have moved: looks only at
/// what is near these, and leaves the same boxes.
///
/// `table` is that of [`survey`], brought up to date by each call since; `moved` that of
/// [`mark_moved`](super::mark_moved).
///
/// # Errors
/// [`CapacityError`] if `table` has fewer rows than [`survey_bound`], or `moved` fewer words than
/// [`moved_bound`].
///
/// # Panics
/// As [`refit_with`](super::refit_with).
///
/// # Complexity
/// O(m log n) for m of n vertices if near ones have near indices, O(n) in any case.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{Below, Moved, mark_moved, refit_moved, survey};
/// # use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
/// # use pfront_core::{Mesh, Node};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2], [2, 1, 0]])?;
/// # let (mut nodes, mut order, mut keys) = ([Node::EMPTY; 4], [0; 2], [0; 4]);
/// # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// # morton(mesh, &BuildOptions { leaf_size: 1, ..BuildOptions::default() }, storage, &mut keys)?;
/// let one_after_the_other: &pfront_core::bvh::Join = &|a, b| {
///     a();
///     b();
/// };
/// let mut table = [Below::default(); 1];
/// survey(mesh, &mut nodes, &order, &mut table, one_after_the_other)?;
///
/// let after = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// let mut moved = [Moved::default()];
/// assert_eq!(mark_moved(&points, &after, &mut moved)?, 1);
/// let mesh = mesh.with_positions(&after)?;
/// refit_moved(mesh, &mut nodes, &order, &moved, &mut table, one_after_the_other)?;
/// assert_eq!(nodes[0].max, [1.0, 0.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refit_moved(
    mesh: Mesh<'_>,
    nodes: &mut [Node],
    order: &[u32],
    moved: &[Moved],
    table: &mut [Below],
    join: &Join<'_>,
) -> Result<f32, CapacityError> {
    CapacityError::check("table", survey_bound(nodes.len()), table.len())?;
    CapacityError::check("moved", moved_bound(mesh.positions().len()), moved.len())?;
    Ok(Pass { mesh, order, moved: Some(moved), join }.whole(nodes, table))
}

struct Pass<'p> {
    mesh: Mesh<'p>,
    order: &'p [u32],
    /// Or everything.
    moved: Option<&'p [Moved]>,
    join: &'p Join<'p>,
}

impl Pass<'_> {
    fn whole(&self, nodes: &mut [Node], table: &mut [Below]) -> f32 {
        let Some((root, rest)) = nodes.split_first_mut() else { return 0.0 };
        // Slot 1 is no node.
        let below = rest.get_mut(1..).unwrap_or_default();
        if !root.is_leaf() {
            self.pair(below, table, 2);
        }
        self.node(root, below, table).areas.quality(&root.aabb())
    }

    /// Fits two siblings and all that lies below them, which is the rest of the run; `base` is the index of
    /// the first. Returns whether anything there has moved.
    fn pair(&self, run: &mut [Node], table: &mut [Below], base: usize) -> bool {
        let ([left, right, below @ ..], [row, table @ ..]) = (run, table) else { return false };
        if self.moved.is_some_and(|moved| !holds_any(moved, row.range)) {
            return false;
        }
        // What lies below the left one comes first; below a leaf lies nothing.
        let base = base + 2;
        let middle = if right.is_leaf() { below.len() } else { right.first as usize - base };
        let long = below.len() > PART;
        let (below_left, below_right) = split(below, middle);
        let (table_left, table_right) = split(table, middle / 2);
        let (mut in_left, mut in_right) = (false, false);
        let mut fit_left = || in_left = self.has_moved(left, below_left, table_left, base);
        let mut fit_right =
            || in_right = self.has_moved(right, below_right, table_right, base + middle);
        if long {
            (self.join)(&mut fit_left, &mut fit_right);
        } else {
            fit_left();
            fit_right();
        }
        if in_left || in_right {
            let left = self.node(left, below_left, table_left);
            *row = left.and(&self.node(right, below_right, table_right));
        }
        in_left || in_right
    }

    /// Whether anything has moved in a node; fits what lies below it.
    fn has_moved(&self, node: &Node, below: &mut [Node], table: &mut [Below], base: usize) -> bool {
        if !node.is_leaf() {
            return self.pair(below, table, base);
        }
        self.moved.is_none_or(|moved| {
            let corners = self.leaf(node).iter().flat_map(|&t| *at(self.mesh.triangles(), t));
            corners.into_iter().any(|vertex| holds(moved, vertex))
        })
    }

    /// Fits a node, after what lies below it.
    fn node(&self, node: &mut Node, below: &[Node], table: &[Below]) -> Below {
        if let ([left, right, ..], [row, ..]) = (below, table)
            && !node.is_leaf()
        {
            let mut all = *row;
            node.set_aabb(&all.areas.add_inner(left.aabb().union(&right.aabb())));
            return all;
        }
        let triangles = self.leaf(node);
        let mut all = Below { areas: Areas::default(), range: [u32::MAX, 0] };
        node.set_aabb(&all.areas.add_leaf(self.mesh, triangles));
        for vertex in triangles.iter().flat_map(|&t| *at(self.mesh.triangles(), t)) {
            all.range = [all.range[0].min(vertex), all.range[1].max(vertex)];
        }
        all
    }

    fn leaf(&self, node: &Node) -> &[u32] {
        range(self.order, node.first, node.count)
    }
}

impl Below {
    fn and(&self, other: &Self) -> Self {
        Self {
            areas: self.areas.and(&other.areas),
            range: [self.range[0].min(other.range[0]), self.range[1].max(other.range[1])],
        }
    }
}
