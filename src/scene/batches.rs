//! A scene on several threads.

use super::frame::{Answer, Frame};
use super::{BodyId, SceneHit};
use crate::Error;
use crate::executor::{BLOCK, Verb, check};
use crate::memory::{extend, push, reserve};
use crate::threads::{Hit, Report, Traversal};
use pfront_core::bvtt::PairBvtt;

/// The most pairs of bodies that are asked at once. Each takes a query and a node of the front, some 1,300 bytes,
/// so that all of them take 85 MiB at most, however many pairs a frame has.
const BATCH: usize = 1 << 16;

/// The history of a scene on threads.
#[derive(Clone, Debug, Default)]
pub(super) struct Batches {
    /// The bodies of each query of the last batch: what it cost is remembered by its number.
    asked: Vec<[BodyId; 2]>,
    /// The bodies of each query of this batch.
    asking: Vec<[BodyId; 2]>,
    /// Empty, to use its memory again.
    queries: Vec<PairBvtt<'static>>,
    found: Vec<Hit>,
}

impl Batches {
    /// Answers; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask(
        &mut self,
        traversal: &mut Traversal,
        frame: &Frame<'_>,
        verb: Verb,
        hits: &mut Vec<SceneHit>,
    ) -> Result<Answer, Error> {
        let hit = |asked: &[[BodyId; 2]], hit: Hit| SceneHit {
            bodies: asked[hit.query as usize],
            pair: hit.pair,
        };
        Ok(match verb {
            Verb::All => {
                let mut found = std::mem::take(&mut self.found);
                self.each_batch(traversal, frame, |traversal, asked, queries| {
                    traversal.all(queries, &mut found)?;
                    found.chunks(BLOCK).try_for_each(|block| {
                        check(traversal.cancel.as_deref())?;
                        extend(hits, block.iter().map(|&found| hit(asked, found)))
                    })
                })?;
                self.found = found;
                Answer::listed(hits)
            }
            Verb::Count => {
                let mut count = 0;
                self.each_batch(traversal, frame, |traversal, _, queries| {
                    count += traversal.count(queries)?;
                    Ok(())
                })?;
                Answer::counted(count)
            }
            Verb::Any => {
                let mut first = None;
                let mut queries: Vec<PairBvtt<'_>> = std::mem::take(&mut self.queries);
                // Batches grow, so that not much more is prepared than is asked.
                let (mut rest, mut size) = (frame.queries(), 1);
                while first.is_none() && !traversal.report.cancelled {
                    self.asking.clear();
                    for (bodies, query) in rest.by_ref().take(size) {
                        push(&mut self.asking, bodies)?;
                        push(&mut queries, query)?;
                    }
                    if queries.is_empty() {
                        break;
                    }
                    first = traversal.any(&queries)?.map(|found| hit(&self.asking, found));
                    queries.clear();
                    size = (4 * size).min(BATCH);
                }
                self.queries = emptied(queries);
                Answer::found(first)
            }
        })
    }

    /// Asks the queries of a frame in batches of at most [`BATCH`], until time runs out or the flag is set. The report of the
    /// traversal is then that of all batches together.
    fn each_batch(
        &mut self,
        traversal: &mut Traversal,
        frame: &Frame<'_>,
        mut ask: impl FnMut(&mut Traversal, &[[BodyId; 2]], &[PairBvtt<'_>]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut queries: Vec<PairBvtt<'_>> = std::mem::take(&mut self.queries);
        let mut rest = frame.queries().peekable();
        let mut before: Option<Report> = None;
        loop {
            self.asking.clear();
            for (bodies, query) in rest.by_ref().take(BATCH) {
                push(&mut self.asking, bodies)?;
                push(&mut queries, query)?;
            }
            let is_last = rest.peek().is_none();
            if before.is_none() && is_last {
                self.renumber(traversal)?;
            } else {
                // The costs of other pairs of bodies tell nothing of these.
                traversal.forget();
                std::mem::swap(&mut self.asked, &mut self.asking);
            }
            ask(traversal, &self.asked, &queries)?;
            queries.clear();
            if let Some(mut report) = before.take() {
                report.add(&traversal.report);
                traversal.report = report;
            }
            if is_last || traversal.report.late || traversal.report.cancelled {
                break;
            }
            before = Some(traversal.report.clone());
        }
        self.queries = emptied(queries);
        Ok(())
    }

    /// Makes the bodies of this frame those of the last, and keeps what is remembered of pairs that are in both.
    fn renumber(&mut self, traversal: &mut Traversal) -> Result<(), Error> {
        if self.asking == self.asked {
            return Ok(());
        }
        // Both ascend, so that one pass finds them all.
        let mut rest = (0..).zip(&self.asking).peekable();
        let number = |bodies: &[BodyId; 2]| {
            while rest.next_if(|(_, new)| *new < bodies).is_some() {}
            rest.next_if(|(_, new)| *new == bodies).map(|(number, _)| number)
        };
        let mut numbers = Vec::new();
        reserve(&mut numbers, self.asked.len())?;
        numbers.extend(self.asked.iter().map(number));
        traversal.renumber(|old| numbers[old as usize]);
        std::mem::swap(&mut self.asked, &mut self.asking);
        Ok(())
    }
}

/// An empty vector of one lifetime becomes one of another, in place.
fn emptied(queries: Vec<PairBvtt<'_>>) -> Vec<PairBvtt<'static>> {
    queries.into_iter().map_while(|_| None).collect()
}
