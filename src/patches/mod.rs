//! Where two models touch and cross, in connected patches.
//!
//! The common part of two surfaces is made of polygons, lines and points. A point lies in one region of each mesh, a vertex, an edge without its
//! ends or a face, and these two name it. So corners of pairs of triangles that have the same name are the same point, without any comparison
//! of coordinates, and patches are the sets of pairs that such corners join. Lines have names likewise, so that each is measured once,
//! however many pairs have it. Only coordinates, lengths and areas are rounded, outward.

mod interval;
pub(crate) mod pieces;
pub(crate) mod vertices;

use crate::environment::with_default;
use crate::memory::{filled, push, reserve};
use crate::{Error, TrianglePair};
use interval::{Interval, plus};
use pieces::{Name, Pieces};

/// A connected part of what two surfaces have in common: an isolated point, curves, areas, or what is joined of these.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPatch {
    /// 0 for a point, 1 for curves, 2 if there are areas.
    pub dimension: usize,
    /// The pairs of triangles that meet there, sorted.
    pub pairs: Vec<TrianglePair>,
    /// Whether it surely has no end: a curve that comes back to where it began, as all are in which two closed surfaces cross, or areas
    /// without an outline.
    pub is_closed: bool,
    /// An interval that holds the length of its curves and of the outlines of its areas.
    pub length: [f64; 2],
    /// An interval that holds its area.
    pub area: [f64; 2],
    /// The corners of what triangles have in common there, each once, rounded.
    pub points: Vec<[f64; 3]>,
    /// Curves and outlines, as segments between two of the points.
    pub segments: Vec<[u32; 2]>,
}

/// Sets of numbers, as trees of parents.
struct Sets(Vec<u32>);

impl Sets {
    fn new(len: usize) -> Result<Self, Error> {
        let mut parents = Vec::new();
        reserve(&mut parents, len)?;
        parents.extend(0..len as u32);
        Ok(Self(parents))
    }

    /// The lowest of the set of one.
    fn root(&mut self, mut of: u32) -> u32 {
        while self.0[of as usize] != of {
            let above = self.0[self.0[of as usize] as usize];
            self.0[of as usize] = above;
            of = above;
        }
        of
    }

