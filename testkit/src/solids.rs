//! Solids whose relation is known without any geometry: unions of blocks of a lattice, as sets of unit cells.
//!
//! Two such solids have a cell in common, or one only the first has, or only the second; and their surfaces meet exactly if they
//! have a lattice point in common, since faces of unit cells that meet share a corner. Nothing here knows triangles from
//! another mesh: no hits, no edges, no signs.

use crate::{MeshData, Point};
use rand::{Rng, RngExt};
use std::collections::{BTreeMap, BTreeSet};

/// A cell, by its lowest corner; or a lattice point.
pub type Cell = [i32; 3];

/// A union of blocks, all of one size, on a lattice of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    /// How long a block is along each axis.
    pub size: [i32; 3],
    /// Where the block 0, 0, 0 has its lowest corner.
    pub offset: Cell,
    /// The blocks, counted from there.
    pub blocks: BTreeSet<Cell>,
}

/// The relation of two sets of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truth {
    /// `apart`, `touching`, `crossing`, `a_in_b`, `b_in_a` or `equal`.
    pub word: &'static str,
    /// Whether the surfaces meet.
    pub meets: bool,
    /// The number of common cells.
    pub volume: usize,
}

const NEIGHBOURS: [Cell; 6] = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];

fn plus(p: Cell, q: Cell) -> Cell {
    [0, 1, 2].map(|k| p[k] + q[k])
}

/// The cells of a box from 0, 0, 0.
pub fn cells_of_box(size: Cell) -> impl Iterator<Item = Cell> {
    let [x, y, z] = size;
    (0..x).flat_map(move |i| (0..y).flat_map(move |j| (0..z).map(move |k| [i, j, k])))
}

/// The corners of the side of a block towards a neighbour, counter-clockwise from outside, for a block of size 1.
fn side(towards: Cell) -> [Cell; 4] {
    let axis = (0..3).find(|&k| towards[k] != 0).unwrap_or(0);
    let at = |u: i32, v: i32| {
        let mut p = [0; 3];
        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (i32::from(towards[axis] > 0), u, v);
        p
    };
    let corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
    if towards[axis] > 0 { corners } else { [corners[3], corners[2], corners[1], corners[0]] }
}

impl Blocks {
    /// The unit cells.
    pub fn cells(&self) -> BTreeSet<Cell> {
        let scaled = |block: &Cell| [0, 1, 2].map(|k| block[k] * self.size[k] + self.offset[k]);
        let of = |block: &Cell| {
            let lowest = scaled(block);
            cells_of_box(self.size).map(move |cell| plus(lowest, cell))
        };
        self.blocks.iter().flat_map(of).collect()
    }

    /// The surface: two triangles for each side of a block that has no neighbour, with either diagonal. Corners in one place are
    /// one vertex, or, in a soup, never.
    pub fn mesh(&self, is_soup: bool, rng: &mut impl Rng) -> MeshData {
        let (mut mesh, mut vertices) = (MeshData::default(), BTreeMap::new());
        for block in &self.blocks {
            for towards in NEIGHBOURS {
                if self.blocks.contains(&plus(*block, towards)) {
                    continue;
                }
                let quad = side(towards).map(|corner| {
                    let at = plus(*block, corner);
                    [0, 1, 2].map(|k| at[k] * self.size[k] + self.offset[k])
                });
                let first = rng.random_range(0..4);
                for triangle in [[0, 1, 2], [0, 2, 3]] {
                    let corner = |k: usize| {
                        let at = quad[(k + first) % 4];
                        let new = mesh.positions.len() as u32;
                        let vertex = if is_soup { new } else { *vertices.entry(at).or_insert(new) };
                        if vertex == new {
                            mesh.positions.push(at.map(|x| x as f32));
                        }
                        vertex
                    };
                    let triangle = triangle.map(corner);
                    mesh.triangles.push(triangle);
                }
            }
        }
        mesh
    }
}

