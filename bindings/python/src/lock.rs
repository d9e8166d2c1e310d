//! Locking a mutex of this process.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a mutex, after a panic too: nothing that is guarded here is left in pieces by one.
///
/// Threads lock a mutex of the process only while they hold the interpreter, as a thread that forks does: no fork catches it
/// locked.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
