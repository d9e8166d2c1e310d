//! The traversal: one loop for every query and processor.

use super::block::BlockCache;
use super::wide_node::WideNode;
use super::{Bvtt, Cursor, NodePair, TrianglePair};
use crate::simd::{LANES, Simd, Task, VECTORS, widest};
use crate::triangle::{intersects, intersects_in_f64, intersects_in_mesh, within, within_in_f64};
use core::ops::ControlFlow;

/// The visitor of hits. A trait object, so that there is one traversal in machine code per kind of query.
type Visitor<'v> = dyn FnMut(TrianglePair) -> ControlFlow<()> + 'v;

/// Continues from `cursor` until `visit` breaks, `tests` more tests are done or nothing is left.
pub(super) fn traverse<const SELF: bool>(
    query: &Bvtt<'_, SELF>,
    cursor: &mut Cursor,
    tests: u64,
    visit: &mut Visitor<'_>,
) -> ControlFlow<()> {
    if cursor.is_done() || tests == 0 {
        return ControlFlow::Continue(());
    }
    cursor.set_budget(tests);
    match (query.reach(), query.error()) {
        (None, None) => run(Traversal::<SELF, false, false> { query, cursor, visit }),
        (None, Some(_)) => traverse_in_f64(query, cursor, visit),
        (Some(_), _) => traverse_within(query, cursor, visit),
    }
}

/// Runs in the widest lanes. Without vectors several lanes gain nothing over one.
#[inline(always)]
fn run<T: Task>(task: T) -> T::Output {
    if VECTORS { widest(task) } else { task.run::<f32>() }
}

/// Apart, so that the other traversal does not take the stack of this one.
#[inline(never)]
fn traverse_in_f64<const SELF: bool>(
    query: &Bvtt<'_, SELF>,
    cursor: &mut Cursor,
    visit: &mut Visitor<'_>,
) -> ControlFlow<()> {
    run(Traversal::<SELF, true, false> { query, cursor, visit })
}

/// Apart for the same reason.
#[inline(never)]
fn traverse_within<const SELF: bool>(
    query: &Bvtt<'_, SELF>,
    cursor: &mut Cursor,
    visit: &mut Visitor<'_>,
) -> ControlFlow<()> {
    run(Traversal::<SELF, true, true> { query, cursor, visit })
}

/// The arguments of a traversal, as a [`Task`] that is compiled for each width of lanes; without `F64`, nothing is in f64, and
/// with `WITHIN`, hits are within a distance.
struct Traversal<'t, 'v, 'a, const SELF: bool, const F64: bool, const WITHIN: bool> {
    query: &'t Bvtt<'a, SELF>,
    cursor: &'t mut Cursor,
    visit: &'t mut Visitor<'v>,
}

impl<const SELF: bool, const F64: bool, const WITHIN: bool> Task
    for Traversal<'_, '_, '_, SELF, F64, WITHIN>
{
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let Self { query, cursor, visit } = self;
        let mut blocks = [BlockCache::new(), BlockCache::new()];
        while let Some(n) = cursor.pop() {
            if query.is_apart(n, cursor) {
                // As the second mesh sees it.
            } else if query.is_in_certified_fan(n) {
                cursor.spend_box_tests(1);
            } else if query.is_leaf_pair(n) {
                let flow = query.visit_leaf_pair::<S, F64, WITHIN>(n, &mut blocks, cursor, visit);
                if cursor.is_inside_leaf_pair() {
                    cursor.push(n);
                }
                flow?;
            } else {
                let tests = query.descend::<WITHIN>(n, |below| cursor.push(below));
                cursor.spend_box_tests(tests);
            }
            if cursor.is_budget_spent() {
                break;
            }
        }
        ControlFlow::Continue(())
    }
}

/// The triangle pairs of a leaf with itself, each once: for triangle j, in byte j, bits i < j (see [`super::cull`]).
pub(crate) const BEFORE: u64 = 0x7f3f_1f0f_0703_0100;

