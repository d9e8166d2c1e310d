//! The outcome of a submission: what a ticket and those who work for it share.

#[cfg(feature = "gpu")]
use super::shown::ShownLists;
use crate::Error;
use crate::environment::with_default;
use crate::executor::wait_in_pool;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};
use std::time::{Duration, Instant};

/// The outcome, once there is one.
#[derive(Debug)]
pub(crate) struct Outcome<T> {
    state: Mutex<State<T>>,
    known: Condvar,
    /// Nobody works on it any longer.
    cancel: Arc<AtomicBool>,
    #[cfg(feature = "gpu")]
    pub(crate) shown: ShownLists,
}

#[derive(Debug)]
enum State<T> {
    /// Not known, with the task that awaits it.
    Pending(Option<Waker>),
    Known(Result<T, Error>),
    /// Handed out.
    Read,
}

impl<T> Default for Outcome<T> {
    fn default() -> Self {
        Self {
            state: Mutex::new(State::Pending(None)),
            known: Condvar::new(),
            cancel: Arc::default(),
            #[cfg(feature = "gpu")]
            shown: ShownLists::default(),
        }
    }
}

impl<T> Outcome<T> {
    /// Makes the outcome known, if it is not, and wakes whoever waits. Threads that still work on it may stop.
    pub(crate) fn set(&self, outcome: Result<T, Error>) {
        let mut state = self.state();
        let State::Pending(waker) = &mut *state else { return };
        let waker = waker.take();
        *state = State::Known(outcome);
        drop(state);
        self.cancel.store(true, Relaxed);
        self.known.notify_all();
        if let Some(waker) = waker {
            waker.wake();
        }
    }

    /// Runs a part of the work in the default floating-point environment, in which an error or a panic is the outcome.
    pub(crate) fn guard<R>(&self, work: impl FnOnce() -> Result<R, Error>) -> Option<R> {
        // After a panic nobody looks at what the work has left.
        match catch_unwind(AssertUnwindSafe(|| with_default(work))) {
            Ok(Ok(done)) => return Some(done),
            Ok(Err(error)) => self.set(Err(error)),
            Err(_) => self.set(Err(Error::Panicked)),
        }
        None
    }

    /// Makes [`Error::Cancelled`] the outcome, unless it has been handed out.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Relaxed);
        let mut state = self.state();
        if matches!(*state, State::Read) {
            return;
        }
        let before = std::mem::replace(&mut *state, State::Known(Err(Error::Cancelled)));
        // An answer that nobody reads may take a while to drop.
        drop(state);
        self.known.notify_all();
        if let State::Pending(Some(waker)) = before {
            waker.wake();
        }
    }

    /// The flag that says that nobody needs to work on it.
    pub(crate) fn flag(&self) -> &Arc<AtomicBool> {
        &self.cancel
    }

    pub(crate) fn is_known(&self) -> bool {
        !matches!(*self.state(), State::Pending(_))
    }

    /// Hands out the outcome, if it is known.
    pub(crate) fn take(&self) -> Option<Result<T, Error>> {
        match &mut *self.state() {
            State::Pending(_) => None,
            state => Some(Self::hand_out(state)),
        }
    }

    /// The same for a task, which is woken when the outcome is known.
    pub(crate) fn poll(&self, task: &Waker) -> Poll<Result<T, Error>> {
        match &mut *self.state() {
            State::Pending(waker) => {
                waker.get_or_insert_with(|| task.clone()).clone_from(task);
                Poll::Pending
            }
            state => Poll::Ready(Self::hand_out(state)),
        }
    }

    /// An error is told as often as it is asked for.
    fn hand_out(state: &mut State<T>) -> Result<T, Error> {
        if let State::Known(Err(error)) = state {
            return Err(error.clone());
        }
        match std::mem::replace(state, State::Read) {
            State::Known(outcome) => outcome,
            State::Pending(_) | State::Read => Err(Error::AlreadyRead),
        }
    }

    /// Waits until the outcome is known, or for an instant. A thread of a rayon pool works on what waits in the pool, which
    /// may be what it waits for.
    pub(crate) fn wait(&self, until: Option<Instant>) {
        let left = || until.map(|until| until.saturating_duration_since(Instant::now()));
        loop {
            let most = left();
            if self.is_known() || most == Some(Duration::ZERO) {
                return;
            }
            let Some(most) = wait_in_pool(most.unwrap_or(Duration::MAX)) else { continue };
            let is_pending = |state: &mut State<T>| matches!(state, State::Pending(_));
            // A lock that a panic has poisoned guards a state that is whole.
            let _ = self.known.wait_timeout_while(self.state(), most, is_pending);
        }
    }

    /// Nothing panics under this lock.
    fn state(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(feature = "threads")]
#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::resume_unwind;

    #[test]
    fn a_panic_is_the_outcome_and_ends_all_work() {
        let outcome = Outcome::<u32>::default();
        assert_eq!(outcome.guard(|| Ok(1)), Some(1));
        assert!(!outcome.is_known() && !outcome.flag().load(Relaxed));
        assert_eq!(outcome.guard(|| -> Result<(), _> { resume_unwind(Box::new(0)) }), None);
        assert!(outcome.is_known() && outcome.flag().load(Relaxed));
        // Others come too late.
        outcome.set(Ok(1));
        for _ in 0..2 {
            assert_eq!(outcome.take().map(Result::err), Some(Some(Error::Panicked)));
        }
        outcome.cancel();
        assert_eq!(outcome.take().map(Result::err), Some(Some(Error::Cancelled)));
    }

    #[test]
    fn a_panic_of_a_thread_is_an_error_of_the_ticket() {
        let outcome = Arc::<Outcome<u32>>::default();
        let own = outcome.clone();
        crate::threads::Pool::new(2).spawn(move || {
            own.guard(|| -> Result<(), _> { resume_unwind(Box::new(0)) });
        });
        outcome.wait(None);
        assert_eq!(outcome.take().map(Result::err), Some(Some(Error::Panicked)));
    }
}
