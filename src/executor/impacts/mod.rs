//! Impacts: which triangles of some subjects meet while these move, whether any do, how many, and when first, on the CPU of an executor.

mod front;
#[cfg(all(test, feature = "threads"))]
mod tests;
mod tree;

pub(crate) use front::{MovingSubjects, SubjectNodePair};
pub(crate) use tree::{AT_START, AnyMovingBvtt};

use super::Named;
use crate::memory::push;
use crate::{Error, Impact};
use front::Below;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

impl<'q, N, S, T> MovingSubjects<'_, N, S, T>
where
    N: Copy + Ord,
    S: Copy + PartialEq + Send + Sync,
    T: Fn(S) -> Option<(N, AnyMovingBvtt<'q>)> + Sync,
{
    /// Adds all pairs that meet to a list, in no order.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Memory`], or [`Error::Panicked`] for a thread of a pool.
    pub(crate) fn all<F: Named<Name = N>>(self, all: &mut Vec<(F, Impact)>) -> Result<(), Error> {
        let list = |name, below: &mut Below<'_, '_>, out: &mut Vec<(F, Impact)>| {
            let mut pushed = Ok(());
            below.visit(f64::INFINITY, |pair, impact| {
                pushed = push(out, (F::new(name, pair), impact));
                match pushed.is_ok() {
                    true => ControlFlow::Continue(f64::INFINITY),
                    false => ControlFlow::Break(()),
                }
            })?;
            pushed.map(ControlFlow::Continue)
        };
        self.each(None, list, all)
    }

    /// How many pairs certainly meet, and how many do or are open.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub(crate) fn count(self) -> Result<[u64; 2], Error> {
        let counts = [AtomicU64::new(0), AtomicU64::new(0)];
        let add = |_, below: &mut Below<'_, '_>, _: &mut Vec<()>| {
            let (mut proven, mut all) = (0, 0);
            below.visit(f64::INFINITY, |_, impact| {
                proven += u64::from(impact.is_proven());
                all += 1;
                ControlFlow::Continue(f64::INFINITY)
            })?;
            counts[0].fetch_add(proven, Relaxed);
            counts[1].fetch_add(all, Relaxed);
            Ok(ControlFlow::Continue(()))
        };
        self.each(None, add, &mut Vec::new())?;
        Ok(counts.map(AtomicU64::into_inner))
    }

    /// A pair that certainly meets, the first that is found; if there is none, one that is open, if any is.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub(crate) fn any<F: Named<Name = N>>(self) -> Result<Option<(F, Impact)>, Error> {
        let found = Mutex::new(None);
        let search = |name, below: &mut Below<'_, '_>, _: &mut Vec<()>| {
            let mut end = ControlFlow::Continue(());
            below.visit(f64::INFINITY, |pair, impact| {
                let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
                if found.is_none() || impact.is_proven() {
                    *found = Some((F::new(name, pair), impact));
                }
                if impact.is_proven() {
                    end = ControlFlow::Break(());
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(f64::INFINITY)
            })?;
            Ok(end)
        };
        self.each(None, search, &mut Vec::new())?;
        Ok(found.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// The pair that meets first, by time, then by the name of its subject, then by the pair; or `known`, if that comes before all. Subjects ascend by
    /// the time before which nothing of them meets.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub(crate) fn first<F: Named<Name = N>>(
        self,
        known: Option<(F, Impact)>,
    ) -> Result<Option<(F, Impact)>, Error> {
        let best = Mutex::new(known);
        let best = || best.lock().unwrap_or_else(PoisonError::into_inner);
        let time = |hit: Option<(F, Impact)>| hit.map_or(f64::INFINITY, |(_, impact)| impact.from);
        let limit = || time(*best());
        let search = |name, below: &mut Below<'_, '_>, _: &mut Vec<()>| {
            let mut own = *best();
            // Among hits at the same time, that of the first name counts.
            let is_before =
                |(hit, impact): (F, Impact)| impact.from <= below.from && hit.name() < name;
            if own.is_some_and(is_before) {
                return Ok(ControlFlow::Continue(()));
            }
            below.visit(time(own), |pair, impact| {
                own = earlier(own, Some((F::new(name, pair), impact)));
                ControlFlow::Continue(time(own))
            })?;
            let mut best = best();
            *best = earlier(*best, own);
            Ok(ControlFlow::Continue(()))
        };
        self.each(Some(&limit), search, &mut Vec::new())?;
        let first = *best();
        Ok(first)
    }
}

/// The first of two, by time and then by the hit.
fn earlier<F: Named>(p: Option<(F, Impact)>, q: Option<(F, Impact)>) -> Option<(F, Impact)> {
    let is_first = |p: &(F, Impact), q: &(F, Impact)| (p.1.from, p.0) <= (q.1.from, q.0);
    match (p, q) {
        (Some(p), Some(q)) => Some(if is_first(&p, &q) { p } else { q }),
        (p, q) => p.or(q),
    }
}
