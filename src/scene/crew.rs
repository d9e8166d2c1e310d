//! A scene on several threads.

use super::frame::{Frame, Given};
use super::{BodyId, SceneHit};
use crate::answer::Want;
use crate::threads::{Hit, Report, Traversal};
use crate::{Error, Model};
use pfront_core::bvtt::PairQuery;

#[derive(Clone, Debug)]
pub(super) struct Crew {
    pub(super) traversal: Traversal,
    /// The bodies of each query of the last frame: what it cost is remembered by its number.
    asked: Vec<[BodyId; 2]>,
    /// Those of this frame.
    asking: Vec<[BodyId; 2]>,
    /// Empty, to use its memory again.
    queries: Vec<PairQuery<'static>>,
    found: Vec<Hit>,
}

impl Crew {
    pub(super) fn new(traversal: Traversal) -> Self {
        let (asked, asking, queries, found) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { traversal, asked, asking, queries, found }
    }

    pub(super) fn report(&self) -> &Report {
        self.traversal.report()
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
        match want {
            Want::All => {
                let mut found = std::mem::take(&mut self.found);
                self.at_once(frame, |traversal, queries| traversal.all_of(queries, &mut found));
                hits.extend(found.iter().map(|&hit| self.hit(hit)));
                self.found = found;
                Given::listed(hits)
            }
            Want::Count => Given::counted(
                self.at_once(frame, |traversal, queries| traversal.count_of(queries)),
            ),
            Want::Any => {
                let found = self.at_once(frame, |traversal, queries| traversal.any_of(queries));
                Given::found(found.map(|hit| self.hit(hit)))
            }
        }
    }

    /// Asks all queries of a frame at once.
    fn at_once<R>(
        &mut self,
        frame: &Frame<'_>,
        verb: impl FnOnce(&mut Traversal, &[PairQuery<'_>]) -> R,
    ) -> R {
        let mut queries: Vec<PairQuery<'_>> = std::mem::take(&mut self.queries);
        self.asking.clear();
        for (bodies, query) in frame.queries() {
            self.asking.push(bodies);
            queries.push(query);
        }
        if self.asking != self.asked {
            // Both ascend, so that one pass finds them all.
            let mut rest = (0..).zip(&self.asking).peekable();
            self.traversal.renumber(|old| {
                let bodies = &self.asked[old as usize];
                while rest.next_if(|(_, new)| *new < bodies).is_some() {}
                rest.next_if(|(_, new)| *new == bodies).map(|(number, _)| number)
            });
            std::mem::swap(&mut self.asked, &mut self.asking);
        }
        let answer = verb(&mut self.traversal, &queries);
        queries.clear();
        // An empty vector of one lifetime becomes one of another, in place.
        self.queries = queries.into_iter().map_while(|_| None).collect();
        answer
    }

    fn hit(&self, hit: Hit) -> SceneHit {
        SceneHit { bodies: self.asked[hit.query as usize], pair: hit.pair }
    }
}
