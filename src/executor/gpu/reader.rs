//! The thread that answers the tickets of a GPU, one after the other.
//!
//! An executor has one, which starts with the first ticket and ends, and is joined, when the executor has gone and no ticket
//! is awaited any longer. It is never detached: inside a driver while the process ends, it would bring the process down. So
//! `exit`, which drops nothing, stops it as well, and waits a while for what the device works on.

use super::Hidden;
use crate::Error;
use crate::environment::with_default;
use crate::gpu::{Gpu, GpuError, wgpu};
use std::collections::VecDeque;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How long the end of a process waits for a device, and for the thread.
const PATIENCE: [Duration; 2] = [Duration::from_millis(1_000), Duration::from_millis(1_500)];

/// A ticket's work.
pub(crate) trait Work: Send {
    /// Submits what there are lists for, without waiting for the device. Returns whether anything is submitted that will be, so
    /// that the next ticket may begin.
    fn begin(&mut self) -> Result<bool, Error>;

    /// Answers the ticket, an error of `begin` being the answer. Work that was submitted in parts returns soon after the ticket's
    /// flag is set.
    fn finish(self: Box<Self>);
}

/// The thread as executors hold it: it ends after the tickets that are awaited when this is dropped.
#[derive(Debug)]
pub(crate) struct Reader(Arc<Shared>);

/// The thread as a ticket holds it.
#[derive(Debug)]
pub(crate) struct Seat(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    state: Mutex<ReaderState>,
    changed: Condvar,
    gpu: Hidden<Gpu>,
    /// The process that the thread belongs to. A child of `fork` has no such thread.
    process: u32,
}

#[derive(Debug, Default)]
struct ReaderState {
    waiting: VecDeque<Waiting>,
    /// The flag of the ticket that is being answered.
    current: Option<Arc<AtomicBool>>,
    /// Its work is a function of the caller's, which ends when it does.
    runs_function: bool,
    thread: Option<JoinHandle<()>>,
    is_running: bool,
    /// There is no executor any more.
    is_closed: bool,
    /// The process ends.
    is_exiting: bool,
}

/// A ticket that is not being answered yet.
struct Waiting {
    work: Box<dyn Work>,
    is_function: bool,
    has_begun: bool,
    /// Nobody awaits it any longer.
    is_over: Arc<AtomicBool>,
}

impl fmt::Debug for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Waiting").field("has_begun", &self.has_begun).finish_non_exhaustive()
    }
}

impl Reader {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self(Arc::new(Shared {
            state: Mutex::default(),
            changed: Condvar::new(),
            gpu: Hidden::new(gpu.clone()),
            process: process(),
        }))
    }

    /// Adds a ticket, whose flag says once it is set that nobody awaits it. It begins at once if all before it have.
    ///
    /// # Errors
    /// The error of `begin`; [`GpuError::Device`] if no thread can be started.
    pub(crate) fn add(&self, work: Box<dyn Work>, is_over: Arc<AtomicBool>) -> Result<Seat, Error> {
        self.push(work, false, is_over)
    }

    fn push(
        &self,
        mut work: Box<dyn Work>,
        is_function: bool,
        is_over: Arc<AtomicBool>,
    ) -> Result<Seat, Error> {
        let Self(shared) = self;
        let mut state = shared.lock();
        let may_begin = state.waiting.iter().all(|other| other.has_begun);
        let has_begun = may_begin && work.begin()?;
        Shared::start(shared, &mut state)?;
        state.waiting.push_back(Waiting { work, is_function, has_begun, is_over });
        drop(state);
        shared.changed.notify_all();
        Ok(Seat(shared.clone()))
    }

    /// Adds a ticket whose work is this function, of which nothing is submitted before its turn.
    ///
    /// # Errors
    /// [`GpuError::Device`] if no thread can be started.
    pub(crate) fn add_function(
        &self,
        run: Box<dyn FnOnce() + Send>,
        is_over: Arc<AtomicBool>,
    ) -> Result<Seat, Error> {
        self.push(Box::new(Function(run)), true, is_over)
    }

    /// Whether this is the thread, which cannot wait for itself.
    pub(crate) fn is_this_thread(&self) -> bool {
        let Self(shared) = self;
        let state = shared.lock();
        state.thread.as_ref().is_some_and(|own| own.thread().id() == thread::current().id())
    }
}

struct Function(Box<dyn FnOnce() + Send>);

impl Work for Function {
    fn begin(&mut self) -> Result<bool, Error> {
        Ok(true)
    }

    fn finish(self: Box<Self>) {
        (self.0)();
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        let Self(shared) = self;
        if shared.is_of_this_process() {
            shared.lock().is_closed = true;
            shared.changed.notify_all();
            shared.join_if_done();
        }
    }
}

