//! Boxes for a deformed mesh, and how good the tree still is.
//!
//! A post-order pass fits each node after its children, and sums up the [`quality()`](super::quality()) on the way.
//!
//! If few vertices have moved, the pass leaves out parts without any: vertices that are near in space mostly have near
//! indices, so that a pair of siblings knows by the smallest and the largest index below it whether anything there can
//! have moved. A row of a table for each pair holds that range, and what the nodes below add to the quality. The pass takes
//! half of its instructions if a fifth of the vertices have moved, and a quarter if a twentieth have (`benches/record/kept.md`).

use super::quality::ExpectedTests;
use crate::Node;
use crate::aabb::Bounds;
use crate::parallel::{FINE, Join, both, split};
use crate::vertex_set::{Moved, holds_any, moved_bound};
use crate::{Aabb, CapacityError, Mesh};

/// How a tree is refitted.
#[derive(Default)]
pub struct Refit<'r> {
    /// Runs parts of the pass side by side; boxes and quality are the same to the bit. The tree must be one that a
    /// build has made: all that lies below a node is one run of nodes.
    pub join: Option<&'r Join<'r>>,
    /// One row for two nodes. Filled for later calls with `moved`, unless empty.
    pub table: &'r mut [RefitRow],
    /// The vertices that have moved since the tree fitted and `table` was filled, if they are few: see
    /// [`mark_moved`](super::mark_moved).
    pub moved: Option<&'r [Moved]>,
}

/// A row of [`Refit::table`]: a pair of siblings and all below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RefitRow {
    visits: ExpectedTests,
    /// The smallest and the largest index of a vertex.
    vertices: [u32; 2],
}

/// Fits the boxes of a tree to new positions of its mesh; returns its [`quality()`](super::quality()).
///
/// `nodes` and `order` are those of a BVH of a mesh with the same triangles.
///
/// # Errors
/// [`CapacityError`] if `options.table` or `options.moved` is too short.
///
/// # Panics
/// If `nodes` and `order` are not of such a tree.
///
/// # Complexity
/// O(triangles), in parts of a few hundred nodes if there is a `join`. O(m log n) for m of n vertices that have moved, if near
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
/// let mut table = [RefitRow::default(); 2];
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
        CapacityError::check("moved", moved_bound(mesh.vertex_count()), moved.len())?;
    }
    if moved.is_some() || !table.is_empty() {
        CapacityError::check("table", nodes.len() / 2, table.len())?;
    }
    let ranged = !table.is_empty();
    let pass = Pass { mesh, order, join, moved, ranged };
    let (root, nodes) = split(nodes, 2);
    let [root, ..] = root else { return Ok(0.0) };
    let row = pass.fit(root, &mut Subtree { nodes, rows: table, base: 2 });
    Ok(row.visits.quality(mesh))
}

struct Pass<'p> {
    mesh: Mesh<'p>,
    order: &'p [u32],
    join: Option<&'p Join<'p>>,
    /// The vertices that have moved; all if `None`.
    moved: Option<&'p [Moved]>,
    /// Whether there is a table.
    ranged: bool,
}

/// The nodes from index `base` on, and the rows of their pairs, if there is a table.
struct Subtree<'p> {
    nodes: &'p mut [Node],
    rows: &'p mut [RefitRow],
    base: usize,
}

impl Pass<'_> {
    /// The box of a node, after what lies below it in `part` is fitted.
    #[inline(always)]
    fn node(&self, node: &Node, part: &mut Subtree<'_>) -> (Aabb, RefitRow) {
        if node.is_leaf() {
            return self.leaf(node);
        }
        let left = node.first as usize - part.base;
        let row = self.pair(part, left);
        let aabb = part.nodes[left].aabb().union(&part.nodes[left + 1].aabb());
        (aabb, RefitRow { visits: row.visits.with_node(&Bounds::new(&aabb), 2, self.mesh), ..row })
    }

    #[inline(never)]
    fn fit(&self, node: &mut Node, part: &mut Subtree<'_>) -> RefitRow {
        let (aabb, row) = self.node(node, part);
        node.set_aabb(&aabb);
        row
    }

    /// Fits the siblings in slots `left` and `left + 1` of `part`.
    fn pair(&self, part: &mut Subtree<'_>, left: usize) -> RefitRow {
        if let (Some(moved), Some(row)) = (self.moved, part.rows.get(left / 2))
            && !holds_any(moved, row.vertices)
        {
            return *row;
        }
        let row = if self.join.is_some() && part.nodes.len() > FINE {
            self.side_by_side(part)
        } else {
            let mut row = RefitRow::NONE;
            for slot in [left, left + 1] {
                let node = part.nodes[slot];
                let (aabb, own) = self.node(&node, part);
                part.nodes[slot].set_aabb(&aabb);
                row = row.and(&own);
            }
            row
        };
        if let Some(place) = part.rows.get_mut(left / 2) {
            *place = row;
        }
        row
    }

    /// Fits the first two nodes of `part`, below which all others lie: first those below the left one.
    // Apart, so that the tasks are not on the stack of every level below.
    #[inline(never)]
    fn side_by_side(&self, part: &mut Subtree<'_>) -> RefitRow {
        let ([left, right, nodes @ ..], base) = (&mut *part.nodes, part.base + 2) else {
            return RefitRow::NONE;
        };
        let middle = if right.is_leaf() { nodes.len() } else { right.first as usize - base };
        let (left_nodes, right_nodes) = split(nodes, middle);
        let (_, rows) = split(part.rows, 1);
        let (left_rows, right_rows) = split(rows, middle / 2);
        let mut below_left = Subtree { nodes: left_nodes, rows: left_rows, base };
        let mut below_right = Subtree { nodes: right_nodes, rows: right_rows, base: base + middle };
        let (left, right) = both(
            self.join,
            || self.fit(left, &mut below_left),
            || self.fit(right, &mut below_right),
        );
        left.and(&right)
    }

    #[inline(always)]
    fn leaf(&self, node: &Node) -> (Aabb, RefitRow) {
        let first = node.first as usize;
        let triangles = &self.order[first..first + node.count as usize];
        let mut vertices = [u32::MAX, 0];
        if self.ranged {
            for &vertex in triangles.iter().flat_map(|&t| &self.mesh.triangles()[t as usize]) {
                vertices = [vertices[0].min(vertex), vertices[1].max(vertex)];
            }
        }
        let (aabb, visits) = ExpectedTests::of_leaf(self.mesh, triangles);
        (aabb, RefitRow { visits, vertices })
    }
}

impl RefitRow {
    const NONE: Self = Self { visits: ExpectedTests::NONE, vertices: [u32::MAX, 0] };

    #[inline(always)]
    fn and(&self, other: &Self) -> Self {
        let ([a, b], [c, d]) = (self.vertices, other.vertices);
        Self { visits: self.visits.and(&other.visits), vertices: [a.min(c), b.max(d)] }
    }
}
