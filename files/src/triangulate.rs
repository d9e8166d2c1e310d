//! Triangulates faces by clipping ears, in rounds: from an ear on, a strip of some ears is clipped to both sides in turn, and
//! corners at its ends wait for the next round. So a convex face of n corners is done after about three rounds of strips of
//! n^(1/3) triangles, in each of which a corner gets a few. A fan, which gives one corner all triangles, makes what asks
//! about neighbours quadratic.
//!
//! A face is projected along the axis that is nearest to its normal (Newell's), which rounds nothing, and every sign is exact. An ear
//! is clipped if no corner that is reflex or straight lies in it; so corners on straight edges stay corners of triangles
//! with an area. A face that has no ear, as it crosses itself or has no area, becomes a fan.

mod blockers;
mod flip;

use blockers::{Blockers, Point, area};
use flip::lower_valence;

/// Bytes for each corner of the face that is triangulated, at most.
pub(crate) const SCRATCH: usize = 160;

/// Faces of more corners are not fans even where these are right.
const SMALL: usize = 8;

/// Ears that may be tried for each corner, and corners looked at for each ear: a bound for faces that are made to be slow.
const TRIES: usize = 64;

/// Triangulates a face, in place of its fan around the first corner. Returns whether that covers the face and nothing else; a face that
/// crosses itself or has no area is left as a fan, or ends in one.
#[must_use]
pub(crate) fn triangulate(corners: &[u32], positions: &[[f64; 3]], fan: &mut [[u32; 3]]) -> bool {
    let Some(points) = projected(corners, positions) else { return false };
    let last = points.len() - 1;
    let is_fan = || {
        let mut edges = points[1..].windows(2);
        edges.all(|edge| area(points[0], edge[0], edge[1]) > 0.0)
            && area(points[0], points[1], points[last]) > 0.0
    };
    if points.len() <= SMALL && is_fan() {
        return true;
    }
    let is_whole = Ring::new(&points).triangulate(fan);
    if is_whole {
        lower_valence(fan, &points);
    }
    for corner in fan.as_flattened_mut() {
        *corner = corners[*corner as usize];
    }
    is_whole
}

/// The corners of a face in the plane, turning left; `None` if the face has no area or a corner is no point.
fn projected(corners: &[u32], positions: &[[f64; 3]]) -> Option<Vec<Point>> {
    let points = corners.iter().map(|&corner| positions.get(corner as usize).copied());
    let points: Vec<[f64; 3]> = points.collect::<Option<_>>()?;
    let from = *points.first()?;
    let from_first = |p: &[f64; 3]| [0, 1, 2].map(|k| p[k] - from[k]);
    let mut normal = [0.0; 3];
    for edge in points.windows(2) {
        let [a, b] = [&edge[0], &edge[1]].map(from_first);
        for (k, component) in normal.iter_mut().enumerate() {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            *component += a[i] * b[j] - a[j] * b[i];
        }
    }
    let nearest = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()))?;
    let length = normal[nearest].abs();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let [mut x, mut y] = [(nearest + 1) % 3, (nearest + 2) % 3];
    if normal[nearest] < 0.0 {
        [x, y] = [y, x];
    }
    Some(points.iter().map(|p| [p[x], p[y]]).collect())
}

/// The part of a face that is left.
struct Ring<'p> {
    points: &'p [Point],
    /// The corners before and after each, and whether it is left.
    links: Vec<[u32; 2]>,
    is_left: Vec<bool>,
    left: usize,
    /// The corners that are not convex.
    blockers: Blockers,
}

impl<'p> Ring<'p> {
    fn new(points: &'p [Point]) -> Self {
        let n = points.len();
        let link = |i: usize| [(i + n - 1) % n, (i + 1) % n].map(|k| k as u32);
        let mut ring = Self {
            points,
            links: (0..n).map(link).collect(),
            is_left: vec![true; n],
            left: n,
            blockers: Blockers::default(),
        };
        let reflex = (0..n as u32).filter(|&corner| !ring.is_convex(corner)).collect();
        ring.blockers = Blockers::new(points, reflex);
        ring
    }

