//! A frame, from which its plan is made if anyone asks.

use super::Concession;
use super::history::{Choice, Way};
use super::plan::{Backend, Plan, Reason};
use std::time::Duration;

#[derive(Clone, Copy, Debug)]
pub(super) struct Last {
    pub(super) backend: Backend,
    pub(super) reason: Reason,
    pub(super) choice: Choice,
    pub(super) cost: Option<f64>,
    pub(super) actual: Duration,
    pub(super) concession: Option<Concession>,
}

impl Last {
    /// A frame that has been decided about and not yet answered.
    pub(super) fn new(choice: Choice, reason: Reason) -> Self {
        let (backend, actual) = (choice.way.into(), Duration::ZERO);
        Self { backend, reason, choice, cost: None, actual, concession: None }
    }

    pub(super) fn plan(&self) -> Plan {
        let Self { backend, reason, choice, cost, actual, concession } = *self;
        let time = |nanoseconds: f64| Duration::from_nanos(nanoseconds as u64);
        Plan {
            backend,
            reason,
            expected_cost: choice.expected,
            cost,
            predicted: choice.time().map(time),
            alternatives: choice.times.map(|t| t.map(time)),
            actual,
            concession,
            ..Plan::SMALL
        }
    }
}

impl From<Way> for Backend {
    fn from(way: Way) -> Self {
        match way {
            Way::Alone => Self::Sequential,
            Way::Threads(workers) => Self::Threads { workers },
            Way::Gpu => Self::Gpu,
        }
    }
}
