//! A scene on several threads.

use super::frame::{Frame, Given};
use super::{BodyId, SceneHit};
use crate::answer::Want;
use crate::threads::{Hit, Report, Traversal};
use crate::{Error, Model};
use pfront_core::bvtt::PairQuery;
use std::ops::ControlFlow;

/// The most pairs of bodies that are asked at once. Each takes a query and a node of the front, some 800 bytes,
/// so that all of them take 50 MiB at most, however many pairs a frame has.
const BATCH: usize = 1 << 16;

#[derive(Clone, Debug)]
pub(super) struct Crew {
    pub(super) traversal: Traversal,
    /// The bodies of each query of the last batch: what it cost is remembered by its number.
    asked: Vec<[BodyId; 2]>,
    /// The bodies of each query of this batch.
    asking: Vec<[BodyId; 2]>,
    /// Empty, to use its memory again.
    queries: Vec<PairQuery<'static>>,
    found: Vec<Hit>,
    report: Report,
}

impl Crew {
    pub(super) fn new(mut traversal: Traversal) -> Self {
        // What it did before was asked of other bodies.
        traversal.forget();
        let (asked, asking, queries, found) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { traversal, asked, asking, queries, found, report: Report::default() }
    }

    /// All batches of the last frame together.
    pub(super) fn report(&self) -> &Report {
        &self.report
    }

    pub(super) fn set_positions(
        &self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        self.traversal.install(|| model.set_positions_with_threads(positions))
    }

    /// Answers; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask(&mut self, frame: &Frame<'_>, want: Want, hits: &mut Vec<SceneHit>) -> Given {
        let hit = |asked: &[[BodyId; 2]], hit: Hit| SceneHit {
            bodies: asked[hit.query as usize],
            pair: hit.pair,
        };
        match want {
            Want::All => {
                let mut found = std::mem::take(&mut self.found);
                self.each_batch(frame, |traversal, asked, queries| {
                    traversal.all(queries, &mut found);
                    hits.extend(found.iter().map(|&found| hit(asked, found)));
                    ControlFlow::Continue(())
                });
                self.found = found;
                Given::listed(hits)
            }
            Want::Count => {
                let mut count = 0;
                self.each_batch(frame, |traversal, _, queries| {
                    count += traversal.count(queries);
                    ControlFlow::Continue(())
                });
                Given::counted(count)
            }
            Want::Any => {
                let mut first = None;
                self.each_batch(frame, |traversal, asked, queries| {
                    first = traversal.any(queries).map(|found| hit(asked, found));
                    if first.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                });
                Given::found(first)
            }
        }
    }

    /// Asks the queries of a frame in batches of at most [`BATCH`], until `ask` breaks or time runs out.
    fn each_batch(
        &mut self,
        frame: &Frame<'_>,
        mut ask: impl FnMut(&mut Traversal, &[[BodyId; 2]], &[PairQuery<'_>]) -> ControlFlow<()>,
    ) {
        let mut queries: Vec<PairQuery<'_>> = std::mem::take(&mut self.queries);
        let mut rest = frame.queries().peekable();
        let mut is_first = true;
        loop {
            self.asking.clear();
            for (bodies, query) in rest.by_ref().take(BATCH) {
                self.asking.push(bodies);
                queries.push(query);
            }
            let is_last = rest.peek().is_none();
            if is_first && is_last {
                self.renumber();
            } else {
                // What other pairs of bodies cost tells nothing of these.
                self.traversal.forget();
                std::mem::swap(&mut self.asked, &mut self.asking);
            }
            let end = ask(&mut self.traversal, &self.asked, &queries);
            queries.clear();
            if is_first {
                self.report.clone_from(&self.traversal.report);
            } else {
                self.report.add(&self.traversal.report);
            }
            if is_last || end.is_break() || self.report.late {
                break;
            }
            is_first = false;
        }
        // An empty vector of one lifetime becomes one of another, in place.
        self.queries = queries.into_iter().map_while(|_| None).collect();
    }

    /// Makes the bodies of this frame those of the last, and keeps what is remembered of pairs that are in both.
    fn renumber(&mut self) {
        if self.asking == self.asked {
            return;
        }
        // Both ascend, so that one pass finds them all.
        let mut rest = (0..).zip(&self.asking).peekable();
        let number = |bodies: &[BodyId; 2]| {
            while rest.next_if(|(_, new)| *new < bodies).is_some() {}
            rest.next_if(|(_, new)| *new == bodies).map(|(number, _)| number)
        };
        let numbers: Vec<_> = self.asked.iter().map(number).collect();
        self.traversal.renumber(|old| numbers[old as usize]);
        std::mem::swap(&mut self.asked, &mut self.asking);
    }
}
