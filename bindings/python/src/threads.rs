//! Work without the interpreter, and threads that work while the one that asks hears signals.
//!
//! A thread that a signal leaves behind goes on until it sees its flag, or to its end: it has all that it needs, and nobody
//! waits for what it makes. All threads are listed here, so that [`join`] can wait for them before the process ends.

use crate::ending::{self, Inside, stop_if_ending};
use crate::lock::lock;
use crate::watchdog;
use pfront::pfront_core::environment::with_default;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{mem, process, thread};

/// The time between two looks at signals while others work.
pub(crate) const PATIENCE: Duration = Duration::from_millis(10);
/// The longest time that the end of the process waits for threads.
const LAST: Duration = Duration::from_millis(1500);

/// The id of the next thread.
static NEXT: AtomicU64 = AtomicU64::new(0);
/// All threads that have not been joined. It is locked only by threads that hold the interpreter.
static RUNNING: Mutex<Vec<Worker>> = Mutex::new(Vec::new());

struct Worker {
    id: u64,
    process: u32,
    cancel: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

/// Calls a function without the interpreter, in the default floating-point environment.
pub(crate) fn apart<T: Send>(py: Python<'_>, call: impl FnOnce() -> T + Send) -> T {
    let _inside = Inside::enter();
    py.detach(|| {
        stop_if_ending();
        let answer = with_default(call);
        stop_if_ending();
        answer
    })
}

/// Calls a function on a thread of its own, while this one hears signals. A signal that raises sets the flag, and leaves the
/// thread behind if it does not end at once.
pub(crate) fn heard<T: Send + 'static>(
    py: Python<'_>,
    cancel: &Arc<AtomicBool>,
    call: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    heard_as(py, "pfront worker", cancel, call)
}

/// The same on a thread of this name, which the threads of a driver take over that is opened there.
pub(crate) fn heard_as<T: Send + 'static>(
    py: Python<'_>,
    name: &str,
    cancel: &Arc<AtomicBool>,
    call: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (tell, answer) = channel();
    // Nobody else waits for it: the lock is for the compiler, which knows receivers of one thread only.
    let answer = Mutex::new(answer);
    let work = move || {
        // Nobody listens any more after a signal.
        let _ = tell.send(with_default(call));
    };
    let thread = thread::Builder::new().name(name.into()).spawn(work);
    let thread = thread.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let id = NEXT.fetch_add(1, Relaxed);
    let process = process::id();
    lock(&RUNNING).push(Worker { id, process, cancel: cancel.clone(), thread });
    let wait = || apart(py, || lock(&answer).recv_timeout(PATIENCE));
    let heard = loop {
        match wait() {
            Ok(answer) => break Ok(answer),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(signal) = py.check_signals() {
                    cancel.store(true, Relaxed);
                    let _ = wait();
                    break Err(signal);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                break Err(PyRuntimeError::new_err("a thread panicked while it answered"));
            }
        }
    };
    let is_answered = heard.is_ok();
    for worker in take(|worker| worker.id == id && is_answered || worker.thread.is_finished()) {
        // It has told its answer, and has nothing left to do.
        let _ = apart(py, || worker.thread.join());
    }
    heard
}

/// Takes threads of this process off the list. The threads of a parent are not here.
fn take(mut is_taken: impl FnMut(&Worker) -> bool) -> Vec<Worker> {
    let mut running = lock(&RUNNING);
    let process = process::id();
    let (own, others): (Vec<_>, Vec<_>) =
        mem::take(&mut *running).into_iter().partition(|worker| worker.process == process);
    mem::forget(others);
    let (taken, left) = own.into_iter().partition(|worker| is_taken(worker));
    *running = left;
    taken
}

/// Ends all questions and waits for their threads, which must not be inside a driver when the process ends; called by `atexit`.
/// Others that are still at work after [`LAST`] end with the process.
#[pyfunction]
pub fn join(py: Python<'_>) {
    ending::begin();
    watchdog::end();
    let workers = take(|_| true);
    workers.iter().for_each(|worker| worker.cancel.store(true, Relaxed));
    py.detach(|| {
        let began = Instant::now();
        for worker in workers {
            while !worker.thread.is_finished() && began.elapsed() < LAST {
                thread::sleep(Duration::from_millis(1));
            }
            if worker.thread.is_finished() {
                let _ = worker.thread.join();
            }
        }
        ending::wait(began + LAST);
    });
}
