//! The half-planes around a line along which two meshes meet, sorted by angle, and the classes of points between them.

use crate::exact::Exact;
use crate::exact::orientation::{orient2d, sides};
use crate::scalar::Scalar;
use crate::triangle::{Projection, flat, projection, turn};
use core::cmp::Ordering;

/// The most half-planes of a picture.
const MOST: usize = 32;

/// A triangle at a line, as the half-plane from the line through it.
#[derive(Clone, Copy)]
pub(super) struct HalfPlane<C> {
    /// A point of it beside the line.
    pub(super) point: [C; 3],
    /// Its mesh: 0 or 1.
    pub(super) mesh: usize,
    /// By how much the winding number of the mesh changes across it, walking counter-clockwise around the line as seen against its
    /// direction: −1 from the back of the triangle to its front, 1 the other way.
    pub(super) step: i32,
}

/// The half-planes around a directed line.
pub(super) struct Picture<C> {
    line: [[C; 3]; 2],
    halves: [HalfPlane<C>; MOST],
    len: usize,
}

impl<C: Scalar> Picture<C> {
    pub(super) fn new(line: [[C; 3]; 2]) -> Self {
        let none = HalfPlane { point: line[0], mesh: 0, step: 0 };
        Self { line, halves: [none; MOST], len: 0 }
    }

    /// The number of half-planes.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Whether a segment on the line runs against it.
    pub(super) fn is_against(&self, [from, to]: &[[C; 3]; 2]) -> bool {
        // Lexicographic order is monotone along a line.
        let [p, q] = &self.line;
        (p < q) != (from < to)
    }

    /// Adds a half-plane. Returns whether there was room for it.
    pub(super) fn push(&mut self, half: HalfPlane<C>) -> bool {
        let Some(slot) = self.halves.get_mut(self.len) else { return false };
        *slot = half;
        self.len += 1;
        true
    }

    /// Visits the half-planes in turn, those that coincide as one: with the winding numbers of both meshes in the sector before them,
    /// the meshes that they are of, and the numbers after them. `known` has a half-plane of each mesh, with which no other of the same
    /// mesh coincides, and the number of the mesh after it.
    pub(super) fn visit(
        self,
        known: [(usize, i32); 2],
        mut visit: impl FnMut([i32; 2], [bool; 2], [i32; 2]),
    ) {
        let (mut order, mut quarter) = ([0_u8; MOST], [0_u8; MOST]);
        let Some(seen) = self.reference() else { return };
        for i in 0..self.len {
            (order[i], quarter[i]) = (i as u8, self.quarter(&seen, i));
        }
        // Insertion: pictures mostly have four half-planes.
        for i in 1..self.len {
            let mut at = i;
            while at > 0 && self.compare(&quarter, order[at - 1], order[at]) == Ordering::Greater {
                order.swap(at - 1, at);
                at -= 1;
            }
        }
        let order = &order[..self.len];
        let coincide = |x: &u8, y: &u8| self.compare(&quarter, *x, *y) == Ordering::Equal;
        let mut winding = [0; 2];
        let mut offset = [0; 2];
        for sector in order.chunk_by(coincide) {
            for &i in sector {
                let HalfPlane { mesh, step, .. } = self.halves[i as usize];
                winding[mesh] += step;
            }
            for mesh in 0..2 {
                if sector.contains(&(known[mesh].0 as u8)) {
                    offset[mesh] = known[mesh].1 - winding[mesh];
                }
            }
        }
        winding = offset;
        for coinciding in order.chunk_by(coincide) {
            let (before, mut meshes) = (winding, [false; 2]);
            for &i in coinciding {
                let HalfPlane { mesh, step, .. } = self.halves[i as usize];
                winding[mesh] += step;
                meshes[mesh] = true;
            }
            visit(before, meshes, winding);
        }
    }

    /// A projection in which the first half-plane has an area.
    fn reference(&self) -> Option<Projection> {
        let [p, q] = self.line;
        projection::<Exact<C>>(&[p, q, self.halves[0].point]).flatten()
    }

    /// Where a half-plane is, counter-clockwise from the first: 0 with it, 1 before the opposite one, 2 opposite, 3 after.
    fn quarter(&self, seen: &Projection, i: usize) -> u8 {
        let ([p, q], point) = (&self.line, &self.halves[i].point);
        match sides([p, q, &self.halves[0].point], [point]) {
            [1] => 1,
            [-1] => 3,
            _ if turn::<Exact<C>>(&[*p, *q, *point], seen.axis) == Some(seen.turn) => 0,
            _ => 2,
        }
    }

    fn compare(&self, quarter: &[u8; MOST], x: u8, y: u8) -> Ordering {
        let (x, y) = (x as usize, y as usize);
        let of_quarters = quarter[x].cmp(&quarter[y]);
        if of_quarters != Ordering::Equal || quarter[x].is_multiple_of(2) {
            return of_quarters;
        }
        let ([p, q], point) = (&self.line, &self.halves[y].point);
        let [side] = sides([p, q, &self.halves[x].point], [point]);
        0.cmp(&side)
    }
}

/// How a segment in the plane of a triangle meets it, beyond isolated points.
pub(super) enum Run<C> {
    /// It runs through the interior: a corner to the left of it and one to the right, and the turns of both with the segment
    /// compared to that of the triangle.
    Through([([C; 3], bool); 2]),
    /// It runs along the edge from this corner to the next.
    Along(usize),
    /// They have at most isolated points in common.
    Not,
}

/// How the segment from p to q meets a triangle of known projection whose plane it lies in.
pub(super) fn run<C: Scalar>([p, q]: &[[C; 3]; 2], t: &[[C; 3]; 3], seen: &Projection) -> Run<C> {
    let (segment, corners) = (flat(&[*p, *q], seen.axis), flat(t, seen.axis));
    let beside = corners.map(|corner| orient2d(&segment[0], &segment[1], &corner));
    let (mut is_outside, mut along) = (false, None);
    for k in 0..3 {
        let ends = [&corners[k], &corners[(k + 1) % 3]];
        if beside[k] == 0 && beside[(k + 1) % 3] == 0 {
            along = Some(k);
            continue;
        }
        let outside = |point: &[C; 2]| orient2d(ends[0], ends[1], point) * seen.turn <= 0;
        is_outside |= outside(&segment[0]) && outside(&segment[1]);
    }
    if let Some(k) = along {
        let sorted = |p: [C; 3], q: [C; 3]| if p < q { [p, q] } else { [q, p] };
        let ([low, high], [first, last]) = (sorted(*p, *q), sorted(t[k], t[(k + 1) % 3]));
        return if low < last && first < high { Run::Along(k) } else { Run::Not };
    }
    let on = |side: i32| (0..3).find(|&k| beside[k] == side);
    match (on(1), on(-1)) {
        (Some(left), Some(right)) if !is_outside => {
            Run::Through([(t[left], seen.turn > 0), (t[right], seen.turn < 0)])
        }
        _ => Run::Not,
    }
}
