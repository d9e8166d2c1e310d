//! A batch that is submitted again and again, and its tickets, which are read late, cancelled or dropped.

use super::executors::{Executors, QueryExecutor};
use super::models::{Shape, somewhere};
use super::truth::{Answer, Answers};
use pfront::{Adjacency, Batch, Error, PairLists, Ticket, TrianglePair};
use pfront_testkit::rng::{Rng, RngExt};
use std::rc::Rc;
use std::time::Duration;

/// The most tickets of a batch that are not read.
const FLYING: usize = 12;

enum Flying {
    All(Ticket<PairLists>),
    Count(Ticket<Vec<u64>>),
    Any(Ticket<Vec<Option<TrianglePair>>>),
}

/// A batch, the answers to its questions, and those to the questions of its tickets.
pub(crate) struct BatchPlayer {
    pub(crate) seat: QueryExecutor,
    batch: Batch,
    asked: Vec<Rc<Answer>>,
    flying: Vec<(Flying, Vec<Rc<Answer>>)>,
}

impl BatchPlayer {
    pub(crate) fn new(seat: QueryExecutor) -> Self {
        Self { seat, batch: Batch::new(), asked: Vec::new(), flying: Vec::new() }
    }

    /// Submits a batch or reads a ticket.
    pub(crate) fn play(
        &mut self,
        executors: &Executors,
        shapes: &[Shape],
        answers: &mut Answers,
        rng: &mut impl Rng,
    ) {
        if self.flying.len() < FLYING && (self.flying.is_empty() || rng.random()) {
            self.submit(executors, shapes, answers, rng);
        } else {
            let (ticket, truth) = self.flying.swap_remove(rng.random_range(0..self.flying.len()));
            read(ticket, &truth, rng);
        }
    }

    fn submit(
        &mut self,
        executors: &Executors,
        shapes: &[Shape],
        answers: &mut Answers,
        rng: &mut impl Rng,
    ) {
        if self.batch.len() > 6 || rng.random_range(0..3) == 0 {
            self.batch.clear();
            self.asked.clear();
        }
        for _ in 0..rng.random_range(0..4) {
            let [a, b] = [0; 2].map(|_| &shapes[rng.random_range(0..shapes.len())]);
            if rng.random_range(0..4) == 0 {
                let adjacency = [Adjacency::default(), Adjacency::SkipNeighbours];
                let adjacency = adjacency[rng.random_range(0..2)];
                self.batch.itself(&a.model, adjacency);
                self.asked.push(answers.within(&a.fresh, adjacency));
            } else {
                let pose = somewhere(rng);
                self.batch.pair(&a.model, &b.model, pose).unwrap();
                self.asked.push(answers.pair([&a.fresh, &b.fresh], &pose));
            }
        }
        let executor = executors.executor(self.seat);
        let ticket = match rng.random_range(0..3) {
            0 => Flying::All(self.batch.all(executor).unwrap()),
            1 => Flying::Count(self.batch.count(executor).unwrap()),
            _ => Flying::Any(self.batch.any(executor).unwrap()),
        };
        self.flying.push((ticket, self.asked.clone()));
    }
}

/// Reads a ticket in some way, and compares.
fn read(ticket: Flying, truth: &[Rc<Answer>], rng: &mut impl Rng) {
    match ticket {
        Flying::All(ticket) => {
            let Some(lists) = brought(ticket, rng) else { return };
            assert!(lists.iter().eq(truth.iter().map(|answer| &answer.pairs[..])));
        }
        Flying::Count(ticket) => {
            let Some(counts) = brought(ticket, rng) else { return };
            assert!(counts.into_iter().eq(truth.iter().map(|answer| answer.pairs.len() as u64)));
        }
        Flying::Any(ticket) => {
            let Some(found) = brought(ticket, rng) else { return };
            assert_eq!(found.len(), truth.len());
            for (any, Answer { pairs, .. }) in found.iter().zip(truth.iter().map(Rc::as_ref)) {
                let is_right =
                    any.map_or(pairs.is_empty(), |pair| pairs.binary_search(&pair).is_ok());
                assert!(is_right, "{any:?} of {pairs:?}");
            }
        }
    }
}

/// The answer that a ticket brings, unless it is cancelled or dropped.
fn brought<T>(mut ticket: Ticket<T>, rng: &mut impl Rng) -> Option<T> {
    match rng.random_range(0..8) {
        0 => return None,
        1 => {
            ticket.cancel();
            assert_eq!(ticket.read().err(), Some(Error::Cancelled));
            return None;
        }
        2 => {
            while !ticket.is_ready() {
                std::thread::yield_now();
            }
            let found = ticket.try_read().unwrap();
            assert_eq!(ticket.try_read().err(), Some(Error::AlreadyRead));
            return found;
        }
        3 => loop {
            if let Some(found) = ticket.wait(Duration::from_micros(100)).unwrap() {
                return Some(found);
            }
        },
        4 => return Some(pollster::block_on(ticket).unwrap()),
        _ => {}
    }
    Some(ticket.read().unwrap())
}
