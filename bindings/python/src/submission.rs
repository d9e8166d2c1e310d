//! Questions that threads or a GPU answer.

use crate::errors::exception;
use crate::executor::{Device, Executor, Made};
use crate::threads::{PATIENCE, apart};
use pfront::Ticket;
use pfront::executor::Backend;
use pyo3::prelude::*;

/// Who is to answer questions that are submitted.
pub(crate) struct Submission {
    pub(crate) executor: pfront::Executor,
    made: Made,
    /// Whether a GPU was asked for, and does not answer such a question.
    is_for_cpu: bool,
}

impl Submission {
    /// A GPU answers about two models, and about one in float32, if one was asked for; all else is for the threads. Without
    /// earlier frames, "auto" is the CPU.
    pub(crate) fn new(py: Python<'_>, on: &Executor, is_for_cpu: bool) -> PyResult<Self> {
        let is_for_gpu = on.device == Device::Gpu && !is_for_cpu;
        let executor = if is_for_gpu { on.on_device(py)? } else { on.made(py).cpu };
        let is_for_cpu = on.device == Device::Gpu && is_for_cpu;
        Ok(Self { executor, made: on.made(py), is_for_cpu })
    }

    /// Waits for a ticket, while signals are heard, and notes who has answered; a ticket that is dropped is cancelled.
    pub(crate) fn wait<T: Send>(
        &self,
        py: Python<'_>,
        on: &Executor,
        mut ticket: Ticket<T>,
    ) -> PyResult<T> {
        let (plan, work) = (ticket.plan(0), self.made.use_pool());
        loop {
            let answer = apart(py, || ticket.wait(PATIENCE));
            if let Some(answer) = answer.map_err(|error| exception(py, error, None))? {
                if let Some(plan) = plan {
                    on.note(self.in_words(plan.backend));
                }
                return Ok(answer);
            }
            if let Err(signal) = py.check_signals() {
                drop(ticket);
                self.made.leave(work);
                return Err(signal);
            }
        }
    }

    fn in_words(&self, backend: Backend) -> String {
        let mut words = match (backend, &self.made.pool) {
            (Backend::Threads, Some(pool)) => format!("{} threads", pool.current_num_threads()),
            _ => backend.to_string(),
        };
        if self.is_for_cpu {
            words += ": a GPU is not asked about one mesh in float64";
        }
        words
    }
}
