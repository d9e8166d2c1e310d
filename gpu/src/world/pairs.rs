//! Pairs of bodies as the passes know them.
//!
//! The first half of a node pair, leaf pair or triangle pair says which pair of bodies it belongs to: each has a run of ids
//! of its own, as long as the first mesh has nodes or triangles. So fronts and lists hold two words an entry, as those of two
//! meshes do, and sorted hits are in the order of the pairs. A run takes whole blocks of ids, and each
//! block has a row that tells its pair: finding it takes a shift, where a search among
//! prefix sums would take a dozen loads that wait for each other. `pose.wgsl` makes of each row one that holds the poses, and not where
//! these are, which is one load less for all other passes.

use super::arena::{Arena, ArenaMesh, MOST_PAIRS};
use crate::layout::Row;
use crate::sequence::groups_for;
use crate::task::Entry;
use pfront_core::bvtt::TrianglePair;
use std::sync::Arc;

/// Two different bodies by their numbers.
pub type BodyPair = [u32; 2];

/// As many pairs as one run can tell apart.
#[derive(Debug)]
pub(super) struct Chunk {
    /// A row for each block of ids.
    pub(super) rows: Vec<Row>,
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
    /// The meshes of the bodies as they were when the question was asked.
    meshes: Arc<Vec<u32>>,
    shift: u32,
    /// The level of the BVTTs that is the first front.
    level: usize,
    /// The most rows of a chunk, and the most pairs.
    most: usize,
    most_pairs: usize,
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
        meshes: Arc<Vec<u32>>,
        pairs: &[BodyPair],
        [most_rows, most_pairs]: [usize; 2],
        is_each: bool,
    ) -> Self {
        let two = |pair| of_pair(arena, &meshes, pair);
        let count = |(asked, sum): (u64, u64), pair| match ids(two(pair)) {
            0 => (asked, sum),
            ids => (asked + 1, sum + ids),
        };
        let (asked, sum) = pairs.iter().fold((0, 0), count);
        // At most one block a pair on average and one more, most of which are in use.
        let shift = sum.div_ceil(asked.max(1)).max(1).next_power_of_two().ilog2();
        let most = most_rows.min(1 << (31 - shift)).min(groups_for(u32::MAX) as usize);
        // No balanced tree has more levels to offer, and no level has fewer nodes than the one above it.
        let deepest = if is_each { 0 } else { MOST_PAIRS.ilog2() as usize };
        let node_pairs =
            |level, pair| two(pair).map(|mesh| mesh.level(level).0.len()).iter().product::<usize>();
        let suits = |level: &usize| {
            let take = |left: usize, pair| left.checked_sub(node_pairs(*level, pair));
            pairs.iter().try_fold(MOST_PAIRS, take).is_some()
        };
        let level = (1..=deepest).take_while(suits).last().unwrap_or(0);
        Self { meshes, shift, level, most, most_pairs, next: 0 }
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
        mut rows: Vec<Row>,
    ) -> Option<Chunk> {
        let Self { meshes, shift, level, most, most_pairs, next } = self;
        let left = std::mem::replace(next, pairs.len());
        let is_asked = |pair| ids(of_pair(arena, meshes, pair)) != 0;
        let start = left + pairs[left..].iter().position(is_asked)?;
        let room = (pairs.len() - start).min(*most).min(*most_pairs);
        rows.clear();
        rows.reserve(room);
        let front = Vec::with_capacity(room);
        let mut chunk = Chunk { rows, shift: *shift, first: start, front, levels: 1 };
        for (number, pair) in pairs.iter().enumerate().skip(start) {
            let two = of_pair(arena, meshes, pair);
            let Some(last_id) = ids(two).checked_sub(1) else { continue };
            let blocks = (last_id >> *shift) as usize + 1;
            let is_full = chunk.rows.len() + blocks > *most || number - start >= *most_pairs;
            if !chunk.rows.is_empty() && is_full {
                *next = number;
                break;
            }
            let first_id = (chunk.rows.len() as u32) << *shift;
            let row = Row { bodies: *pair, number: (number - start) as u32, first_id };
            chunk.rows.extend(std::iter::repeat_n(row, blocks));
            let [(own, below_a), (others, below_b)] = two.map(|mesh| mesh.level(*level));
            let shift = first_id.wrapping_sub(two[0].first_node);
            for x in own.iter().map(|x| x.wrapping_add(shift)) {
                chunk.front.extend(others.iter().map(|&y| [x, y]));
            }
            chunk.levels = chunk.levels.max(below_a).max(below_b);
        }
        Some(chunk)
    }
}

/// The meshes of a pair of bodies.
fn of_pair<'a>(arena: &'a Arena, meshes: &[u32], pair: &BodyPair) -> [&'a ArenaMesh; 2] {
    pair.map(|body| &arena.meshes[meshes[body as usize] as usize])
}

/// Ids that a pair takes: none if a mesh is empty.
fn ids([a, b]: [&ArenaMesh; 2]) -> u64 {
    if b.ids == 0 { 0 } else { u64::from(a.ids) }
}

/// The number of the pair of bodies that a hit belongs to, and its triangles.
pub(super) fn hit(rows: &[Row], shift: u32, hit: TrianglePair) -> (usize, TrianglePair) {
    let row = &rows[(hit.a >> shift) as usize];
    (row.number as usize, TrianglePair { a: hit.a - row.first_id, b: hit.b })
}
