//! Pairs of bodies as the passes know them.
//!
//! The first half of a node pair, leaf pair or triangle pair says which pair of bodies it belongs to: each has a run of ids
//! of its own, as long as the first mesh has nodes or triangles. So fronts and lists hold two words an entry, as those of two
//! meshes do, and sorted hits are in the order of the pairs. A run takes whole blocks of ids, and each
//! block has a row that tells all about its pair: finding it takes a shift, where a search among
//! prefix sums would take a dozen loads that wait for each other. Rows hold the poses, and not where these are: one load
//! less, and a body that moves costs the device nothing, since rows are written for each question anyway.

use super::Bodies;
use super::arena::{Arena, ArenaMesh, MOST_PAIRS, entries};
use super::placing::{Inverse, Placed, place};
use crate::engine::Entry;
use crate::layout::InstancePair;
use pfront_core::bvtt::TrianglePair;
use pfront_core::{Aabb, Pose};

/// A body: the number of its mesh, and where it is.
pub(super) type Body = (u32, Pose);

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

/// Divides pairs into chunks of at most so many rows and 2^31 ids, the first of them last.
///
/// With `is_each`, node pairs are roots; else a first front has work for many workgroups, however few the pairs are.
pub(super) fn chunks(
    arena: &Arena,
    bodies: &[Body],
    pairs: &[Bodies],
    most_rows: usize,
    is_each: bool,
) -> Vec<Chunk> {
    let meshes = |pair: &Bodies| pair.map(|body| &arena.meshes[bodies[body as usize].0 as usize]);
    let ids = |pair: &Bodies| {
        let [a, b] = meshes(pair);
        if b.ids == 0 { 0 } else { u64::from(a.ids) }
    };
    let asked = pairs.iter().filter(|pair| ids(pair) != 0).count() as u64;
    if asked == 0 {
        return Vec::new();
    }
    // At most one block a pair on average and one more, most of which are in use.
    let mean = pairs.iter().map(ids).sum::<u64>().div_ceil(asked);
    let shift = mean.next_power_of_two().ilog2();
    let most = most_rows.min(1 << (31 - shift));
    let mut chunks: Vec<Chunk> = Vec::new();
    let mut first: Option<(u32, Placed, Option<Inverse>)> = None;
    for (number, pair) in pairs.iter().enumerate().filter(|(_, pair)| ids(pair) != 0) {
        let blocks = (ids(pair) >> shift) as usize + usize::from(ids(pair) % (1 << shift) != 0);
        let has_room = |chunk: &Chunk| chunk.rows.len() + blocks <= most;
        if !chunks.last().is_some_and(has_room) {
            let (rows, front) = (Vec::new(), Vec::new());
            chunks.push(Chunk { rows, shift, first: number, front, levels: 1 });
        }
        let Some(chunk) = chunks.last_mut() else { break };
        let two = meshes(pair);
        let placed = |side: usize| {
            let bounds = two[side].bounds.unwrap_or(Aabb::EMPTY);
            Placed::new(&bodies[pair[side] as usize].1, &bounds)
        };
        let (_, a, inverse) = match &mut first {
            Some(known) if known.0 == pair[0] => known,
            none => {
                let own = placed(0);
                none.insert((pair[0], own, own.inverse()))
            }
        };
        let row = InstancePair {
            number: (number - chunk.first) as u32,
            first_id: (chunk.rows.len() as u32) << shift,
            first_node: two[0].first_node,
            first_slot: two[0].first_slot,
            ..place(a, inverse.as_ref(), &placed(1))
        };
        chunk.rows.extend(std::iter::repeat_n(row, blocks));
    }
    let ends: Vec<_> =
        chunks.iter().skip(1).map(|chunk| chunk.first).chain([pairs.len()]).collect();
    for (chunk, end) in chunks.iter_mut().zip(ends) {
        chunk.add_front(&pairs[chunk.first..end], meshes, is_each);
    }
    chunks.reverse();
    chunks
}

impl Chunk {
    fn add_front<'a>(
        &mut self,
        pairs: &[Bodies],
        meshes: impl Fn(&Bodies) -> [&'a ArenaMesh; 2],
        is_each: bool,
    ) {
        let node_pairs = |level: usize| -> usize {
            let of_pair =
                |pair| meshes(pair).map(|mesh| mesh.level(level).0.len()).iter().product::<usize>();
            pairs.iter().map(of_pair).sum::<usize>()
        };
        // No balanced tree has more levels to offer.
        let deepest = if is_each { 0 } else { MOST_PAIRS.ilog2() as usize };
        let level = (1..=deepest).rev().find(|&level| node_pairs(level) <= MOST_PAIRS).unwrap_or(0);
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
