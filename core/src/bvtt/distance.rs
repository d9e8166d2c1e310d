//! The smallest distance of two meshes: branch and bound over the BVTT, nearest node pairs first.
//!
//! # What decides
//! Each triangle pair has a length, that of [`nearest`]: by a fixed sequence of operations, at least its distance, but for the
//! error m. The answer is the pair with the least length, the first of those that have the same. A node pair or triangle pair is
//! left out only if its distance is certainly greater than the least length so far and m: so the answer is the same for every
//! order of visits, and however they are divided.
//!
//! # The interval
//! The points of the pair are no farther apart than its length and m: that is the upper end. The lower end is an f32 below the
//! length, by more than all errors. Every pair that is visited proves that it is beyond the lower end that there would be at that
//! moment, by the line through its points or else by integers. If it is not, the greatest f32 that it is beyond is found, and is
//! the lower end if no other is less. A pair that is not beyond the last lower end is never left out, so that this one is the
//! same for every order too. If a pair intersects, the distance is 0, and which of those that intersect is told depends on the order.

use super::block::BlockCache;
use super::cursor::STACK;
use super::near::farthest_square;
use super::posed_bvh::posed;
use super::wide_node::WideNode;
use super::{NodePair, PairBvtt, Query, TrianglePair};
use crate::Distance;
use crate::simd::{LANES, Simd, Task, VECTORS, widest};
use crate::triangle::{Nearest, UNDERFLOW, nearest, within, within_in_f64};

/// The smallest distance of two meshes, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The least and the greatest that the distance can be, in the units of the query. The greatest is 0 only if triangles
    /// intersect; the least is 0 then, and where they are nearer than an f32 can tell. They differ by some 2^-23 of the distance and
    /// 2^-44 of the extent of both meshes, unless two triangles are so nearly in parallel that their near points are not the nearest.
    pub interval: [f64; 2],
    /// The nearest triangles by their near points as they are computed, the first of those that are equally near. If triangles
    /// intersect, two that do.
    pub pair: TrianglePair,
    /// The nearest points of both, in the frame of the query; rounded. If triangles intersect, a point of both.
    pub points: [[f64; 3]; 2],
}

/// The progress of a search for the smallest distance of two meshes: start one with [`PairBvtt::search`], and pass it to
/// [`PairBvtt::seek`] until [`Search::is_done`].
///
/// It takes 6 KiB and allocates nothing. Use it with the query that made it.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Node pairs that are left, the next one last, and the squares of the distances of their boxes.
    stack: [(NodePair, f32); STACK],
    len: usize,
    found: Found,
}

/// The findings of a search.
#[derive(Clone, Copy, Debug)]
struct Found {
    /// Pairs farther apart than this are none of the answer.
    at_most: Option<f32>,
    /// The error of a length.
    error: f64,
    best: Option<Best>,
    /// The least lower end of pairs that have one of their own.
    low: f32,
    /// All that is certainly farther is left out; less than 0 if triangles intersect, so that nothing more is to be found.
    reach: f32,
}

/// The pair with the least length so far; below 0 if its triangles intersect, so that it comes before all others.
#[derive(Clone, Copy, Debug)]
struct Best {
    length: f64,
    pair: TrianglePair,
    points: [[f64; 3]; 2],
}

impl PairBvtt<'_> {
    /// The smallest distance of the two meshes in the frame of the query, if it is not greater than `at_most`, exactly; `None` also
    /// if one has no triangles. The distance of [`PairBvtt::within`] does not matter.
    ///
    /// A `seed` is tried first, and does not change the answer, unless that is 0: with the nearest pair of an earlier frame the
    /// search takes less time. A seed that is out of range is ignored.
    ///
    /// # Complexity
    /// No allocation, no recursion; below 40 KiB of stack, or 64 KiB in f64. Node pairs whose boxes are nearer than the answer are
    /// visited, so that time grows with the number of triangles that are about equally near.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.0, 0.0, 0.25]))?;
    /// let gap = query.distance(None, None).expect("both have triangles");
    /// assert!(gap.interval[0] < 0.25 && 0.25 < gap.interval[1]);
    /// assert!(gap.interval[1] - gap.interval[0] < 1e-6);
    /// assert_eq!(query.distance(Some(Distance::new(0.2)?), None), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn distance(&self, at_most: Option<Distance>, seed: Option<TrianglePair>) -> Option<Gap> {
        let mut search = self.search(at_most, seed);
        self.seek(&mut search, u64::MAX);
        search.gap()
    }

    /// The beginning of [`PairBvtt::distance`], in which only the seed has been visited.
    #[must_use]
    pub fn search(&self, at_most: Option<Distance>, seed: Option<TrianglePair>) -> Search {
        let (query, at_most) = (self.in_own_frame(), at_most.map(Distance::get));
        let reach = at_most.unwrap_or(f32::INFINITY);
        let found = Found { at_most, error: 0.0, best: None, low: f32::INFINITY, reach };
        let mut search = Search { stack: [(NodePair::ROOT, 0.0); STACK], len: 0, found };
        let [Some(a), Some(b)] = [query.a.bvh.root(), query.b.bvh.root()] else { return search };
        let [pose_a, pose_b] = query.box_poses.each_ref().map(Option::as_ref);
        let both = posed(pose_a, &a.bounds()).union(&posed(pose_b, &b.bounds()));
        // Twice 64 · 2^-53 of the extent, for roundings that are small beside it, and what underflows.
        let extent = (both.max.as_dvec3() - both.min.as_dvec3()).max_element();
        search.found.error = extent * TWO_NEG_46 + UNDERFLOW;
        search.push(NodePair::ROOT, 0.0);
        let [len_a, len_b] = [&query.a, &query.b].map(|side| side.bvh.mesh().triangles().len());
        let is_there = |pair: &TrianglePair| (pair.a as usize) < len_a && (pair.b as usize) < len_b;
        if let Some(seed) = seed.filter(is_there) {
            let _ = search.found.visit(&query, seed);
        }
        search
    }

    /// Goes on with a search for about so many tests of boxes and triangles, at least for one step, or until nothing is left.
    /// Returns how many they were.
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvtt::*;
    /// # fn frames(query: &PairBvtt<'_>) -> Option<Gap> {
    /// let mut search = query.search(None, None);
    /// while !search.is_done() {
    ///     query.seek(&mut search, 1_000); // One frame.
    /// }
    /// search.gap()
    /// # }
    /// ```
    pub fn seek(&self, search: &mut Search, budget: u64) -> u64 {
        if search.len == 0 {
            return 0;
        }
        let task = Step { query: &self.in_own_frame(), search, budget };
        if VECTORS { widest(task) } else { task.run::<f32>() }
    }
}

