//! What both queries keep: buffers, lent out, and who walks, which is the core, several threads, or whoever a
//! planner picks.

mod alone;
#[cfg(feature = "gpu")]
mod device;
mod kept;
mod planned;
mod question;
mod ways;

pub(crate) use alone::{End, Leash, alone};
pub(crate) use question::{OfOne, OfTwo, Question};
pub(crate) use ways::{Given, Outcome, Want};

use crate::planner::{Plan, Planner};
use crate::{Accuracy, Adjacency, Error, Model};
use pfront_core::bvtt::{Query, TrianglePair};
use pfront_core::triangle::Contact;
use planned::Planned;
use std::ops::ControlFlow;
#[cfg(feature = "threads")]
use std::slice::from_ref;
use ways::on_one;

#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    #[cfg(feature = "threads")]
    pub(crate) traversal: Option<pfront_cpu::Traversal>,
    pub(crate) planning: Option<Planning>,
}

/// A question that costs no more box tests is small.
const SMALL: f64 = 250.0;
/// To refit so few triangles takes no longer than to think about it.
const FEW: usize = 128;

/// A planner, and what it knows once there was a question that was worth a thought.
#[derive(Clone, Debug)]
pub(crate) struct Planning {
    planner: Planner,
    planned: Option<Box<Planned>>,
    /// Whether the last question was not.
    was_small: bool,
}

impl Planning {
    pub(crate) fn new(planner: Planner) -> Self {
        Self { planner, planned: None, was_small: false }
    }

    pub(crate) fn plan(&self) -> Option<Plan> {
        match &self.planned {
            _ if self.was_small => Some(Plan::SMALL),
            planned => planned.as_ref()?.plan(),
        }
    }

    /// Moves the vertices of a model that will be asked about next.
    pub(crate) fn set_positions(
        &mut self,
        model: &mut Model,
        positions: &[[f32; 3]],
        adjacency: Adjacency,
        accuracy: Accuracy,
    ) -> Result<(), Error> {
        if model.mesh().triangles().len() <= FEW {
            return model.set_positions(positions);
        }
        self.planned().set_positions(model, positions, adjacency, accuracy)
    }

    fn planned(&mut self) -> &mut Planned {
        self.planned.get_or_insert_with(|| Box::new(Planned::new(self.planner.clone())))
    }

    /// Answers, if the question is worth a thought; into `pairs` if all are wanted.
    fn ask(
        &mut self,
        question: &impl Question,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Option<Given> {
        self.was_small = question.is_small();
        if self.was_small {
            // The list will be overwritten.
            self.planned.iter_mut().for_each(|planned| planned.forget());
            return None;
        }
        if self.planned.is_none() {
            // As long as nothing is larger, there is nothing to know.
            let leash = Leash { cost: SMALL, deadline: None };
            let query = question.query(question.accuracy());
            let brief = on_one(query, want, pairs, leash, |_, _| None);
            self.was_small = brief.end == End::Complete;
            if self.was_small {
                return Some(brief.given);
            }
        }
        Some(self.planned().ask(question, want, pairs))
    }
}

impl Answer {
    /// By a planner, if there is one that takes the question.
    fn plan_and_ask(&mut self, question: &impl Question, want: Want) -> Option<Given> {
        self.planning.as_mut()?.ask(question, want, &mut self.pairs)
    }

    /// All pairs, sorted. Allocates only when there are more than ever before.
    pub(crate) fn all(&mut self, question: &impl Question) -> &[TrianglePair] {
        if self.plan_and_ask(question, Want::All).is_some() {
            return &self.pairs;
        }
        let query = &question.query(question.accuracy());
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            traversal.all(from_ref(query), &mut self.pairs);
            return &self.pairs;
        }
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            self.pairs.push(pair);
            ControlFlow::Continue(())
        });
        self.pairs.sort_unstable();
        &self.pairs
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, question: &impl Question) -> u64 {
        if let Some(given) = self.plan_and_ask(question, Want::Count) {
            return given.count;
        }
        let query = &question.query(question.accuracy());
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            return traversal.count(from_ref(query));
        }
        query.count()
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, question: &impl Question) -> Option<TrianglePair> {
        if let Some(given) = self.plan_and_ask(question, Want::Any) {
            return given.first;
        }
        let query = &question.query(question.accuracy());
        #[cfg(feature = "threads")]
        if let Some(traversal) = &mut self.traversal {
            return traversal.any(from_ref(query)).map(|hit| hit.pair);
        }
        query.any()
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(&mut self, question: &impl Question) -> &[(TrianglePair, Contact)] {
        self.all(question);
        self.contacts.clear();
        let query = question.query(question.accuracy());
        let found = self.pairs.iter().filter_map(|&pair| Some((pair, query.contact(pair)?)));
        self.contacts.extend(found);
        &self.contacts
    }
}
