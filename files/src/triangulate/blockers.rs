//! Points of the plane in a k-d tree, from which they are removed: which of them lie in a triangle?

use robust::{Coord, orient2d};
use std::cell::Cell;

/// A leaf has no more points.
const LEAF: usize = 8;
const NONE: u32 = u32::MAX;

pub(crate) type Point = [f64; 2];

/// The sign of the area of a triangle, exactly.
pub(crate) fn area(a: Point, b: Point, c: Point) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

/// Points that are numbered.
#[derive(Debug, Default)]
pub(crate) struct Blockers {
    points: Vec<(u32, Point)>,
    nodes: Vec<Node>,
    /// The leaf of each number, or `NONE`.
    leaves: Vec<u32>,
    /// How many points all questions have looked at.
    looked_at: Cell<usize>,
}

#[derive(Debug)]
struct Node {
    min: Point,
    max: Point,
    parent: u32,
    /// The left child is the next node. `NONE` in a leaf.
    right: u32,
    begin: u32,
    end: u32,
    /// How many points were not removed.
    left: u32,
}

impl Blockers {
    /// The tree of some of the points.
    pub(crate) fn new(points: &[Point], numbers: Vec<u32>) -> Self {
        let numbered = numbers.into_iter().map(|number| (number, points[number as usize]));
        let mut tree = Self { points: numbered.collect(), ..Self::default() };
        if !tree.points.is_empty() {
            tree.leaves = vec![NONE; points.len()];
            tree.build(0, tree.points.len(), NONE);
        }
        tree
    }

    fn build(&mut self, begin: usize, end: usize, parent: u32) {
        let number = self.nodes.len() as u32;
        let part = &mut self.points[begin..end];
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (_, point) in &*part {
            min = [0, 1].map(|k| point[k].min(min[k]));
            max = [0, 1].map(|k| point[k].max(max[k]));
        }
        let [begin_at, end_at] = [begin, end].map(|place| place as u32);
        let left = end_at - begin_at;
        self.nodes.push(Node { min, max, parent, right: NONE, begin: begin_at, end: end_at, left });
        if part.len() <= LEAF {
            for (corner, _) in part {
                self.leaves[*corner as usize] = number;
            }
            return;
        }
        let axis = usize::from(max[1] - min[1] > max[0] - min[0]);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |(_, a), (_, b)| a[axis].total_cmp(&b[axis]));
        self.build(begin, begin + middle, number);
        self.nodes[number as usize].right = self.nodes.len() as u32;
        self.build(begin + middle, end, number);
    }

    /// Removes a point, if it is there.
    pub(crate) fn remove(&mut self, number: u32) {
        let Some(leaf) = self.leaves.get_mut(number as usize) else { return };
        let mut node = std::mem::replace(leaf, NONE);
        while let Some(Node { left, parent, .. }) = self.nodes.get_mut(node as usize) {
            *left -= 1;
            node = *parent;
        }
    }

    /// How many points all questions have looked at.
    pub(crate) fn looked_at(&self) -> usize {
        self.looked_at.get()
    }

    /// Whether some point in a triangle that turns left, its edges included, satisfies a condition.
    pub(crate) fn any_in(&self, triangle: [Point; 3], condition: impl Fn(u32) -> bool) -> bool {
        let [a, b, c] = triangle;
        let edges = [[a, b], [b, c], [c, a]];
        let mut at = 0;
        // Depth first; what is skipped ends where the next subtree begins.
        let mut pending = Vec::new();
        loop {
            if let Some(node) = self.nodes.get(at).filter(|node| node.left > 0)
                && edges.iter().all(|&edge| node.reaches(edge))
            {
                if node.right != NONE {
                    pending.push(node.right as usize);
                    at += 1;
                    continue;
                }
                let part = &self.points[node.begin as usize..node.end as usize];
                self.looked_at.set(self.looked_at.get() + part.len());
                let is_in = |&(number, point): &(u32, Point)| {
                    self.leaves[number as usize] != NONE
                        && edges.iter().all(|&[from, to]| area(from, to, point) >= 0.0)
                        && condition(number)
                };
                if part.iter().any(is_in) {
                    return true;
                }
            }
            match pending.pop() {
                Some(next) => at = next,
                None => return false,
            }
        }
    }
}

impl Node {
    /// Whether some of the box lies left of an edge, or on it.
    fn reaches(&self, [from, to]: [Point; 2]) -> bool {
        let x = if to[1] > from[1] { self.min[0] } else { self.max[0] };
        let y = if to[0] > from[0] { self.max[1] } else { self.min[1] };
        area(from, to, [x, y]) >= 0.0
    }
}