/// Whether a point, given by twice its coordinates, is in the interior of a set of cells; `None` if it is on the surface.
pub fn is_inside(cells: &BTreeSet<Cell>, doubled: Cell) -> Option<bool> {
    // On the border of two cells along an axis it belongs to both.
    let lowest = doubled.map(|x| (x - 1).div_euclid(2));
    let extent = doubled.map(|x| if x % 2 == 0 { 2 } else { 1 });
    let mut near = cells_of_box(extent).map(|cell| cells.contains(&plus(lowest, cell)));
    let first = near.next()?;
    near.all(|other| other == first).then_some(first)
}

/// The lattice points on the surface of a set of cells.
fn surface(cells: &BTreeSet<Cell>) -> BTreeSet<Cell> {
    let mut points = BTreeSet::new();
    for cell in cells {
        for towards in NEIGHBOURS {
            if !cells.contains(&plus(*cell, towards)) {
                points.extend(side(towards).map(|corner| plus(*cell, corner)));
            }
        }
    }
    points
}

/// The relation of two sets of cells, neither of which is empty.
pub fn truth(a: &BTreeSet<Cell>, b: &BTreeSet<Cell>) -> Truth {
    let volume = a.intersection(b).count();
    let meets = !surface(a).is_disjoint(&surface(b));
    let word = match (volume, volume == a.len(), volume == b.len()) {
        (0, ..) if meets => "touching",
        (0, ..) => "apart",
        (_, true, true) => "equal",
        (_, true, false) => "a_in_b",
        (_, false, true) => "b_in_a",
        (_, false, false) => "crossing",
    };
    Truth { word, meets, volume }
}

/// A connected part of what two surfaces have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Patch {
    /// 0 for a point, 1 for lines, 2 if there are squares.
    pub dimension: usize,
    /// The number of unit squares.
    pub area: usize,
    /// The number of unit edges with at most one of the squares beside them.
    pub length: usize,
    /// Whether no edge has one square beside it, and no point ends one edge alone.
    pub is_closed: bool,
}

/// Unit squares, unit edges and lattice points, by twice their middle: a coordinate is odd along each axis in which they are long.
fn parts(cells: &BTreeSet<Cell>) -> BTreeSet<Cell> {
    let mut parts = BTreeSet::new();
    for cell in cells {
        for towards in NEIGHBOURS.into_iter().filter(|n| !cells.contains(&plus(*cell, *n))) {
            let middle = [0, 1, 2].map(|k| 2 * cell[k] + 1 + towards[k]);
            let around = cells_of_box([3; 3]).map(|p| plus(p, [-1; 3]));
            let within = around.filter(|p| (0..3).all(|k| p[k] == 0 || towards[k] == 0));
            parts.extend(within.map(|p| plus(middle, p)));
        }
    }
    parts
}

/// The connected parts of what the surfaces of two sets of cells have in common, sorted.
pub fn patches(a: &BTreeSet<Cell>, b: &BTreeSet<Cell>) -> Vec<Patch> {
    let all: BTreeSet<Cell> = parts(a).intersection(&parts(b)).copied().collect();
    let dimension = |part: &Cell| part.iter().filter(|x| **x % 2 != 0).count();
    let beside = |part: Cell| {
        let near = NEIGHBOURS.map(|towards| plus(part, towards));
        near.into_iter().filter(|other| all.contains(other)).collect::<Vec<_>>()
    };
    let above = |part: &Cell| {
        beside(*part).into_iter().filter(|other| dimension(other) > dimension(part)).count()
    };
    let (mut left, mut found) = (all.clone(), Vec::new());
    while let Some(first) = left.pop_first() {
        let (mut own, mut open) = (Vec::new(), vec![first]);
        while let Some(part) = open.pop() {
            own.push(part);
            open.extend(beside(part).into_iter().filter(|other| left.remove(other)));
        }
        let count = |of: usize, is: &dyn Fn(usize) -> bool| {
            own.iter().filter(|part| dimension(part) == of && is(above(part))).count()
        };
        let most = own.iter().map(dimension).max().unwrap_or(0);
        found.push(Patch {
            dimension: most,
            area: count(2, &|_| true),
            length: count(1, &|squares| squares <= 1),
            is_closed: most > 0 && count(1, &|n| n == 1) + count(0, &|n| n == 1) == 0,
        });
    }
    found.sort_unstable();
    found
}

