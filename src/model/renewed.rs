//! A value that is brought up to date when somebody asks for it, in the memory that it had.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// A value that follows something else: up to date, out of date, or not made yet.
///
/// Asking for one that is up to date costs a look at an atomic. Whoever asks first for one that is not
/// brings it up to date, and whoever asks meanwhile waits. Bringing it up to date must not wait for another
/// thread, which might be one that waits here: no rayon.
#[derive(Debug)]
pub(super) struct Renewed<T> {
    fresh: OnceLock<T>,
    /// `None` as soon as somebody is at it.
    stale: Mutex<Option<T>>,
}

impl<T> Renewed<T> {
    pub(super) fn new(fresh: T) -> Self {
        Self { fresh: OnceLock::from(fresh), stale: Mutex::new(None) }
    }

    /// A value that is not made yet.
    pub(super) fn unmade() -> Self {
        Self { fresh: OnceLock::new(), stale: Mutex::new(None) }
    }

    /// The value, once `renew` has made it of what it was, if it was anything.
    #[inline]
    pub(super) fn get(&self, renew: impl FnOnce(Option<T>) -> T) -> &T {
        self.fresh.get_or_init(|| {
            let stale = self.stale().take();
            renew(stale)
        })
    }

    /// The value, if it is up to date.
    pub(super) fn fresh(&self) -> Option<&T> {
        self.fresh.get()
    }

    /// What `f` says of the value, up to date or not; `None` if it is not made or somebody is at it.
    pub(super) fn map<R>(&self, f: impl Fn(&T) -> R) -> Option<R> {
        let of_stale = self.stale().as_ref().map(&f);
        of_stale.or_else(|| self.fresh.get().map(f))
    }

    /// The value, from now on out of date.
    pub(super) fn outdate(&mut self) -> Option<&mut T> {
        let stale = self.stale.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(fresh) = self.fresh.take() {
            *stale = Some(fresh);
        }
        stale.as_mut()
    }

    /// From now on the value, if it is made, is up to date.
    pub(super) fn renewed(&mut self) {
        let stale = self.stale.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = stale.take() {
            self.fresh = OnceLock::from(value);
        }
    }

    /// Nothing is ever half done under this lock, whoever panics.
    fn stale(&self) -> MutexGuard<'_, Option<T>> {
        self.stale.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Not made, if somebody is at it.
impl<T: Clone> Clone for Renewed<T> {
    fn clone(&self) -> Self {
        let stale = self.stale().clone();
        let fresh = if stale.is_none() { self.fresh.clone() } else { OnceLock::new() };
        Self { fresh, stale: Mutex::new(stale) }
    }
}