    fn join(&mut self, of: u32, with: u32) {
        let (a, b) = (self.root(of), self.root(with));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The patches of pairs, from what these have added.
pub(crate) fn assemble(
    pairs: &[TrianglePair],
    pieces: Vec<Pieces>,
) -> Result<Vec<ContactPatch>, Error> {
    let mut pieces = pieces.into_iter();
    let mut all = pieces.next().unwrap_or_default();
    pieces.try_for_each(|more| all.append(more))?;
    let Pieces { mut corners, mut lines, areas, .. } = all;
    corners.sort_unstable_by_key(|corner| (corner.name, corner.pair));
    lines.sort_unstable_by_key(|line| (line.name, line.pair));

    let mut joined = Sets::new(pairs.len())?;
    let mut names: Vec<Name> = Vec::new();
    for at_one in corners.chunk_by(|p, q| p.name == q.name) {
        at_one.iter().for_each(|corner| joined.join(at_one[0].pair, corner.pair));
        push(&mut names, at_one[0].name)?;
    }
    // Points with several names, where a triangle without area has several regions.
    let (mut same, mut firsts) = (Sets::new(names.len())?, filled(u32::MAX, pairs.len())?);
    let each = corners.chunk_by(|p, q| p.name == q.name).zip(0..);
    for (at_one, point) in each.clone() {
        for corner in at_one.iter().filter(|corner| corner.is_all) {
            let first = &mut firsts[corner.pair as usize];
            *first = (*first).min(point);
            same.join(*first, point);
        }
    }

    let (mut patches, mut patch_of) = (Vec::<ContactPatch>::new(), filled(0, pairs.len())?);
    for (pair, number) in pairs.iter().zip(0..) {
        let root = joined.root(number);
        if root == number {
            patch_of[number as usize] = patches.len();
            push(&mut patches, ContactPatch::EMPTY)?;
        }
        patch_of[number as usize] = patch_of[root as usize];
        push(&mut patches[patch_of[root as usize]].pairs, *pair)?;
    }

    let mut places = filled(0, names.len())?;
    for (at_one, point) in each {
        let root = same.root(point) as usize;
        let points = &mut patches[patch_of[at_one[0].pair as usize]].points;
        if root == point as usize {
            places[root] = points.len() as u32;
            push(points, at_one[0].at.map(|[low, high]| low * 0.5 + high * 0.5))?;
        }
        places[point as usize] = places[root];
    }

    let mut point_of = |name: &Name| {
        let found = names.binary_search(name);
        found.map_or(0, |at| same.root(at as u32) as usize)
    };
    let (mut lines_at, mut ends) = (filled(0_u32, names.len())?, Vec::new());
    for along_one in lines.chunk_by(|p, q| p.name == q.name) {
        let line = &along_one[0];
        let of_line = line.ends.each_ref().map(&mut point_of);
        of_line.iter().for_each(|&end| lines_at[end] += 1);
        let number = patch_of[line.pair as usize];
        push(&mut ends, (number, of_line))?;
        let patch = &mut patches[number];
        patch.dimension = patch.dimension.max(1);
        let borders = along_one.iter().filter(|line| line.is_border).count();
        let is_sure = along_one.iter().all(|line| line.is_sure);
        patch.is_closed &= is_sure && borders != 1;
        if borders <= 1 {
            push(&mut patch.segments, of_line.map(|end| places[end]))?;
            let [low, high] = line.length;
            patch.length = plus(patch.length, [if is_sure { low } else { 0.0 }, high]);
        }
    }
    for (number, of_line) in ends {
        patches[number].is_closed &= of_line.iter().all(|&end| lines_at[end] > 1);
    }
    for (pair, area) in areas {
        let patch = &mut patches[patch_of[pair as usize]];
        patch.dimension = 2;
        patch.area = plus(patch.area, area);
    }
    for patch in &mut patches {
        patch.is_closed &= patch.dimension > 0;
        patch.length[0] = patch.length[0].max(0.0);
        patch.area[0] = patch.area[0].max(0.0);
    }
    Ok(patches)
}

impl ContactPatch {
    /// Nothing yet.
    const EMPTY: Self = Self {
        dimension: 0,
        pairs: Vec::new(),
        is_closed: true,
        length: [0.0; 2],
        area: [0.0; 2],
        points: Vec::new(),
        segments: Vec::new(),
    };
}

/// The contact of two bodies, in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSize {
    /// 0 for points alone, 1 for curves, 2 if there are areas.
    pub dimension: usize,
    /// The number of its connected patches.
    pub patches: usize,
    /// An interval that holds the length of curves and of the outlines of areas.
    pub length: [f64; 2],
    /// An interval that holds the area.
    pub area: [f64; 2],
}

impl ContactSize {
    /// The contact of all patches together; `None` if there are none.
    ///
    /// # Examples
    /// ```
    /// use pfront::{ContactSize, Model, PairQuery, Pose};
    /// let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let square = Model::new(square, vec![[0, 1, 2], [1, 3, 2]])?;
    /// let patches = PairQuery::new().patches(&square, &square, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let size = ContactSize::of(&patches).expect("they meet");
    /// let holds = |[low, high]: [f64; 2], x: f64| low <= x && x <= high && high - low < 1e-12;
    /// assert!(size.dimension == 2 && size.patches == 1 && holds(size.area, 0.5) && holds(size.length, 3.0));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub fn of(patches: &[ContactPatch]) -> Option<Self> {
        let sum = |of: fn(&ContactPatch) -> Interval| {
            let add = |sum, patch| if of(patch) == [0.0; 2] { sum } else { plus(sum, of(patch)) };
            with_default(|| patches.iter().fold([0.0; 2], add).map(|x| x.max(0.0)))
        };
        Some(Self {
            dimension: patches.iter().map(|patch| patch.dimension).max()?,
            patches: patches.len(),
            length: sum(|patch| patch.length),
            area: sum(|patch| patch.area),
        })
    }
}
