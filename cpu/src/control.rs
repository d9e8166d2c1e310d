//! The early end of a traversal: at a break, at a deadline, or when it is cancelled.

use crate::output::Output;
use pfront_core::bvtt::{Cursor, Query};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Instant;

/// Tests between two looks at the clock, at the cancel flag and at whether another worker has stopped: about 0.1 ms.
pub(crate) const SLICE: u64 = 4096;

/// State that all threads of a frame share.
#[derive(Debug)]
pub(crate) struct Control {
    stop: AtomicBool,
    late: AtomicBool,
    cancelled: AtomicBool,
    deadline: Option<Instant>,
    cancel: Option<Arc<AtomicBool>>,
}

impl Control {
    pub(crate) fn new(deadline: Option<Instant>, cancel: Option<Arc<AtomicBool>>) -> Self {
        let [stop, late, cancelled] = [false; 3].map(AtomicBool::new);
        Self { stop, late, cancelled, deadline, cancel }
    }

    /// Whether a visitor broke, the frame was cancelled or the deadline is past.
    pub(crate) fn is_over(&self) -> bool {
        if self.cancel.as_ref().is_some_and(|cancel| cancel.load(Relaxed)) {
            self.cancelled.store(true, Relaxed);
            self.stop.store(true, Relaxed);
        }
        if self.stop.load(Relaxed) {
            return true;
        }
        let is_late = self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if is_late {
            self.late.store(true, Relaxed);
            self.stop.store(true, Relaxed);
        }
        is_late
    }

    /// Whether it ended before there was nothing left.
    pub(crate) fn has_stopped(&self) -> bool {
        self.stop.load(Relaxed)
    }

    pub(crate) fn was_late(&self) -> bool {
        self.late.load(Relaxed)
    }

    pub(crate) fn was_cancelled(&self) -> bool {
        self.cancelled.load(Relaxed)
    }

    /// Traverses from `cursor` in slices, until it is done, has done `most` tests since it was made, all is over, or there
    /// was a hit and the thread `is_wanted` elsewhere.
    pub(crate) fn traverse<Q: Query>(
        &self,
        query: &Q,
        number: u32,
        cursor: &mut Cursor,
        output: &mut impl Output,
        most: u64,
        is_wanted: &impl Fn() -> bool,
    ) {
        while !cursor.is_done() && !self.is_over() {
            let left = most.saturating_sub(cursor.work.tests());
            if left == 0 {
                break;
            }
            let end = query.step(cursor, left.min(SLICE), |pair| {
                if self.has_stopped() {
                    return ControlFlow::Break(());
                }
                if output.add(number, pair).is_break() {
                    self.stop.store(true, Relaxed);
                    return ControlFlow::Break(());
                }
                // A visitor may take any time.
                if is_wanted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            if end.is_break() {
                break;
            }
        }
    }
}