/// A pair of solids of one of some families: unions, equal ones of other blocks, parts, complements, and what is in a cavity.
pub fn pair(rng: &mut impl Rng) -> [Blocks; 2] {
    let mut size = || [0; 3].map(|_| rng.random_range(1..=3));
    let sizes = [size(), size()];
    let union = |size: [i32; 3], rng: &mut dyn Rng| {
        let dense = rng.random_range(1..=9);
        let extent = [0; 3].map(|_| rng.random_range(1..=3));
        let mut blocks: BTreeSet<_> =
            cells_of_box(extent).filter(|_| rng.random_range(0..10) < dense).collect();
        if blocks.is_empty() {
            blocks.insert([0; 3]);
        }
        Blocks { size, offset: [0; 3].map(|_| rng.random_range(-3..=3)), blocks }
    };
    let a = union(sizes[0], rng);
    let unit = |blocks: BTreeSet<Cell>| Blocks { size: [1; 3], offset: [0; 3], blocks };
    let part = |of: &BTreeSet<Cell>, rng: &mut dyn Rng| {
        let some: BTreeSet<_> = of.iter().copied().filter(|_| rng.random_range(0..4) > 0).collect();
        if some.is_empty() { of.clone() } else { some }
    };
    let around = |a: &Blocks, wall: i32| -> BTreeSet<Cell> {
        let size = [0, 1, 2].map(|k| 3 * a.size[k] + 2 * wall);
        let lowest = a.offset.map(|x| x - wall);
        cells_of_box(size).map(|cell| plus(cell, lowest)).collect()
    };
    let b = match rng.random_range(0..7) {
        0..3 => union(sizes[1], rng),
        3 => unit(a.cells()),
        4 => unit(part(&a.cells(), rng)),
        5 => unit(around(&a, 1).difference(&a.cells()).copied().collect()),
        _ => {
            let wall = rng.random_range(0..=1);
            let hollow = a.cells();
            let all = around(&a, wall + 1);
            let grown: BTreeSet<_> = hollow
                .iter()
                .flat_map(|cell| NEIGHBOURS.map(|towards| plus(*cell, towards)))
                .chain(hollow.iter().copied())
                .collect();
            let rest: BTreeSet<_> = all.difference(&grown).copied().collect();
            if rest.is_empty() { unit(all) } else { unit(rest) }
        }
    };
    if rng.random_range(0..2) == 0 { [a, b] } else { [b, a] }
}

/// An affine map of the lattice with small integers that is invertible: one of the 48 symmetries of a cube, or a skew one. Returns its
/// rows, and how many times as large a cell becomes.
pub fn map(rng: &mut impl Rng) -> ([[i32; 3]; 3], i32) {
    let most = if rng.random_range(0..2) == 0 { 1 } else { 9 };
    loop {
        let mut rows = [[0; 3]; 3].map(|row| row.map(|_: i32| rng.random_range(-most..=most)));
        if most == 1 {
            let first = rng.random_range(0..3);
            let turn = rng.random_range(1..=2);
            for (i, row) in rows.iter_mut().enumerate() {
                *row = [0; 3];
                row[(first + i * turn) % 3] = if rng.random_range(0..2) == 0 { 1 } else { -1 };
            }
        }
        let [p, q, r] = rows;
        let determinant = p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
            + p[2] * (q[0] * r[1] - q[1] * r[0]);
        if determinant != 0 {
            return (rows, determinant.abs());
        }
    }
}

/// The image of a point with integer coordinates.
pub fn mapped(rows: &[[i32; 3]; 3], p: Point) -> Point {
    rows.map(|row| (0..3).map(|k| row[k] * p[k] as i32).sum::<i32>() as f32)
}
