//! The verbs of a query over borrowed meshes, in memory that the caller already has.

use super::traversal::traverse;
use super::{Bvtt, Cursor, NodePair, TrianglePair};
use crate::triangle::{Contact, contact, contact_of};
use crate::{Aabb, Bvh};
use core::ops::{ControlFlow, Range};

/// The questions of an estimate of costs.
pub(crate) trait Estimated {
    /// The boxes of both nodes in one frame: that of the query, or of the first mesh.
    fn boxes(&self, n: NodePair) -> [Aabb; 2];

    /// The number of triangles below each node.
    ///
    /// # Complexity
    /// O(depth).
    fn triangles_below(&self, n: NodePair) -> [u32; 2];

    /// The edge of a leaf's box, roughly. The extent of an overlap that is smaller than this says nothing of its cost.
    fn leaf_edge(&self) -> f32;
}

/// A query about two meshes, or about one: its BVTT, of which a [front](crate::front) is a cut, and its verbs.
///
/// # Panics
/// Methods may panic if a node pair is not one of this tree.
#[expect(private_bounds, reason = "sealed: what an estimate asks is internal")]
pub trait Query: Estimated {
    /// The root of the BVTT, if its boxes overlap.
    fn root(&self) -> Option<NodePair>;

    /// Passes on the children of a node that overlap, at most four and in ascending order, each with the boxes of both of its
    /// nodes in one frame: that of the query, or of the first mesh. Returns the number of box tests: 0 for a leaf pair, which has no children.
    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32;

    /// A cursor before the first triangle pair.
    #[inline]
    fn start(&self) -> Cursor {
        Cursor::at(self.root())
    }

    /// Goes on from `cursor`, calling `visit` for each intersecting triangle pair, until it breaks or
    /// all have been visited. The pair at which it broke counts as visited.
    ///
    /// The order is fixed for given BVHs, and otherwise arbitrary.
    ///
    /// # Complexity
    /// Up to 16 box tests per step of two levels of the BVTT and one triangle test per pair of overlapping
    /// triangle boxes; no allocation, no recursion, below 29 KiB of stack, or 46 KiB in f64;
    /// within a distance 48 KiB, or 56 KiB in f64.
    fn visit(
        &self,
        cursor: &mut Cursor,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.step(cursor, u64::MAX, visit)
    }

    /// [`Query::visit`] for at most about `budget` tests, to spread a query over frames: stops when as
    /// many box and triangle tests are done, as [`Cursor::work`] counts them, and goes on from there with
    /// the next call. Pairs and their order are the same for every sequence of budgets; a budget
    /// of 0 does nothing.
    ///
    /// `Break` if `visit` broke, else [`Cursor::is_done`] tells whether anything is left. A `visit` that
    /// breaks when a page is full, or at the first pair, does in steps what [`Query::page`] and
    /// [`Query::any`] do.
    ///
    /// # Complexity
    /// At most `budget` + 16 tests: box tests come up to 16 at a time, triangle tests one by one. A leaf
    /// pair without triangle tests counts as one test against the budget, so at most `budget` of
    /// them are visited. Each loads at most 16 triangles, again if the last step ended inside it.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvtt::*;
    /// # use std::ops::ControlFlow;
    /// # fn frames(query: &impl Query) -> u64 {
    /// let (mut cursor, mut pairs) = (query.start(), 0);
    /// while !cursor.is_done() {
    ///     // One frame.
    ///     let _ = query.step(&mut cursor, 1_000, |_| {
    ///         pairs += 1;
    ///         ControlFlow::Continue(())
    ///     });
    /// }
    /// # pairs }
    /// ```
    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// The segment in which two triangles intersect, in the frame of the query; `None` if they do not. In a self query,
    /// it includes what neighbours share. If nothing is in f64, f32 holds all its coordinates.
    ///
    /// # Panics
    /// If an index is out of range.
    fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>>;