impl Seat {
    /// Takes note that a ticket is not awaited any longer, whose flag is set.
    pub(crate) fn leave(&self) {
        let Self(shared) = self;
        if shared.is_of_this_process() {
            shared.join_if_done();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, ReaderState> {
        // Nothing is half done under this lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_of_this_process(&self) -> bool {
        self.process == process()
    }

    /// Starts the thread, if it does not run.
    fn start(shared: &Arc<Self>, state: &mut ReaderState) -> Result<(), GpuError> {
        if state.is_running {
            return Ok(());
        }
        end::register(shared);
        let own = shared.clone();
        let thread = thread::Builder::new().name("pfront tickets".to_owned()).spawn(move || {
            // A thread begins in the environment of the one that starts it.
            let _ = catch_unwind(AssertUnwindSafe(|| with_default(|| own.answer_all())));
            own.lock().is_running = false;
            own.changed.notify_all();
        });
        let thread = thread.map_err(|error| GpuError::Device { reason: error.to_string() })?;
        (state.thread, state.is_running) = (Some(thread), true);
        Ok(())
    }

    /// The thread.
    fn answer_all(&self) {
        let mut state = self.lock();
        loop {
            state.current = None;
            if state.is_exiting {
                let left = std::mem::take(&mut state.waiting);
                drop(state);
                drop(left);
                return wait_until_idle(&self.gpu);
            }
            let Some(Waiting { work, is_function, is_over, .. }) = state.waiting.pop_front() else {
                if state.is_closed {
                    return;
                }
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            // The device works on the next ones while this one is read.
            for next in &mut state.waiting {
                // An error is the outcome when its turn comes.
                next.has_begun = next.has_begun
                    || next.is_over.load(Relaxed)
                    || next.work.begin().unwrap_or(true);
                if !next.has_begun {
                    break;
                }
            }
            (state.current, state.runs_function) = (Some(is_over.clone()), is_function);
            drop(state);
            // A panic is the outcome of its ticket.
            let _ = catch_unwind(AssertUnwindSafe(|| match is_over.load(Relaxed) {
                true => drop(work),
                false => work.finish(),
            }));
            state = self.lock();
        }
    }

    /// Joins the thread, if there is no executor any more and no ticket is awaited.
    fn join_if_done(&self) {
        let mut state = self.lock();
        let mut awaited =
            state.waiting.iter().map(|waiting| &waiting.is_over).chain(&state.current);
        // A function may wait for whoever is here: then the thread ends by itself, and `exit` waits for it.
        let runs_function = state.current.is_some() && state.runs_function;
        let is_awaited = !awaited.all(|is_over| is_over.load(Relaxed));
        if !state.is_closed || runs_function || is_awaited {
            return;
        }
        let thread = state.thread.take();
        drop(state);
        // It may be this thread that drops the last ticket, in a waker: then it ends by itself.
        if let Some(thread) = thread.filter(|own| own.thread().id() != thread::current().id()) {
            let _ = thread.join();
        }
    }

    /// Ends the thread, with whatever it has to do, and waits for that a while.
    fn exit(&self) {
        if !self.is_of_this_process() {
            return;
        }
        let until = Instant::now() + PATIENCE[1];
        let mut state = self.lock();
        state.is_exiting = true;
        let awaited = state.waiting.iter().map(|waiting| &waiting.is_over).chain(&state.current);
        awaited.for_each(|is_over| is_over.store(true, Relaxed));
        self.changed.notify_all();
        while state.is_running {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            let waited = self.changed.wait_timeout(state, left);
            (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
        let thread = state.thread.take();
        drop(state);
        if let Some(thread) = thread {
            let _ = thread.join();
        }
    }
}

/// The number of this process.
#[cfg(not(target_arch = "wasm32"))]
fn process() -> u32 {
    std::process::id()
}

/// There is no other, and the standard library does not tell its number.
#[cfg(target_arch = "wasm32")]
fn process() -> u32 {
    0
}

/// Waits a while until the device has done all that was submitted.
fn wait_until_idle(gpu: &Gpu) {
    let until = Instant::now() + PATIENCE[0];
    let is_done = Arc::new(AtomicBool::new(false));
    let own = is_done.clone();
    gpu.queue().on_submitted_work_done(move || own.store(true, Relaxed));
    while !is_done.load(Relaxed) && Instant::now() < until {
        // Wgpu panics where it finds that the device is lost.
        let polled = catch_unwind(AssertUnwindSafe(|| gpu.device().poll(wgpu::PollType::Poll)));
        if !matches!(polled, Ok(Ok(_))) {
            return;
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// The end of the process.
mod end {
    use super::{Arc, Mutex, PoisonError, Shared, Weak};

    /// Threads that may run.
    static RUNNING: Mutex<Vec<Weak<Shared>>> = Mutex::new(Vec::new());

    /// Has a thread stopped when the process exits.
    pub(super) fn register(shared: &Arc<Shared>) {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.retain(|other| other.strong_count() > 0);
        running.push(Arc::downgrade(shared));
        drop(running);
        call_at_exit();
    }

    /// Calls [`stop`] when the process exits. The last that is registered is called first: so each thread registers it anew, after
    /// its driver has been loaded, and before the driver's own end it is called.
    #[cfg(not(target_arch = "wasm32"))]
    #[expect(unsafe_code, reason = "a function of C, which takes a function that never unwinds")]
    fn call_at_exit() {
        unsafe extern "C" {
            safe fn atexit(function: extern "C" fn()) -> core::ffi::c_int;
        }
        // Without memory for it nothing is lost but this.
        let _ = atexit(stop);
    }

    #[cfg(target_arch = "wasm32")]
    fn call_at_exit() {
        let _: extern "C" fn() = stop;
    }

    extern "C" fn stop() {
        // A panic must not reach C.
        let _ = std::panic::catch_unwind(|| {
            // A child of `fork` may find it locked for ever, and has no threads.
            let running = match RUNNING.try_lock() {
                Ok(running) => running.clone(),
                Err(_) => return,
            };
            for shared in running.iter().filter_map(Weak::upgrade) {
                shared.exit();
                // The process ends: no device is closed on a thread that has lost its variables.
                std::mem::forget(shared);
            }
        });
    }
}
