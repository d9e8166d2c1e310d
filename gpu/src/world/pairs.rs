//! Pairs of bodies as the passes know them.
//!
//! The first half of a node pair, leaf pair or triangle pair says which pair of bodies it belongs to: each has a run of ids
//! of its own, as long as the first mesh has nodes or triangles. So fronts and lists hold two words an entry, as those of two
//! meshes do, and sorted hits are in the order of the pairs. A run takes whole blocks of ids, and each
//! block has a row that tells all about its pair: finding it takes a shift, where a search among
//! prefix sums would take a dozen loads that wait for each other. Rows hold the poses, and not where these are: one load
//! less, and a body that moves costs the device nothing, since rows are written for each question anyway.

use super::arena::{Arena, ArenaMesh, MOST_PAIRS, entries};
use super::placing::{Inverse, Placed, place};
use crate::layout::InstancePair;
use crate::sequence::groups_for;
use crate::task::Entry;
use pfront_core::bvtt::TrianglePair;
use pfront_core::{Aabb, Pose};
use std::sync::Arc;

/// Two different bodies by their numbers.
pub type BodyPair = [u32; 2];

/// A body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    /// The number of its mesh.
    pub(super) mesh: u32,
    /// Where it is, within the bounds that the mesh has by now.
    pub(super) placed: Placed,
}

impl Body {
    pub(super) fn new(arena: &Arena, mesh: u32, pose: &Pose) -> Self {
        let bounds = arena.meshes[mesh as usize].bounds.unwrap_or(Aabb::EMPTY);
        Self { mesh, placed: Placed::new(pose, &bounds) }
    }
}

/// As many pairs as one run can tell apart.
#[derive(Debug)]
pub(super) struct Chunk {
    /// A row for each block of ids.
    pub(super) rows: Vec<InstancePair>,
    /// Bits of an id within a block.
    pub(super) shift: u32,
    /// The first of its pairs.
    pub(super) first: usize,
    pub(super) front: Vec<Entry>,
    /// Levels of the BVTTs below the front.
    pub(super) levels: u32,
}

/// The pairs of a question, of which the first are chunks already.
#[derive(Debug)]
pub(super) struct Chunks {
    /// The bodies as they were when the question was asked.
    bodies: Arc<Vec<Body>>,
    shift: u32,
    /// The most rows of a chunk, and the most pairs.
    most: usize,
    most_pairs: usize,
    is_each: bool,
    /// The number of the first pair that is left.
    next: usize,
}

impl Chunks {
    /// Divides pairs into chunks of at most so many rows, so many pairs and 2^31 ids, and no more than a dispatch has workgroups: the rows of
    /// one are made while the device works on another.
    ///
    /// With `is_each`, node pairs are roots; else a first front has work for many workgroups, however few the pairs are.
    pub(super) fn new(
        arena: &Arena,
        bodies: Arc<Vec<Body>>,
        pairs: &[BodyPair],
        [most_rows, most_pairs]: [usize; 2],
        is_each: bool,
    ) -> Self {
        let count = |(asked, sum): (u64, u64), pair| match ids(meshes(arena, &bodies, pair)) {
            0 => (asked, sum),
            ids => (asked + 1, sum + ids),
        };
        let (asked, sum) = pairs.iter().fold((0, 0), count);
        // At most one block a pair on average and one more, most of which are in use.
        let shift = sum.div_ceil(asked.max(1)).max(1).next_power_of_two().ilog2();
        let most = most_rows.min(1 << (31 - shift)).min(groups_for(u32::MAX) as usize);
        Self { bodies, shift, most, most_pairs, is_each, next: 0 }
    }

    /// Whether all pairs are in chunks.
    pub(super) fn is_over(&self, pairs: &[BodyPair]) -> bool {
        self.next == pairs.len()
    }