    /// [`Query::contact_f64`], rounded to f32.
    ///
    /// # Panics
    /// If an index is out of range.
    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        self.contact_f64(pair).map(Contact::from)
    }

    /// Goes on from `cursor` into `out` and returns how many pairs it wrote. It stops when `out` is
    /// full or nothing is left: nothing is ever dropped, and when [`Cursor::is_done`] all pages
    /// together are the whole answer. Only the last page may be empty, if `out` is not.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvtt::*;
    /// # fn pages(query: &impl Query) -> usize {
    /// let mut page = [TrianglePair::default(); 16];
    /// let mut cursor = query.start();
    /// let mut total = 0;
    /// while !cursor.is_done() {
    ///     let n = query.page(&mut cursor, &mut page);
    ///     total += page[..n].len();
    /// }
    /// # total }
    /// ```
    fn page(&self, cursor: &mut Cursor, out: &mut [TrianglePair]) -> usize {
        let capacity = out.len();
        if capacity == 0 {
            return 0;
        }
        let mut free = out.iter_mut();
        // The cursor tells whether the visit broke or ended.
        let _ = self.visit(cursor, |pair| {
            if let Some(slot) = free.next() {
                *slot = pair;
            }
            if free.len() == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        capacity - free.len()
    }

    /// The number of intersecting pairs.
    fn count(&self) -> u64 {
        let mut count = 0;
        let _ = self.visit(&mut self.start(), |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Some intersecting pair, if there is one; the traversal stops at the first.
    fn any(&self) -> Option<TrianglePair> {
        let mut found = None;
        let _ = self.visit(&mut self.start(), |pair| {
            found = Some(pair);
            ControlFlow::Break(())
        });
        found
    }
}

impl<const SELF: bool> Estimated for Bvtt<'_, SELF> {
    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        self.bounds(n).map(Aabb::from)
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        [self.a.bvh.triangles_below(n.a), self.b.bvh.triangles_below(n.b)]
    }

    fn leaf_edge(&self) -> f32 {
        self.leaf_edge
    }
}

impl<const SELF: bool> Bvtt<'_, SELF> {
    /// Visits all pairs of children of both nodes, or of children of one and the other, which is a leaf; none of two leaves.
    #[inline(always)]
    pub(crate) fn each_child(&self, n: NodePair, mut visit: impl FnMut(NodePair)) {
        let (of_a, of_b) = (children(&self.a.bvh, n.a), children(&self.b.bvh, n.b));
        if of_a.len() + of_b.len() == 2 {
            return;
        }
        for a in of_a {
            for b in of_b.clone() {
                // (l, r) and (r, l) are the same pair.
                if !SELF || n.a != n.b || a <= b {
                    visit(NodePair { a, b });
                }
            }
        }
    }
}

impl<const SELF: bool> Query for Bvtt<'_, SELF> {
    fn root(&self) -> Option<NodePair> {
        self.root.filter(|&root| !self.is_in_certified_fan(root))
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        let mut tests = 0;
        self.each_child(n, |child| {
            tests += u32::from(!SELF || child.a != child.b);
            let bounds = self.bounds(child);
            if bounds[0].overlaps(&bounds[1]) && !self.is_in_certified_fan(child) {
                push(child, bounds.map(Aabb::from));
            }
        });
        tests
    }

    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        traverse(self, cursor, budget, &mut visit)
    }

    fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        let Self { a, b, .. } = self;
        match self.error() {
            None => Some(contact(&a.triangle(pair.a), &b.triangle(pair.b))?.into()),
            Some(_) => contact_of(&a.triangle_f64(pair.a), &b.triangle_f64(pair.b)),
        }
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        match self.error() {
            None => contact(&self.a.triangle(pair.a), &self.b.triangle(pair.b)),
            Some(_) => self.contact_f64(pair).map(Contact::from),
        }
    }
}

/// The children of a node, or a leaf itself.
fn children(bvh: &Bvh<'_>, index: u32) -> Range<u32> {
    let node = bvh.node(index);
    if node.is_leaf() { index..index + 1 } else { node.left()..node.left() + 2 }
}

impl<Q: Query> Estimated for &Q {
    fn boxes(&self, n: NodePair) -> [Aabb; 2] {
        Q::boxes(self, n)
    }

    fn triangles_below(&self, n: NodePair) -> [u32; 2] {
        Q::triangles_below(self, n)
    }

    fn leaf_edge(&self) -> f32 {
        Q::leaf_edge(self)
    }
}

impl<Q: Query> Query for &Q {
    fn root(&self) -> Option<NodePair> {
        Q::root(self)
    }

    fn children(&self, n: NodePair, push: &mut dyn FnMut(NodePair, [Aabb; 2])) -> u32 {
        Q::children(self, n, push)
    }

    fn step(
        &self,
        cursor: &mut Cursor,
        budget: u64,
        visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        Q::step(self, cursor, budget, visit)
    }

    fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        Q::contact_f64(self, pair)
    }

    fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        Q::contact(self, pair)
    }
}
