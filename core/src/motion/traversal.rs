//! The traversal of two meshes that move, in the order of time: leaves in vector lanes, and pairs of triangles that these leave open one by one.

use super::bvtt::{MovingBvtt, before, first_overlap_of, ordered};
use super::impact::Impact;
use crate::bvh::MAX_DEPTH;
use crate::bvtt::{BEFORE, MovingBlocks, MovingGroup, NodePair, TrianglePair, Work};
use crate::simd::{LANES, Simd, Task};
use core::ops::ControlFlow;

/// The visitor of pairs that meet: it breaks, or goes on with those that meet no later than a time.
pub(super) type Visitor<'v> = dyn FnMut(TrianglePair, Impact) -> ControlFlow<(), f64> + 'v;

/// The most pending node pairs. A step pops one and pushes at most four, each deeper in at least one tree unless it is a leaf there: a path
/// downwards has at most `MAX_DEPTH` steps.
const STACK: usize = 3 * MAX_DEPTH + 1;

/// The arguments of a traversal, as a [`Task`] that is compiled for each width of lanes.
pub(super) struct MovingTraversal<'t, 'v, 'a, const SELF: bool> {
    pub(super) query: &'t MovingBvtt<'a, SELF>,
    pub(super) n: NodePair,
    pub(super) work: &'t mut Work,
    pub(super) limit: f64,
    /// The tests from which on node pairs are left.
    pub(super) budget: u64,
    pub(super) leave: &'t mut dyn FnMut(NodePair, f64),
    pub(super) visit: &'t mut Visitor<'v>,
}

impl<const SELF: bool> Task for MovingTraversal<'_, '_, '_, SELF> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> ControlFlow<()> {
        let (mut stack, mut len) = ([(self.n, 0.0); STACK], 1);
        let mut blocks = [MovingBlocks::new(), MovingBlocks::new()];
        let mut group = MovingGroup::new(self.query.start.reach().unwrap_or_default());
        while len > 0 {
            len -= 1;
            let (n, time) = stack[len];
            if before(time) > self.limit {
                continue;
            }
            if self.work.tests() >= self.budget {
                (self.leave)(n, before(time));
                continue;
            }
            let first = len;
            let tests = self.query.descend(n, |child, time| {
                let mut at = len;
                stack[at] = (child, time);
                len += 1;
                while at > first && stack[at - 1].1 < time {
                    stack.swap(at - 1, at);
                    at -= 1;
                }
            });
            self.work.box_tests += u64::from(tests);
            if tests == 0 {
                self.visit_leaf_pair::<S>(n, &mut blocks, &mut group)?;
            }
        }
        self.visit_group(&mut group)
    }
}

impl<const SELF: bool> MovingTraversal<'_, '_, '_, SELF> {
    /// Visits the pairs of triangles of two leaves, or leaves them to the group.
    #[inline(always)]
    fn visit_leaf_pair<S: Simd>(
        &mut self,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [MovingBlocks; 2],
        group: &mut MovingGroup,
    ) -> ControlFlow<()> {
        let MovingBvtt { start, end } = self.query;
        let a = blocks_a.get::<S, SELF>(n.a, 0, [start, end]);
        let b = blocks_b.get::<S, SELF>(n.b, 1, [start, end]);
        let allowed = if SELF && n.a == n.b { BEFORE } else { u64::MAX };
        let (growth, distance) = (self.query.growth(), self.query.distance_of_lanes());
        let pairs = a.cull::<S, SELF>(b, allowed, start.adjacency(), growth, distance);
        self.work.triangle_tests += u64::from(pairs.overlapping.count_ones());
        let alone = if distance.is_none() { pairs.open } else { pairs.may_share_vertex };
        let (mut left, mut rest) = (pairs.hits | alone, pairs.open & !alone);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let pair = a.pair(b, [bit, bit / LANES]);
            if pairs.hits >> bit & 1 != 0 {
                self.take(ordered::<SELF>(pair), Impact { from: 0.0, to: 0.0 })?;
            } else {
                self.decide(pair)?;
            }
        }
        while rest != 0 {
            rest = group.gather(a, b, rest);
            if group.is_full() {
                self.visit_group(group)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits the gathered pairs.
    #[inline(never)]
    fn visit_group(&mut self, group: &mut MovingGroup) -> ControlFlow<()> {
        let (pairs, mut left) = group.flush();
        while left != 0 {
            self.decide(pairs[left.trailing_zeros() as usize % LANES])?;
            left &= left - 1;
        }
        ControlFlow::Continue(())
    }

    /// Visits two triangles if they meet no later than the limit.
    #[inline(never)]
    fn decide(&mut self, pair: TrianglePair) -> ControlFlow<()> {
        let pair = ordered::<SELF>(pair);
        let sides = self.query.leaves(pair);
        let sides = sides.each_ref();
        let first = first_overlap_of(sides).filter(|&first| before(first) <= self.limit);
        match first.and_then(|first| self.query.impact_of(pair, sides, first)) {
            Some(impact) => self.take(pair, impact),
            None => ControlFlow::Continue(()),
        }
    }

    fn take(&mut self, pair: TrianglePair, impact: Impact) -> ControlFlow<()> {
        self.limit = match (self.visit)(pair, impact) {
            ControlFlow::Continue(limit) => limit,
            ControlFlow::Break(()) => return ControlFlow::Break(()),
        };
        ControlFlow::Continue(())
    }
}