    /// The next chunk, if there is something left to be asked, its rows in this memory.
    pub(super) fn next(
        &mut self,
        arena: &Arena,
        pairs: &[BodyPair],
        mut rows: Vec<InstancePair>,
    ) -> Option<Chunk> {
        let Self { bodies, shift, most, most_pairs, is_each, next } = self;
        let meshes = |pair: &BodyPair| meshes(arena, bodies, pair);
        let left = std::mem::replace(next, pairs.len());
        let start = left + pairs[left..].iter().position(|pair| ids(meshes(pair)) != 0)?;
        rows.clear();
        rows.reserve((pairs.len() - start).min(*most).min(*most_pairs));
        let mut chunk = Chunk { rows, shift: *shift, first: start, front: Vec::new(), levels: 1 };
        let mut first: Option<(u32, Option<Inverse>)> = None;
        for (number, pair) in pairs.iter().enumerate().skip(start) {
            let two = meshes(pair);
            let ids = ids(two);
            if ids == 0 {
                continue;
            }
            let blocks = ids.div_ceil(1 << *shift) as usize;
            let is_full = chunk.rows.len() + blocks > *most || number - start >= *most_pairs;
            if !chunk.rows.is_empty() && is_full {
                *next = number;
                break;
            }
            let [a, b] = pair.map(|body| &bodies[body as usize].placed);
            let (_, inverse) = match &mut first {
                Some(known) if known.0 == pair[0] => known,
                none => none.insert((pair[0], a.inverse())),
            };
            let row = InstancePair {
                number: (number - start) as u32,
                first_id: (chunk.rows.len() as u32) << *shift,
                first_node: two[0].first_node,
                first_slot: two[0].first_slot,
                ..place(a, inverse.as_ref(), b)
            };
            chunk.rows.extend(std::iter::repeat_n(row, blocks));
        }
        chunk.add_front(&pairs[start..*next], meshes, *is_each);
        Some(chunk)
    }
}

/// The meshes of a pair of bodies.
fn meshes<'a>(arena: &'a Arena, bodies: &[Body], pair: &BodyPair) -> [&'a ArenaMesh; 2] {
    pair.map(|body| &arena.meshes[bodies[body as usize].mesh as usize])
}

/// Ids that a pair takes: none if a mesh is empty.
fn ids([a, b]: [&ArenaMesh; 2]) -> u64 {
    if b.ids == 0 { 0 } else { u64::from(a.ids) }
}

impl Chunk {
    fn add_front<'a>(
        &mut self,
        pairs: &[BodyPair],
        meshes: impl Fn(&BodyPair) -> [&'a ArenaMesh; 2],
        is_each: bool,
    ) {
        let node_pairs = |level: usize| -> usize {
            let of_pair =
                |pair| meshes(pair).map(|mesh| mesh.level(level).0.len()).iter().product::<usize>();
            pairs.iter().map(of_pair).sum::<usize>()
        };
        // No balanced tree has more levels to offer.
        let deepest = if is_each { 0 } else { MOST_PAIRS.ilog2() as usize };
        // No level has fewer nodes than the one above it.
        let suits = |level: &usize| node_pairs(*level) <= MOST_PAIRS;
        let level = (1..=deepest).take_while(suits).last().unwrap_or(0);
        self.front.reserve(node_pairs(level));
        for row in self.rows.chunk_by(|x, y| x.number == y.number) {
            let two = meshes(&pairs[row[0].number as usize]);
            self.front.extend(entries(two, level, row[0].first_id));
            self.levels = two.iter().fold(self.levels, |most, mesh| most.max(mesh.level(level).1));
        }
    }
}

/// The number of the pair of bodies that a hit belongs to, and its triangles.
pub(super) fn hit(rows: &[InstancePair], shift: u32, hit: TrianglePair) -> (usize, TrianglePair) {
    let row = &rows[(hit.a >> shift) as usize];
    (row.number as usize, TrianglePair { a: hit.a - row.first_id, b: hit.b })
}
