//! The answer about many bodies.

use super::pairs::{self, BodyPair};
use crate::GpuError;
use crate::memory::reserve;
use crate::runner::Runner;
use crate::task::GpuVerb;
use pfront_core::bvtt::TrianglePair;

/// The answer to a question.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorldAnswer {
    /// Pairs of triangles that meet, sorted, the first triangle being one of the first body: all of them, or at most one
    /// for [`GpuVerb::Any`]. Empty for the other verbs.
    pub hits: Vec<(BodyPair, TrianglePair)>,
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
        runner: &mut Runner,
        pairs: &[BodyPair],
        first: usize,
        shift: u32,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        self.count += runner.count;
        if matches!(verb, GpuVerb::All | GpuVerb::Any) {
            reserve(&mut self.hits, runner.pairs().len())?;
            each_list(runner, &pairs[first..], shift, |bodies, hits| {
                self.hits.extend(hits.iter().map(|&hit| (bodies, hit)));
            })?;
            return Ok(());
        }
        let rows = &runner.rows;
        let hits = || runner.pairs().iter().map(|&hit| pairs::hit(rows, shift, hit));
        match verb {
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => {}
            GpuVerb::AnyEach => hits().for_each(|(number, hit)| {
                self.each[first + number].get_or_insert(hit);
            }),
            GpuVerb::CountEach => {
                hits().for_each(|(number, _)| self.counts[first + number] += 1);
                let counts = self.counts[first..].iter_mut().zip(&runner.tallies);
                counts.for_each(|(count, own)| *count += own);
            }
        }
        Ok(())
    }
}

/// Calls back with the hits of each pair of bodies of a chunk, of which `pairs` begin with the first. Their ids become triangles.
pub(super) fn each_list(
    runner: &Runner,
    pairs: &[BodyPair],
    shift: u32,
    mut visit: impl FnMut(BodyPair, &[TrianglePair]),
) -> Result<(), GpuError> {
    let mut named = Vec::new();
    // The hits of a block of ids follow each other.
    for hits in runner.pairs().chunk_by(|x, y| x.a >> shift == y.a >> shift) {
        let row = &runner.rows[(hits[0].a >> shift) as usize];
        named.clear();
        reserve(&mut named, hits.len())?;
        named.extend(hits.iter().map(|hit| TrianglePair { a: hit.a - row.first_id, b: hit.b }));
        visit(pairs[row.number as usize], &named);
    }
    Ok(())
}
