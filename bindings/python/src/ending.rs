//! Threads of the interpreter at the end of the process.
//!
//! An interpreter that is being finalised ends each thread that wants it back (before CPython 3.14), by unwinding its stack.
//! Unwinding aborts the process where frames of Rust are on the stack. So once the process ends, all threads but the one that
//! ends it stop for ever as soon as they are here without the interpreter, and [`wait`] lets those that are not come this far.

use pyo3::prelude::*;
use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// The thread that ends the process, once it does.
static LAST: OnceLock<ThreadId> = OnceLock::new();
/// Threads that are here without the interpreter or in a function of the caller's, and those of them that have stopped.
static INSIDE: AtomicUsize = AtomicUsize::new(0);
static STOPPED: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// How many [`Inside`] this thread has.
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

/// Frames of this module's callers on the stack of a thread that is without the interpreter, or may lose it.
pub(crate) struct Inside(());

impl Inside {
    pub(crate) fn enter() -> Self {
        let depth = DEPTH.get();
        if depth == 0 {
            INSIDE.fetch_add(1, Relaxed);
        }
        DEPTH.set(depth + 1);
        Self(())
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        let depth = DEPTH.get() - 1;
        DEPTH.set(depth);
        if depth == 0 {
            INSIDE.fetch_sub(1, Relaxed);
        }
    }
}

/// Does not return on other threads than the one that ends the process, once it does. Called without the interpreter.
pub(crate) fn stop_if_ending() {
    if LAST.get().is_some_and(|last| *last != thread::current().id()) {
        STOPPED.fetch_add(1, Relaxed);
        loop {
            thread::park();
        }
    }
}

/// Takes note that this thread ends the process.
pub(crate) fn begin() {
    LAST.get_or_init(|| thread::current().id());
}

/// Waits until all other threads have stopped or are in Python, or for an instant. Called without the interpreter.
pub(crate) fn wait(until: Instant) {
    while INSIDE.load(Relaxed) > STOPPED.load(Relaxed) && Instant::now() < until {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Forgets the threads of the parent, in a child of `fork`.
#[pyfunction]
pub fn forked() {
    INSIDE.store(usize::from(DEPTH.get() > 0), Relaxed);
    STOPPED.store(0, Relaxed);
}
