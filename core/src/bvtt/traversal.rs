//! The traversal: one loop for every query, layout and processor.

use super::{Bvtt, Cursor, NodePair, TrianglePair, block::BlockCache, cursor::Budget};
use crate::simd::{Eight, Simd, Task, VECTORS, widest};
use core::ops::ControlFlow;

/// The visitor of hits. A trait object, so that there is one traversal in machine code per kind of tree.
pub(super) type Visitor<'v> = dyn FnMut(TrianglePair) -> ControlFlow<()> + 'v;

/// The questions that the traversal asks of a BVTT.
pub(super) trait Traverse: Bvtt {
    /// Whether both nodes are leaves.
    fn is_leaf_pair(&self, n: NodePair) -> bool;

    /// Passes on the overlapping pairs two levels below, see [`super::WideNode`]. Returns the number of box tests.
    fn descend(&self, n: NodePair, push: impl FnMut(NodePair)) -> u32;

    /// Visits the triangle pairs of a leaf pair that meet, from where `budget` resumes until it is used up.
    fn visit_leaf_pair<S: Simd>(
        &self,
        n: NodePair,
        blocks: &mut [BlockCache; 2],
        budget: &mut Budget,
        visit: &mut Visitor<'_>,
    ) -> ControlFlow<()>;
}

/// The arguments of a traversal, as a [`Task`] that is compiled for each width of lanes.
struct Traversal<'t, 'v, T> {
    tree: &'t T,
    cursor: &'t mut Cursor,
    visit: &'t mut Visitor<'v>,
}

impl<T: Traverse> Traversal<'_, '_, T> {
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let Self { tree, cursor, visit } = self;
        let mut blocks = [BlockCache::new(), BlockCache::new()];
        while let Some(n) = cursor.pop() {
            if tree.is_leaf_pair(n) {
                let flow = tree.visit_leaf_pair::<S>(n, &mut blocks, &mut cursor.budget, visit);
                if cursor.budget.is_inside_leaf_pair() {
                    cursor.push(n);
                }
                flow?;
            } else {
                let tests = tree.descend(n, |below| cursor.push(below));
                cursor.budget.spend_box_tests(tests);
            }
            if cursor.budget.is_spent() {
                break;
            }
        }
        ControlFlow::Continue(())
    }
}

impl<T: Traverse> Task for Traversal<'_, '_, T> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Eight>(self) -> ControlFlow<()> {
        Traversal::run::<S>(self)
    }
}

/// Continues from `cursor` until `visit` breaks, `tests` more tests are done or nothing is left.
pub(super) fn traverse<T: Traverse>(
    tree: &T,
    cursor: &mut Cursor,
    tests: u64,
    visit: &mut Visitor<'_>,
) -> ControlFlow<()> {
    if cursor.is_done() || tests == 0 {
        return ControlFlow::Continue(());
    }
    cursor.budget.refill(tests);
    let traversal = Traversal { tree, cursor, visit };
    if VECTORS { widest(traversal) } else { traversal.run::<f32>() }
}