/// 2^-46.
const TWO_NEG_46: f64 = 1.421_085_471_520_200_4e-14;

impl Search {
    /// Whether nothing is left to be visited.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.len == 0
    }

    /// The smallest distance among what has been visited, if there is any: that of the meshes once nothing is left.
    #[must_use]
    pub fn gap(&self) -> Option<Gap> {
        self.found.gap()
    }

    /// All that is certainly farther than this is left out: for a search that is divided, the least of all of its parts. Less than 0
    /// once two triangles intersect.
    #[must_use]
    pub fn reach(&self) -> f32 {
        self.found.reach
    }

    /// Leaves out what is certainly farther than another part of the same search has reached.
    pub fn tighten(&mut self, reach: f32) {
        self.found.reach = self.found.reach.min(reach);
    }

    /// Takes out half of what is left, as a part of the search for another worker: every second node pair, from that on which would be visited last.
    /// `None` if there are not two.
    pub fn take_half(&mut self) -> Option<Self> {
        if self.len < 2 {
            return None;
        }
        let mut other = Self { len: 0, ..*self };
        let mut kept = 0;
        for at in 0..self.len {
            let (n, square) = self.stack[at];
            if at % 2 == 0 {
                other.push(n, square);
            } else {
                self.stack[kept] = (n, square);
                kept += 1;
            }
        }
        self.len = kept;
        Some(other)
    }

    /// Adds what another part of the same search has found, but not what it has left.
    pub fn add(&mut self, other: &Self) {
        other.found.best.into_iter().for_each(|best| self.found.take(best));
        self.found.low = self.found.low.min(other.found.low);
        self.tighten(other.found.reach);
    }

    fn push(&mut self, n: NodePair, square: f32) {
        // There is room by the proof at STACK.
        self.stack[self.len] = (n, square);
        self.len += 1;
    }
}

impl Found {
    fn gap(&self) -> Option<Gap> {
        let Best { length, pair, points } = self.best?;
        if length < 0.0 {
            return Some(Gap { interval: [0.0; 2], pair, points });
        }
        let high = (length + self.error).next_up();
        let high = self.at_most.map_or(high, |at_most| high.min(at_most.into()));
        Some(Gap { interval: [self.low.min(self.below(length)).into(), high], pair, points })
    }

    /// The lower end of the interval for a length.
    fn below(&self, length: f64) -> f32 {
        let low = length - 4.0 * self.error;
        if low > 0.0 { (low as f32).next_down().max(0.0) } else { 0.0 }
    }

    /// Takes note of two triangles. Returns how many exact decisions that took.
    #[inline(never)]
    fn visit(&mut self, query: &PairBvtt<'_>, pair: TrianglePair) -> u64 {
        let [a, b] = query.corners(pair);
        let (Nearest { points, length, apart }, mut decisions) = (nearest(&a, &b), 0);
        if let Some(at_most) = self.at_most {
            let limit = f64::from(at_most);
            let is_within = length + self.error <= limit;
            let is_beyond = apart - 2.0 * self.error > limit;
            decisions += u64::from(!is_within && !is_beyond);
            if is_beyond || !is_within && !query.are_within(pair, at_most) {
                return decisions;
            }
        }
        let least = self.best.map_or(length, |best| best.length.min(length));
        // Below what another pair has shown to be the lower end, none need be shown.
        let low = self.below(least).min(self.low);
        if apart - 2.0 * self.error <= f64::from(low) {
            decisions += 1;
            if query.are_within(pair, 0.0) {
                let segment = query.contact_f64(pair).map(|contact| contact.segment);
                let common = segment.map_or(points[0].to_array(), |[start, _]| start);
                self.take(Best { length: -1.0, pair, points: [common; 2] });
                self.reach = -1.0;
                return decisions;
            }
            if low > 0.0 {
                decisions += 1;
                if query.are_within(pair, low) {
                    self.low = greatest_below(query, pair, low);
                    decisions += u64::from(f32::MANTISSA_DIGITS);
                }
            }
        }
        self.take(Best { length, pair, points: points.map(|p| p.to_array()) });
        decisions
    }

