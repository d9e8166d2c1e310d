//! The answer about many bodies.

use super::pairs::{self, Bodies};
use crate::GpuError;
use crate::answer::Answer;
use crate::memory::reserve;
use crate::task::GpuVerb;
use pfront_core::bvtt::TrianglePair;

/// The answer to a question.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorldAnswer {
    /// Pairs of triangles that meet, sorted, the first triangle being one of the first body: all of them, or at most one
    /// for [`GpuVerb::Any`]. Empty for the other verbs.
    pub hits: Vec<(Bodies, TrianglePair)>,
    /// For [`GpuVerb::AnyEach`], some hit of each pair of bodies that meet, in the order of the
    /// question. Else empty.
    pub each: Vec<Option<TrianglePair>>,
    /// For [`GpuVerb::CountEach`], how many hits each pair of bodies has. Else empty.
    pub counts: Vec<u64>,
    /// How many hits were found.
    pub count: u64,
}

impl WorldAnswer {
    /// The answer to nothing, in the same memory.
    pub(super) fn clear(&mut self) {
        let Self { hits, each, counts, count } = self;
        hits.clear();
        each.clear();
        counts.clear();
        *count = 0;
    }

    /// Adds what was found of a chunk of pairs, of which this is the first.
    pub(super) fn add(
        &mut self,
        answer: &mut Answer,
        pairs: &[Bodies],
        first: usize,
        shift: u32,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        self.count += answer.count;
        if matches!(verb, GpuVerb::All | GpuVerb::Any) {
            reserve(&mut self.hits, answer.pairs.len())?;
            visit(answer, &pairs[first..], shift, |bodies, hits| {
                self.hits.extend(hits.iter().map(|&hit| (bodies, hit)));
            });
            return Ok(());
        }
        let rows = &answer.instances;
        let hits = || answer.pairs.iter().map(|&hit| pairs::hit(rows, shift, hit));
        match verb {
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => {}
            GpuVerb::AnyEach => hits().for_each(|(number, hit)| {
                self.each[first + number].get_or_insert(hit);
            }),
            GpuVerb::CountEach => {
                hits().for_each(|(number, _)| self.counts[first + number] += 1);
                let counts = self.counts[first..].iter_mut().zip(&answer.tallies);
                counts.for_each(|(count, own)| *count += own);
            }
        }
        Ok(())
    }
}

/// Calls back with the hits of each pair of bodies of a chunk, of which `pairs` begin with the first. Their ids become triangles.
pub(super) fn visit(
    answer: &mut Answer,
    pairs: &[Bodies],
    shift: u32,
    mut visit: impl FnMut(Bodies, &[TrianglePair]),
) {
    // The hits of a block of ids follow each other.
    for hits in answer.pairs.chunk_by_mut(|x, y| x.a >> shift == y.a >> shift) {
        let row = &answer.instances[(hits[0].a >> shift) as usize];
        hits.iter_mut().for_each(|hit| hit.a -= row.first_id);
        visit(pairs[row.number as usize], hits);
    }
}
