//! A mutex that belongs to the process whose thread has locked it.
//!
//! A fork copies a mutex as it is. If another thread had locked it, nobody in the child is there to unlock it, and what it
//! guards may be half changed: the child is told so, where the mutex of the standard library would wait for ever.

use crate::errors::forked;
use crate::lock::lock;
use crate::threads::{PATIENCE, apart};
use pyo3::prelude::*;
use std::sync::atomic::{
    AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};
use std::{process, thread};

/// The shortest and the longest time between two attempts to lock.
const PAUSES: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(1)];

#[derive(Default)]
pub(crate) struct ProcessMutex<T> {
    /// The process whose thread has locked it; 0 if it is free.
    holder: AtomicU32,
    /// Locked only while `holder` is this process, by the thread that has set it, so that nobody waits for it.
    value: Mutex<T>,
}

/// Unlocks when it is dropped, on whichever thread.
pub(crate) struct ProcessGuard<T> {
    of: Arc<ProcessMutex<T>>,
}

impl<T> From<T> for ProcessMutex<T> {
    fn from(value: T) -> Self {
        Self { holder: AtomicU32::new(0), value: Mutex::new(value) }
    }
}

impl<T: Send> ProcessMutex<T> {
    /// Waits for the lock, while signals are heard.
    ///
    /// # Errors
    /// The exception that a signal raised; a RuntimeError if another thread had the lock when this process was forked.
    pub(crate) fn lock(self: &Arc<Self>, py: Python<'_>) -> PyResult<ProcessGuard<T>> {
        let own = process::id();
        let mut pause = PAUSES[0];
        loop {
            match self.holder.compare_exchange(0, own, Acquire, Relaxed) {
                Ok(_) => return Ok(ProcessGuard { of: self.clone() }),
                Err(holder) if holder != own => return Err(forked()),
                Err(_) => {}
            }
            apart(py, || {
                let began = Instant::now();
                while self.holder.load(Relaxed) == own && began.elapsed() < PATIENCE / 2 {
                    thread::sleep(pause);
                    pause = (2 * pause).min(PAUSES[1]);
                }
            });
            py.check_signals()?;
        }
    }
}

impl<T> ProcessGuard<T> {
    pub(crate) fn get(&self) -> MutexGuard<'_, T> {
        lock(&self.of.value)
    }
}

impl<T> Drop for ProcessGuard<T> {
    fn drop(&mut self) {
        self.of.holder.store(0, Release);
    }
}