impl<const SELF: bool> Bvtt<'_, SELF> {
    /// Whether the boxes of a node pair, which overlap in the frame in which all boxes are compared, are apart in that of
    /// the second mesh.
    #[inline(always)]
    fn is_apart(&self, n: NodePair, cursor: &mut Cursor) -> bool {
        let Some(first_seen) = &self.first_seen else { return false };
        // A leaf pair that is taken up again has passed this test.
        if !VECTORS || cursor.is_inside_leaf_pair() {
            return false;
        }
        cursor.spend_box_tests(1);
        let (a, b) = (&self.a.bvh, &self.b.bvh);
        !first_seen.bounds(&a.node(n.a).bounds()).overlaps(&b.node(n.b).bounds())
    }

    #[inline]
    pub(super) fn is_leaf_pair(&self, n: NodePair) -> bool {
        self.a.bvh.node(n.a).is_leaf() && self.b.bvh.node(n.b).is_leaf()
    }

    /// Passes on the overlapping pairs two levels below `n`. Returns the number of box tests.
    #[inline(always)]
    fn descend<const WITHIN: bool>(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32 {
        let [pose_a, pose_b] = &self.box_poses;
        let a = WideNode::grandchildren(&self.a.bvh, n.a, pose_a.as_ref());
        if SELF && n.a == n.b && !WITHIN {
            return a.overlapping::<true>(&a, push);
        }
        let b = WideNode::grandchildren(&self.b.bvh, n.b, pose_b.as_ref());
        if SELF && n.a == n.b {
            return a.overlapping::<true>(&b, push);
        }
        a.overlapping::<false>(&b, push)
    }

    /// Visits the triangle pairs of a leaf pair that intersect, from where `cursor` resumes until its budget is spent.
    #[inline(always)]
    fn visit_leaf_pair<S: Simd, const F64: bool, const WITHIN: bool>(
        &self,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [BlockCache; 2],
        cursor: &mut Cursor,
        visit: &mut Visitor<'_>,
    ) -> ControlFlow<()> {
        let shared = self.shared();
        let a = blocks_a.get::<S, SELF>(n.a, &self.a, shared);
        let b = blocks_b.get::<S, SELF>(n.b, &self.b, shared);
        let mut allowed = cursor.bits_left();
        if SELF && n.a == n.b {
            allowed &= BEFORE;
        }
        let error = if F64 { self.error() } else { None };
        let distance = if WITHIN { self.reach() } else { None };
        let (mesh, boxes_only) = (self.a.bvh.mesh(), self.boxes_only);
        let pairs = match distance {
            None => a.cull::<S, SELF>(b, allowed, boxes_only, error),
            Some(distance) => a.near::<S, SELF>(b, allowed, mesh, distance, boxes_only, error),
        };
        let visited = pairs.hits | pairs.open;
        cursor.for_each_within_budget(pairs.overlapping, visited, |bit| {
            let (i, j) = (bit as usize % LANES, bit as usize / LANES % LANES);
            let mut pair = TrianglePair { a: a.triangles[i], b: b.triangles[j] };
            if SELF && pair.a > pair.b {
                pair = TrianglePair { a: pair.b, b: pair.a };
            }
            let is_hit = if pairs.hits >> bit & 1 != 0 || SELF && self.boxes_only {
                true
            } else if SELF && pairs.may_share_vertex >> bit & 1 != 0 {
                intersects_in_mesh(mesh, pair.a, pair.b, self.adjacency)
            } else if error.is_some() {
                let [a, b] = [self.a.triangle_f64(pair.a), self.b.triangle_f64(pair.b)];
                distance.map_or_else(|| intersects_in_f64(&a, &b), |d| within_in_f64(&a, &b, d))
            } else {
                let [a, b] = [a.triangle(i), b.triangle(j)];
                distance.map_or_else(|| intersects(&a, &b), |d| within(&a, &b, d))
            };
            if is_hit { visit(pair) } else { ControlFlow::Continue(()) }
        })
    }
}
