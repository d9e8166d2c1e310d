//! Boxes for a deformed mesh, and how good the tree still is.
//!
//! A post-order pass fits each node after its children, and sums up the [`quality()`] on the way.
//!
//! Where few vertices have moved, the pass leaves out what has not: vertices that are near in space mostly have near
//! indices, so that a pair of siblings knows by the smallest and the largest index below it whether anything there can
//! have moved. A row of a table for each pair holds that range, and what the nodes below add to the quality.

use super::quality::Visits;
use crate::bvh::Node;
use crate::index::{at, range, split};
use crate::parallel::{GRAIN, Join, both};
use crate::vertex_set::{Moved, holds_any, moved_bound};
use crate::{Aabb, CapacityError, Mesh};

/// How a tree is refitted.
#[derive(Default)]
pub struct Refit<'r> {
    /// Runs parts of the pass side by side; boxes and quality are the same to the bit. The tree must be one that a
    /// build has made: all that lies below a node is one run of nodes.
    pub join: Option<&'r Join<'r>>,
    /// Filled for later calls with `moved`, unless empty.
    pub table: &'r mut [RefitRow],
    /// The vertices that have moved since the tree fitted and `table` was filled, if they are few.
    pub moved: Option<&'r [Moved]>,
}

/// A row of [`Refit::table`]: a pair of siblings and all below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RefitRow {
    visits: Visits,
    /// The smallest and the largest index of a vertex.
    vertices: [u32; 2],
}

/// How many rows the table of a tree of so many nodes has.
#[must_use]
pub const fn refit_table_bound(nodes: usize) -> usize {
    nodes.saturating_sub(2) / 2
}

/// Fits the boxes of a tree to new positions of its mesh; returns its [`quality()`](super::quality()).
///
/// `nodes` and `order` are those of a BVH of a mesh with the same triangles.
///
/// # Errors
/// [`CapacityError`] if `options.table` has fewer rows than [`refit_table_bound`], unless it is empty and nothing needs
/// it, or `options.moved` fewer words than [`moved_bound`].
///
/// # Panics
/// If `nodes` and `order` are not of such a tree.
///
/// # Complexity
/// O(triangles), in parts of a few thousand if there is a `join`. O(m log n) for m of n vertices that have moved, if near
/// ones have near indices.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{Moved, Refit, RefitRow, mark_moved, refit};
/// # use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
/// # use pfront_core::{Mesh, Node};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2], [2, 1, 0]])?;
/// # let (mut nodes, mut order, mut keys) = ([Node::EMPTY; 4], [0; 2], [0; 4]);
/// # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// # morton(mesh, &BuildOptions { leaf_size: 1, ..BuildOptions::default() }, storage, &mut keys)?;
/// let mut table = [RefitRow::default(); 1];
/// refit(mesh, &mut nodes, &order, Refit { table: &mut table, ..Refit::default() })?;
///
/// let after = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
/// let mut moved = [Moved::default()];
/// assert_eq!(mark_moved(&points, &after, &mut moved)?, 1);
/// let options = Refit { table: &mut table, moved: Some(&moved), join: None };
/// refit(mesh.with_positions(&after)?, &mut nodes, &order, options)?;
/// assert_eq!(nodes[0].max, [1.0, 0.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refit(
    mesh: Mesh<'_>,
    nodes: &mut [Node],
    order: &[u32],
    options: Refit<'_>,
) -> Result<f32, CapacityError> {
    let Refit { join, table, moved } = options;
    if let Some(moved) = moved {
        CapacityError::check("moved", moved_bound(mesh.positions().len()), moved.len())?;
    }
    if moved.is_some() || !table.is_empty() {
        CapacityError::check("table", refit_table_bound(nodes.len()), table.len())?;
    }
    let (root, below) = split(nodes, 2);
    let [root, ..] = root else { return Ok(0.0) };
    let ranged = !table.is_empty();
    let pass = Pass { mesh, order, join, moved, ranged };
    let fitted = pass.fit(root, below, table, 2);
    root.set_aabb(&fitted.aabb);
    Ok(fitted.row.visits.quality(mesh))
}

struct Pass<'p> {
    mesh: Mesh<'p>,
    order: &'p [u32],
    join: Option<&'p Join<'p>>,
    /// Or everything.
    moved: Option<&'p [Moved]>,
    /// Whether there is a table.
    ranged: bool,
}

struct Fitted {
    aabb: Aabb,
    row: RefitRow,
}

impl Pass<'_> {
    /// Fits what lies below a node: `nodes` from index `base` on, and their rows.
    #[inline(always)]
    fn fit(&self, node: &Node, nodes: &mut [Node], rows: &mut [RefitRow], base: usize) -> Fitted {
        if node.is_leaf() { self.leaf(node) } else { self.inner(node, nodes, rows, base) }
    }

    #[inline(never)]
    fn apart(&self, node: &Node, nodes: &mut [Node], rows: &mut [RefitRow], base: usize) -> Fitted {
        self.fit(node, nodes, rows, base)
    }

    fn inner(&self, node: &Node, nodes: &mut [Node], rows: &mut [RefitRow], base: usize) -> Fitted {
        let left = node.first as usize - base;
        if let Some(moved) = self.moved
            && let Some(row) = rows.get(left / 2)
            && !holds_any(moved, row.vertices)
        {
            return Fitted { aabb: node.aabb(), row: *row };
        }
        let (a, b) = (*at(nodes, left as u32), *at(nodes, left as u32 + 1));
        let (fit_a, fit_b) = if self.join.is_some() && nodes.len() > GRAIN && !b.is_leaf() {
            // What lies below the left one comes first.
            let middle = b.first as usize - base;
            let (nodes_a, nodes_b) = split(nodes, middle);
            let (rows_a, rows_b) = split(rows, middle / 2);
            both(
                self.join,
                || self.apart(&a, nodes_a, rows_a, base),
                || self.apart(&b, nodes_b, rows_b, base + middle),
            )
        } else {
            (self.fit(&a, nodes, rows, base), self.fit(&b, nodes, rows, base))
        };
        let (aabb, row) = (fit_a.aabb.union(&fit_b.aabb), fit_a.row.and(&fit_b.row));
        let row = RefitRow { visits: row.visits.with_node(&aabb, 2, self.mesh), ..row };
        for (node, fitted) in nodes.iter_mut().skip(left).zip([fit_a, fit_b]) {
            node.set_aabb(&fitted.aabb);
        }
        if let Some(slot) = rows.get_mut(left / 2) {
            *slot = row;
        }
        Fitted { aabb, row }
    }

    #[inline(always)]
    fn leaf(&self, node: &Node) -> Fitted {
        let triangles = range(self.order, node.first, node.count);
        let mut vertices = [u32::MAX, 0];
        if self.ranged {
            for &vertex in triangles.iter().flat_map(|&t| at(self.mesh.triangles(), t)) {
                vertices = [vertices[0].min(vertex), vertices[1].max(vertex)];
            }
        }
        let (aabb, visits) = Visits::of_leaf(self.mesh, triangles);
        Fitted { aabb, row: RefitRow { visits, vertices } }
    }
}

impl RefitRow {
    fn and(&self, other: &Self) -> Self {
        let ([a, b], [c, d]) = (self.vertices, other.vertices);
        Self { visits: self.visits.and(&other.visits), vertices: [a.min(c), b.max(d)] }
    }
}