    fn take(&mut self, new: Best) {
        let key = |best: &Best| (best.length, best.pair);
        if self.best.as_ref().is_none_or(|best| key(&new) < key(best)) {
            self.best = Some(new);
            self.reach = self.reach.min(((new.length + self.error) as f32).next_up());
        }
    }
}

/// The greatest f32 below `high` that triangles which do not intersect are beyond.
#[cold]
fn greatest_below(query: &PairBvtt<'_>, pair: TrianglePair, high: f32) -> f32 {
    let (mut beyond, mut within) = (0, high.to_bits());
    while within - beyond > 1 {
        let middle = beyond + (within - beyond) / 2;
        let is_within = query.are_within(pair, f32::from_bits(middle));
        if is_within { within = middle } else { beyond = middle }
    }
    f32::from_bits(beyond)
}

impl PairBvtt<'_> {
    /// Whether two triangles are at most so far apart, exactly.
    #[inline(never)]
    pub(super) fn are_within(&self, pair: TrianglePair, distance: f32) -> bool {
        match self.error() {
            None => within(&self.a.triangle(pair.a), &self.b.triangle(pair.b), distance),
            Some(_) => {
                let [a, b] = self.corners(pair);
                within_in_f64(&a, &b, distance)
            }
        }
    }
}

/// The arguments of a step, as a [`Task`] that is compiled for each width of lanes.
struct Step<'s, 'a> {
    query: &'s PairBvtt<'a>,
    search: &'s mut Search,
    budget: u64,
}

impl Task for Step<'_, '_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self) -> u64 {
        let Self { query, search, budget } = self;
        let (mut blocks, mut spent) = ([BlockCache::new(), BlockCache::new()], 0);
        while let Some(left) = search.len.checked_sub(1) {
            let (n, square) = search.stack[left];
            search.len = left;
            if search.found.reach < 0.0 {
                search.len = 0;
            } else if square > farthest_square(search.found.reach) {
                // It has been left out since.
            } else if query.is_leaf_pair(n) {
                spent += search.found.visit_leaf_pair::<S>(query, n, &mut blocks);
            } else {
                spent += search.descend(query, n);
            }
            if spent >= budget {
                break;
            }
        }
        spent
    }
}

impl Search {
    /// Leaves the pairs two levels below `n` that are near enough, the nearest last. Returns the number of box tests.
    #[inline(always)]
    fn descend(&mut self, query: &PairBvtt<'_>, n: NodePair) -> u64 {
        let PairBvtt { a, b, box_poses: [pose_a, pose_b], .. } = query;
        let a = WideNode::grandchildren(&a.bvh, n.a, pose_a.as_ref());
        let b = WideNode::grandchildren(&b.bvh, n.b, pose_b.as_ref());
        let (first, most) = (self.len, farthest_square(self.found.reach));
        let tests = a.distances(&b, |n, square| {
            // Bounds that are not numbers are at no distance.
            if square <= most || square.is_nan() {
                let mut at = self.len;
                self.push(n, square);
                while at > first && self.stack[at - 1].1 < square {
                    self.stack.swap(at - 1, at);
                    at -= 1;
                }
            }
        });
        u64::from(tests)
    }
}

impl Found {
    /// Visits the triangle pairs of a leaf pair that are near enough. Returns the number of triangle tests.
    #[inline(always)]
    fn visit_leaf_pair<S: Simd>(
        &mut self,
        query: &PairBvtt<'_>,
        n: NodePair,
        [blocks_a, blocks_b]: &mut [BlockCache; 2],
    ) -> u64 {
        let a = blocks_a.get::<S, false>(n.a, &query.a, query.shared());
        let b = blocks_b.get::<S, false>(n.b, &query.b, query.shared());
        if a.is_apart::<S>(b, self.reach, query.error()) {
            return 1;
        }
        let (mesh, mut left, mut tests) = (query.a.bvh.mesh(), u64::MAX, 1);
        while left != 0 && self.reach >= 0.0 {
            let reach = self.reach;
            let pairs = a.near::<S, false>(b, left, mesh, reach, false, query.error());
            tests += u64::from(pairs.overlapping.count_ones());
            left = pairs.hits | pairs.open;
            // A pair that is nearer than all before leaves fewer of the others.
            while left != 0 && self.reach >= reach {
                let bit = left.trailing_zeros() as usize;
                left &= left - 1;
                let (i, j) = (bit % LANES, bit / LANES % LANES);
                tests += self.visit(query, TrianglePair { a: a.triangles[i], b: b.triangles[j] });
            }
        }
        tests
    }
}
