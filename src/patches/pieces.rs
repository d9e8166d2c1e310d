//! Parts that pairs of triangles add to the patches of contact: corners, lines and areas, with names for what several pairs have in common.

use super::interval::{Interval, cross, length, plus, posed, times, towards};
use super::vertices::Vertices;
use crate::memory::{push, reserve};
use crate::{Error, TrianglePair};
use pfront_core::Pose64;
use pfront_core::bvtt::PairBvtt;
use pfront_core::triangle::{Meet, Region};

/// The name of a part of a contact: a region of each mesh.
pub(super) type Name = [u64; 2];

/// A corner of what two triangles have in common.
pub(super) struct Corner {
    pub(super) name: Name,
    /// The number of the pair.
    pub(super) pair: u32,
    /// Whether it is all that they have in common, so that all corners of the pair are one point.
    pub(super) is_all: bool,
    pub(super) at: [Interval; 3],
}

/// A segment in which two triangles meet, or that is the border of a polygon in which they do.
pub(super) struct ContactLine {
    pub(super) name: Name,
    pub(super) pair: u32,
    pub(super) ends: [Name; 2],
    pub(super) is_border: bool,
    /// Whether no triangle without area has it, whose edges overlap: then no two names are of overlapping lines.
    pub(super) is_sure: bool,
    pub(super) length: Interval,
}

/// The parts that some pairs add.
#[derive(Default)]
pub(crate) struct Pieces {
    /// How many pairs there are.
    pub(super) pairs: u32,
    pub(super) corners: Vec<Corner>,
    pub(super) lines: Vec<ContactLine>,
    /// The areas of polygons, by the number of their pairs.
    pub(super) areas: Vec<(u32, Interval)>,
    /// The corners of the last pair; kept to use their memory again.
    own: Vec<PosedCorner>,
}

/// A corner of a pair, in the pose in which it is measured.
struct PosedCorner {
    regions: [Region; 2],
    at: [Interval; 3],
}

impl PosedCorner {
    /// The edges of each triangle that hold this corner and another with their ends, a bit for each.
    fn common_edges(&self, other: &Self) -> [u8; 2] {
        [0, 1].map(|mesh| self.regions[mesh].edges() & other.regions[mesh].edges())
    }

    /// The smallest regions, of both triangles, that hold the inside of the segment to another corner.
    fn between(&self, other: &Self) -> [Region; 2] {
        self.common_edges(other).map(|edges| match edges {
            0 => Region::Face,
            edges => Region::Edge(edges.trailing_zeros() as u8),
        })
    }
}

/// The number of a region in [`Region::ALL`].
fn number(region: Region) -> usize {
    match region {
        Region::Corner(k) => k.into(),
        Region::Edge(k) => 3 + usize::from(k),
        Region::Face => 6,
    }
}

impl Pieces {
    /// Adds the next pair, whose corners are posed once more for lengths, areas and points.
    pub(crate) fn add(
        &mut self,
        tree: &PairBvtt<'_>,
        vertices: &Vertices<'_>,
        pair: TrianglePair,
        pose: &Pose64,
    ) -> Result<(), Error> {
        let number_of_pair = self.pairs;
        self.pairs += 1;
        let (Some(meet), [a, b]) = (tree.meet(pair), tree.corners(pair)) else { return Ok(()) };
        let names = [vertices.regions(0, pair.a), vertices.regions(1, pair.b)];
        let name = |[r, s]: [Region; 2]| [names[0][number(r)], names[1][number(s)]];
        let corners = &mut self.own;
        corners.clear();
        for (regions, p) in meet.corners().zip(meet.points(&a, &b)) {
            push(corners, PosedCorner { regions, at: posed(pose, &p) })?;
        }
        let is_all = meet.dimension() == 0;
        reserve(&mut self.corners, corners.len())?;
        self.corners.extend(corners.iter().map(|own| Corner {
            name: name(own.regions),
            pair: number_of_pair,
            is_all,
            at: own.at,
        }));
        if is_all {
            return Ok(());
        }
        let mut line = |p: &PosedCorner, q: &PosedCorner| {
            let line = ContactLine {
                name: name(p.between(q)),
                pair: number_of_pair,
                ends: [name(p.regions), name(q.regions)],
                is_border: meet.dimension() == 2,
                is_sure: meet.has_area() == [true; 2],
                length: length(&towards(&p.at, &q.at)),
            };
            push(&mut self.lines, line)
        };
        if meet.dimension() == 2 {
            sort_around(corners);
            for (at, corner) in corners.iter().enumerate() {
                line(corner, &corners[(at + 1) % corners.len()])?;
            }
            return push(&mut self.areas, (number_of_pair, area(corners)));
        }
        let parts = [0, 1].map(|mesh| parts(&meet, mesh, [&a, &b][mesh]));
        for part_of_a in parts[0].iter().filter(|part| **part != 0) {
            for part_of_b in parts[1].iter().filter(|part| **part != 0) {
                let is_of_both = |corner: &&PosedCorner| {
                    let [r, s] = corner.regions.map(number);
                    part_of_a >> r & part_of_b >> s & 1 != 0
                };
                let mut of_both = corners.iter().filter(is_of_both);
                if let (Some(p), Some(q)) = (of_both.next(), of_both.next()) {
                    line(p, q)?;
                }
            }
        }
        Ok(())
    }

    /// Adds what further pairs have added.
    pub(super) fn append(&mut self, mut more: Self) -> Result<(), Error> {
        let before = self.pairs;
        self.pairs += more.pairs;
        more.corners.iter_mut().for_each(|corner| corner.pair += before);
        more.lines.iter_mut().for_each(|line| line.pair += before);
        more.areas.iter_mut().for_each(|(pair, _)| *pair += before);
        reserve(&mut self.corners, more.corners.len())?;
        reserve(&mut self.lines, more.lines.len())?;
        reserve(&mut self.areas, more.areas.len())?;
        self.corners.append(&mut more.corners);
        self.lines.append(&mut more.lines);
        self.areas.append(&mut more.areas);
        Ok(())
    }
}

/// The parts of a triangle in which it meets the other in one segment each, as bits of their regions: all of it, or its edges if it has
/// no area.
fn parts(meet: &Meet, mesh: usize, t: &[[f64; 3]; 3]) -> [u8; 3] {
    if meet.has_area()[mesh] {
        return [0b111_1111, 0, 0];
    }
    [0, 1, 2].map(|k: usize| {
        let next = (k + 1) % 3;
        if t[k] == t[next] { 0 } else { 1 << k | 1 << next | 1 << (3 + k) }
    })
}

/// Puts the corners of a polygon in order around it: two are beside each other if an edge of a triangle holds both.
fn sort_around(corners: &mut [PosedCorner]) {
    for at in 1..corners.len() {
        let is_beside = |&i: &usize| corners[at - 1].common_edges(&corners[i]) != [0; 2];
        let next = (at..corners.len()).find(is_beside);
        corners.swap(at, next.unwrap_or(at));
    }
}

/// The area of a polygon.
fn area(corners: &[PosedCorner]) -> Interval {
    let mut sum = [[0.0; 2]; 3];
    for two in corners[1..].windows(2) {
        let [u, v] = [&two[0], &two[1]].map(|corner| towards(&corners[0].at, &corner.at));
        let turned = cross(&u, &v);
        sum = [0, 1, 2].map(|k| plus(sum[k], turned[k]));
    }
    times([0.5; 2], length(&sum)).map(|x| x.max(0.0))
}
