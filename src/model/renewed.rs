//! A value that is brought up to date when somebody asks for it, in the memory that it had.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// A value that follows something else: up to date, out of date, or not made yet.
///
/// Asking for one that is up to date costs a look at an atomic. The first thread that asks for one that is not
/// brings it up to date, and others that ask meanwhile wait. Bringing it up to date must not wait for another
/// thread, which might be one that waits here: no rayon.
#[derive(Debug)]
pub(super) struct Renewed<T> {
    /// In a box, since there are two places for it.
    fresh: OnceLock<Box<T>>,
    /// `None` as soon as somebody is at it.
    stale: Mutex<Option<Box<T>>>,
}

impl<T> Renewed<T> {
    pub(super) fn new(fresh: T) -> Self {
        Self { fresh: OnceLock::from(Box::new(fresh)), stale: Mutex::new(None) }
    }

    /// A value that is not made yet.
    pub(super) fn unmade() -> Self {
        Self { fresh: OnceLock::new(), stale: Mutex::new(None) }
    }

    /// The value, if it is up to date.
    #[inline]
    pub(super) fn fresh(&self) -> Option<&T> {
        self.fresh.get().map(AsRef::as_ref)
    }

    /// The value, after it has been renewed or made, if need be.
    pub(super) fn get(&self, renew: impl FnOnce(&mut T), make: impl FnOnce() -> T) -> &T {
        self.fresh.get_or_init(|| {
            let stale = self.stale().take();
            match stale {
                Some(mut value) => {
                    renew(&mut value);
                    value
                }
                None => Box::new(make()),
            }
        })
    }

    /// [`Renewed::get`] of a value that cannot always be made: `None` if `make` returns it, which is called again then whenever
    /// somebody asks.
    pub(super) fn try_get(
        &self,
        renew: impl FnOnce(&mut T),
        make: impl FnOnce() -> Option<T>,
    ) -> Option<&T>
    where
        T: Default,
    {
        if let Some(fresh) = self.fresh() {
            return Some(fresh);
        }
        // Another thread may be at it, which is then waited for.
        let made = if self.map(|_| ()).is_some() { T::default() } else { make()? };
        Some(self.get(renew, || made))
    }

    /// The result of `f` for the value, up to date or not; `None` if it is not made or somebody is at it.
    pub(super) fn map<R>(&self, f: impl Fn(&T) -> R) -> Option<R> {
        let of_stale = self.stale().as_deref().map(&f);
        of_stale.or_else(|| self.fresh.get().map(|value| f(value)))
    }

    pub(super) fn fresh_mut(&mut self) -> Option<&mut T> {
        self.fresh.get_mut().map(AsMut::as_mut)
    }

    /// The value, if it is out of date.
    pub(super) fn stale_mut(&mut self) -> Option<&mut T> {
        self.as_stale().as_deref_mut()
    }

    /// From now on the value, if it is made, is out of date.
    pub(super) fn outdate(&mut self) {
        if let Some(value) = self.fresh.take() {
            *self.as_stale() = Some(value);
        }
    }

    /// From now on the value, if it is made, is up to date.
    pub(super) fn renewed(&mut self) {
        if let Some(value) = self.as_stale().take() {
            self.fresh = OnceLock::from(value);
        }
    }

    fn as_stale(&mut self) -> &mut Option<Box<T>> {
        self.stale.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// Nothing is ever half done under this lock, whoever panics.
    fn stale(&self) -> MutexGuard<'_, Option<Box<T>>> {
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
