//! Questions: on the thread that asks as long as they are short, else on a thread of their own, while signals are heard.

use crate::errors::exception;
use crate::executor::{Device, Executor};
use crate::threads::{PATIENCE, apart, heard};
use crate::watchdog::WatchdogGuard;
use pfront::executor::Plan;
use pfront::{Error, Ticket};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// An answer, and who gave it: one thread, if there is no plan.
pub(crate) type Answered<T> = Result<(T, Option<Plan>), Error>;

/// Asks, and notes who has answered: see [`answer`].
pub(crate) fn ask<T: Send + 'static>(
    py: Python<'_>,
    on: &Executor,
    cancel: &Arc<AtomicBool>,
    is_long: bool,
    question: impl Fn(&pfront::Executor) -> Answered<T> + Send + Sync + 'static,
) -> PyResult<T> {
    let (told, plan) = answer(py, on, cancel, is_long, question)?;
    on.note(plan.as_ref());
    Ok(told)
}

/// The answer to a question, and who gave it. A question that takes long on the calling thread is ended by the flag and asked again on a
/// thread of its own; one that is known to take long goes there at once, and so does one that might wait for a device, or for
/// threads that others use. Only who calls this sets and clears the flag.
///
/// # Errors
/// The exception of the error, or the one that a signal raised.
pub(crate) fn answer<T: Send + 'static>(
    py: Python<'_>,
    on: &Executor,
    cancel: &Arc<AtomicBool>,
    is_long: bool,
    question: impl Fn(&pfront::Executor) -> Answered<T> + Send + Sync + 'static,
) -> PyResult<(T, Option<Plan>)> {
    cancel.store(false, Relaxed);
    let executor = on.on_device(py)?.with_cancel(cancel.clone());
    let made = on.made(py);
    let is_short = !is_long && on.device == Device::Cpu && !made.is_busy();
    if is_short && let Some(watched) = WatchdogGuard::new(cancel) {
        let answered = apart(py, || {
            let answered = question(&executor);
            // Before the flag is for another question.
            drop(watched);
            answered
        });
        if !matches!(answered, Err(Error::Cancelled)) {
            return answered.map_err(|error| exception(py, error, None));
        }
        cancel.store(false, Relaxed);
        py.check_signals()?;
    }
    let work = made.use_pool();
    let answered = heard(py, cancel, move || {
        let _work = work;
        question(&executor)
    });
    answered?.map_err(|error| exception(py, error, None))
}

/// Waits for a ticket, while signals are heard, and notes who has answered; a ticket that is dropped is cancelled.
pub(crate) fn wait<T: Send>(py: Python<'_>, on: &Executor, mut ticket: Ticket<T>) -> PyResult<T> {
    let (plan, made) = (ticket.plan(0), on.made(py));
    let work = made.use_pool();
    loop {
        match apart(py, || ticket.wait(PATIENCE)) {
            Ok(None) => {}
            Ok(Some(answer)) => {
                on.note(plan.as_ref());
                return Ok(answer);
            }
            Err(error) => return Err(exception(py, error, None)),
        }
        if let Err(signal) = py.check_signals() {
            drop(ticket);
            made.leave(work);
            return Err(signal);
        }
    }
}