    fn triangulate(mut self, triangles: &mut [[u32; 3]]) -> bool {
        let mut triangles = triangles.iter_mut();
        let mut put = |triangle| {
            if let Some(place) = triangles.next() {
                *place = triangle;
            }
        };
        let n = self.points.len();
        // A corner at the place of the next has a triangle without an area, and is no hindrance to others.
        for corner in 0..n as u32 {
            if self.left > 3 && self.point(corner) == self.point(self.next(corner)) {
                self.blockers.remove(corner);
                let [p, q] = self.clip(corner);
                put([p, corner, q]);
            }
        }
        let mut tried = 0;
        // With strips of as many triangles, about three rounds are enough.
        let strip = (n as f64).cbrt() as usize;
        // The round in which a neighbour was clipped, and that in which a corner has come into either list.
        let (mut waits, mut waited_in, mut fresh_in) = (vec![0; n], vec![0; n], vec![0; n]);
        let mut candidates: Vec<u32> = (0..n as u32).collect();
        // As many were left when all that were blocked were tried again.
        let (mut blocked, mut retried) = (Vec::new(), 0);
        for round in 1.. {
            // Corners that had to wait come first, or some would wait for ever, and become the centre of a fan.
            let (mut next, mut fresh) = (Vec::new(), Vec::new());
            // Candidates first that are as far from each other as strips are long.
            let order = |first| candidates.iter().skip(first).step_by(strip + 2);
            for &ear in (0..strip + 2).flat_map(order) {
                let at = ear as usize;
                if self.left == 3 || !self.is_left[at] {
                    continue;
                }
                if waits[at] == round {
                    if std::mem::replace(&mut waited_in[at], round) != round {
                        next.push(ear);
                    }
                    continue;
                }
                if !self.is_convex(ear) {
                    continue;
                }
                tried += 1;
                if self.is_blocked(ear) {
                    blocked.push(ear);
                    continue;
                }
                let mut sides = self.clip(ear);
                put([sides[0], ear, sides[1]]);
                // A strip goes on from there, to both sides in turn.
                for turn in 0..strip {
                    let side = sides[turn % 2];
                    let is_free = self.left > 3 && waits[side as usize] != round;
                    if !is_free || !self.is_convex(side) || self.is_blocked(side) {
                        break;
                    }
                    let [p, q] = self.clip(side);
                    put([p, side, q]);
                    sides = [p, q];
                }
                for side in sides {
                    waits[side as usize] = round;
                    if std::mem::replace(&mut fresh_in[side as usize], round) != round {
                        fresh.push(side);
                    }
                }
            }
            let is_slow = tried > TRIES * n || self.blockers.looked_at() > TRIES * TRIES * n;
            if self.left == 3 || is_slow {
                break;
            }
            next.append(&mut fresh);
            if next.is_empty() {
                if retried == self.left {
                    break;
                }
                retried = self.left;
                next = std::mem::take(&mut blocked);
            }
            candidates = next;
        }
        let first = self.is_left.iter().position(|&left| left).unwrap_or(0) as u32;
        let is_whole = self.left == 3 && self.is_convex(first);
        let [mut at, mut after] = [self.next(first), self.next(self.next(first))];
        while after != first {
            put([first, at, after]);
            [at, after] = [after, self.next(after)];
        }
        is_whole
    }

    fn point(&self, corner: u32) -> Point {
        self.points[corner as usize]
    }

    fn next(&self, corner: u32) -> u32 {
        self.links[corner as usize][1]
    }

    fn is_convex(&self, corner: u32) -> bool {
        let [a, c] = self.links[corner as usize];
        area(self.point(a), self.point(corner), self.point(c)) > 0.0
    }

    /// Removes a corner, and returns its neighbours.
    fn clip(&mut self, ear: u32) -> [u32; 2] {
        let [a, c] = self.links[ear as usize];
        self.links[a as usize][1] = c;
        self.links[c as usize][0] = a;
        self.is_left[ear as usize] = false;
        self.left -= 1;
        for side in [a, c] {
            if self.is_convex(side) {
                self.blockers.remove(side);
            }
        }
        [a, c]
    }

    /// Whether a corner that is not convex lies in an ear. One where the ear's neighbours are is no hindrance, as where a bridge
    /// leads to a hole; one where its tip is, is one if an edge leads from there into the ear.
    fn is_blocked(&self, ear: u32) -> bool {
        let [a, c] = self.links[ear as usize];
        let [p, tip, q] = [a, ear, c].map(|corner| self.point(corner));
        self.blockers.any_in([p, tip, q], |corner| {
            if [a, ear, c].contains(&corner) {
                return false;
            }
            let at = self.point(corner);
            if at == tip {
                let ends = self.links[corner as usize].map(|end| self.point(end));
                return ends.iter().any(|&end| area(p, tip, end) > 0.0 && area(tip, q, end) > 0.0);
            }
            at != p && at != q
        })
    }
}
