//! Flips edges within a triangulated face, so that few of its triangles are around any corner.

use super::blockers::{Point, area};
use std::collections::{BinaryHeap, HashMap};

/// The triangles around a corner, unless the outline of the face asks for more.
const MOST: u32 = 12;

/// Triangles that may be looked at for each corner of the face: a bound for outlines that leave nothing to flip.
const TRIES: usize = 16;

/// An end with so many times fewer triangles gets several in a row.
const SPREAD: u32 = 4;

const NONE: u32 = u32::MAX;

/// Flips edges of corners with more triangles than [`MOST`], the most crowded first, each to two corners that have fewer even
/// then, until there is no such edge. The triangles cover the same before and after, and turn left.
pub(super) fn lower_valence(triangles: &mut [[u32; 3]], points: &[Point]) {
    let mut valence = vec![0; points.len()];
    triangles.as_flattened().iter().for_each(|&corner| valence[corner as usize] += 1);
    let crowd = |(valence, corner): (&u32, u32)| (*valence > MOST).then_some((*valence, corner));
    let mut crowded: BinaryHeap<(u32, u32)> = valence.iter().zip(0..).filter_map(crowd).collect();
    if crowded.is_empty() {
        return;
    }
    let mut flips = Flips::new(triangles, points, valence);
    while let Some((valence, centre)) = crowded.pop()
        && flips.looked_at < TRIES * points.len()
    {
        // Corners whose valence has changed are there again.
        if flips.valence[centre as usize] == valence {
            flips.at(centre, |changed, valence| {
                if valence > MOST {
                    crowded.push((valence, changed));
                }
            });
        }
    }
}

struct Flips<'t> {
    triangles: &'t mut [[u32; 3]],
    points: &'t [Point],
    /// The triangles beyond the edges of each, of which the first leaves its first corner; or `NONE`.
    beyond: Vec<[u32; 3]>,
    /// A triangle of each corner.
    of_corner: Vec<u32>,
    valence: Vec<u32>,
    looked_at: usize,
}

impl<'t> Flips<'t> {
    fn new(triangles: &'t mut [[u32; 3]], points: &'t [Point], valence: Vec<u32>) -> Self {
        let mut beyond = vec![[NONE; 3]; triangles.len()];
        let mut of_corner = vec![0; points.len()];
        let mut open = HashMap::with_capacity(triangles.len());
        for (number, triangle) in (0..).zip(&*triangles) {
            for (k, &from) in triangle.iter().enumerate() {
                of_corner[from as usize] = number;
                let to = triangle[(k + 1) % 3];
                match open.remove(&(to, from)) {
                    Some((other, edge)) => {
                        beyond[number as usize][k] = other;
                        beyond[other as usize][edge] = number;
                    }
                    None => drop(open.insert((from, to), (number, k))),
                }
            }
        }
        Self { triangles, points, beyond, of_corner, valence, looked_at: 0 }
    }

    /// The place of a corner in a triangle.
    fn place(&self, triangle: u32, corner: u32) -> usize {
        let places = self.triangles[triangle as usize];
        places.iter().position(|&other| other == corner).unwrap_or(0)
    }

    /// Flips edges of a corner, and tells which corners have another valence.
    fn at(&mut self, centre: u32, mut changed: impl FnMut(u32, u32)) {
        // Every corner is on the outline, so that its triangles have a first.
        let mut first = self.of_corner[centre as usize];
        loop {
            self.looked_at += 1;
            match self.beyond[first as usize][self.place(first, centre)] {
                NONE => break,
                before => first = before,
            }
        }
        let mut flipped = false;
        loop {
            self.looked_at += 1;
            let at = self.place(first, centre);
            let second = self.beyond[first as usize][(at + 2) % 3];
            if second == NONE {
                break;
            }
            let [a, w] = [1, 2].map(|k| self.triangles[first as usize][(at + k) % 3]);
            let other = self.place(second, centre);
            let b = self.triangles[second as usize][(other + 2) % 3];
            let [of_centre, of_w, of_a, of_b] =
                [centre, w, a, b].map(|corner| self.valence[corner as usize]);
            let [v, p, q, r] = [centre, a, w, b].map(|corner| self.points[corner as usize]);
            let lowers = of_a.max(of_b) + 1 < of_centre.max(of_w);
            if lowers && area(v, p, r) > 0.0 && area(p, q, r) > 0.0 {
                self.flip([first, second], [centre, a, w, b]);
                flipped = true;
                changed(w, of_w - 1);
                changed(a, of_a + 1);
                changed(b, of_b + 1);
                // The next but one, or one end would get them all, as it may where it has far fewer.
                let is_spread = SPREAD * of_a.max(of_b) >= of_centre;
                let at = self.place(first, centre);
                match self.beyond[first as usize][if is_spread { (at + 2) % 3 } else { at }] {
                    NONE if is_spread => break,
                    NONE => {}
                    next => first = next,
                }
            } else {
                first = second;
            }
        }
        if flipped {
            changed(centre, self.valence[centre as usize]);
        }
    }

    /// Replaces two triangles, of a corner and one after the other, by those on both sides of the other diagonal.
    fn flip(&mut self, [first, second]: [u32; 2], [centre, a, w, b]: [u32; 4]) {
        let [at, other] = [first, second].map(|triangle| self.place(triangle, centre));
        let [before, outer] = [0, 1].map(|k| self.beyond[first as usize][(at + k) % 3]);
        let [far, after] = [1, 2].map(|k| self.beyond[second as usize][(other + k) % 3]);
        self.triangles[first as usize] = [centre, a, b];
        self.beyond[first as usize] = [before, second, after];
        self.triangles[second as usize] = [a, w, b];
        self.beyond[second as usize] = [outer, far, first];
        for (triangle, was, is) in [(after, second, first), (outer, first, second)] {
            if let Some(edges) = self.beyond.get_mut(triangle as usize)
                && let Some(edge) = edges.iter_mut().find(|edge| **edge == was)
            {
                *edge = is;
            }
        }
        for (corner, triangle) in [(centre, first), (a, first), (b, first), (w, second)] {
            self.of_corner[corner as usize] = triangle;
        }
        self.valence[centre as usize] -= 1;
        self.valence[w as usize] -= 1;
        self.valence[a as usize] += 1;
        self.valence[b as usize] += 1;
    }
}
