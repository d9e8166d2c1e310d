//! Fans: subtrees of a BVH whose triangles all share a vertex.
//!
//! The boxes of the triangles around one vertex overlap there, so that a self query reaches all pairs of leaves around it.
//! Around a vertex of many triangles these are too many, even if a certificate then rejects all their triangle pairs. So nodes
//! are marked below which all triangles are around one such vertex: if that is certified, a pair of such nodes has no hits.

use super::OneRings;
use super::certified::{Certified, Fans};
use super::ring::{OneRing, SIZE};
use crate::{Bvh, CapacityError, Mesh};

const WORD: usize = u32::BITS as usize;

/// Returns the number of words of [`Certified::with_fans`] for a BVH of so many nodes.
#[must_use]
pub const fn fan_bound(nodes: usize) -> usize {
    nodes.div_ceil(WORD)
}

impl OneRings<'_> {
    /// Whether any one-ring is so large that [`Certified::with_fans`] saves time.
    ///
    /// # Complexity
    /// O(vertices).
    #[must_use]
    pub fn has_fans(&self) -> bool {
        self.rings.iter().any(|ring| ring.is_large())
    }
}

impl<'a> Certified<'a> {
    /// Marks the nodes of a BVH below which all triangles share a vertex of many triangles, so that self queries skip pairs of
    /// them: else these take O(n²) time for n triangles around one vertex. The pairs found are the same.
    ///
    /// The marks depend on the triangles and on the tree but for its boxes. Queries about another BVH do not use them.
    ///
    /// # Errors
    /// [`CapacityError`] if `marks` are fewer words than [`fan_bound`].
    ///
    /// # Complexity
    /// O(triangles + n log n) for n nodes that are marked.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvh::*, bvtt::*, one_ring::*, *};
    /// // A disc of 100 triangles around its centre.
    /// let rim = |i: u32| [(0.06283 * i as f32).cos(), (0.06283 * i as f32).sin(), 0.0];
    /// let points: Vec<_> = std::iter::once([0.0; 3]).chain((0..100).map(rim)).collect();
    /// let triangles: Vec<_> = (0..100).map(|i| [0, 1 + i, 1 + (i + 1) % 100]).collect();
    /// let mesh = Mesh::new(&points, &triangles)?;
    /// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(100)], [0; 100]);
    /// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 200])?;
    /// let (mut history, mut scratch) = ([0; history_bound(101)], [0; link_scratch_bound(101, 100)]);
    /// let mut rings = OneRings::new(101, &triangles, &mut history, &mut scratch)?;
    /// assert!(rings.has_fans());
    /// let mut marks = [0; fan_bound(node_bound(100))];
    /// let certified = rings.certify(mesh, None).with_fans(&bvh, &mut marks)?;
    /// assert!(SelfBvtt::new(bvh).with_certificates(certified).start().is_done());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_fans(self, bvh: &Bvh<'a>, marks: &'a mut [u32]) -> Result<Self, CapacityError> {
        let nodes = bvh.nodes();
        CapacityError::check("marks", fan_bound(nodes.len()), marks.len())?;
        marks.fill(0);
        let hub = |triangle: u32| hub(bvh.mesh(), self.rings, triangle);
        for (index, node) in nodes.iter().enumerate().rev() {
            let is_fan = if node.is_leaf() {
                let (first, rest) = match bvh.leaf_triangles(node) {
                    [first, rest @ ..] => (hub(*first), rest),
                    [] => continue,
                };
                first.is_some() && rest.iter().all(|&triangle| hub(triangle) == first)
            } else {
                // Children come after their parent; the unused slot has none.
                let [left, right] = [node.left(), node.left() + 1];
                left as usize > index
                    && is_marked(marks, left)
                    && is_marked(marks, right)
                    && hub(first_triangle(bvh, left)) == hub(first_triangle(bvh, right))
            };
            marks[index / WORD] |= u32::from(is_fan) << (index % WORD);
        }
        Ok(self.with_fans_unchecked(bvh, marks))
    }

    /// Borrows again the marks that [`Certified::with_fans`] has left for the same triangles and the same tree.
    ///
    /// Nothing is checked: with any others a query may miss pairs.
    #[must_use]
    pub fn with_fans_unchecked(self, bvh: &Bvh<'a>, marks: &'a [u32]) -> Self {
        let fans = Fans { marks, nodes: bvh.nodes().as_ptr().addr(), order: bvh.order() };
        Self { fans, ..self }
    }

    /// The marks of the nodes if they are of the very BVH, else none.
    ///
    /// Both borrow their slices, so slices in the same place hold the same.
    pub(crate) fn fans_of(self, bvh: &Bvh<'_>) -> &'a [u32] {
        let Fans { marks, nodes, order } = self.fans;
        let same = nodes == bvh.nodes().as_ptr().addr() && core::ptr::eq(order, bvh.order());
        if same && !self.of_mesh(bvh.mesh()).is_empty() { marks } else { &[] }
    }
}

/// Whether a node is marked.
#[inline]
pub(crate) fn is_marked(marks: &[u32], node: u32) -> bool {
    marks.get(node as usize / WORD).is_some_and(|word| word >> (node as usize % WORD) & 1 != 0)
}

/// The vertex that all triangles below a marked node share.
pub(crate) fn hub_of(bvh: &Bvh<'_>, rings: &[OneRing], node: u32) -> Option<u32> {
    hub(bvh.mesh(), rings, first_triangle(bvh, node))
}

/// The corner of a triangle whose one-ring is the largest, if it is large.
fn hub(mesh: Mesh<'_>, rings: &[OneRing], triangle: u32) -> Option<u32> {
    let size = |vertex: &u32| rings.get(*vertex as usize).map_or(0, |ring| ring.0 & SIZE);
    mesh.triangles()[triangle as usize].iter().copied().max_by_key(size).filter(|hub| size(hub) > 0)
}

/// The first triangle below a node.
fn first_triangle(bvh: &Bvh<'_>, node: u32) -> u32 {
    let mut node = bvh.node(node);
    while !node.is_leaf() {
        node = bvh.node(node.left());
    }
    bvh.leaf_triangles(node)[0]
}
