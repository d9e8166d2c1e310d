//! Ends questions that the calling thread answers itself, if they take long: it hears no signals meanwhile.
//!
//! One thread of the process looks at all of them from time to time, so that a question costs two list entries and not a
//! thread of its own.

use crate::lock::lock;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::{mem, process, thread};

/// How long a question may take on the thread that asks it.
pub(crate) const BUDGET: Duration = Duration::from_millis(5);
/// The time between two looks.
const TICK: Duration = Duration::from_millis(2);
/// Looks that find no question, after which the thread sleeps until there is one.
const IDLE: u32 = 200;

/// The watchdog of this process. It is locked only by threads that hold the interpreter.
static OWN: Mutex<Option<Own>> = Mutex::new(None);

struct Own {
    process: u32,
    watchdog: Arc<Watchdog>,
    thread: JoinHandle<()>,
}

#[derive(Default)]
struct Watchdog {
    questions: Mutex<Questions>,
    wake: Condvar,
}

#[derive(Default)]
struct Questions {
    asleep: bool,
    /// Whether the process ends.
    ended: bool,
    /// The id of the next question.
    next: u64,
    /// Questions by id, since when they are asked, and the flags that end them.
    asked: Vec<(u64, Instant, Arc<AtomicBool>)>,
}

/// A question that is watched until this is dropped.
pub(crate) struct WatchdogGuard {
    id: u64,
    watchdog: Arc<Watchdog>,
}

impl WatchdogGuard {
    /// Watches a question that begins now; `None` if there is no thread to be had.
    pub(crate) fn new(cancel: &Arc<AtomicBool>) -> Option<Self> {
        let watchdog = {
            let mut own = lock(&OWN);
            match &*own {
                Some(own) if own.process == process::id() => own.watchdog.clone(),
                _ => {
                    let watchdog = Arc::<Watchdog>::default();
                    let watching = watchdog.clone();
                    let thread = thread::Builder::new().name("pfront watchdog".into());
                    let thread = thread.spawn(move || watching.look()).ok()?;
                    let new = Own { process: process::id(), watchdog: watchdog.clone(), thread };
                    // The watchdog of a parent is left as it is: its thread is not here.
                    mem::forget(own.replace(new));
                    watchdog
                }
            }
        };
        let mut questions = lock(&watchdog.questions);
        let id = questions.next;
        questions.next += 1;
        questions.asked.push((id, Instant::now(), cancel.clone()));
        if mem::take(&mut questions.asleep) {
            watchdog.wake.notify_one();
        }
        drop(questions);
        Some(Self { id, watchdog })
    }
}

/// No flag is set from here on.
impl Drop for WatchdogGuard {
    fn drop(&mut self) {
        lock(&self.watchdog.questions).asked.retain(|&(id, ..)| id != self.id);
    }
}

/// Ends the thread and waits for that.
pub(crate) fn end() {
    let own = lock(&OWN).take();
    if let Some(own) = own {
        if own.process == process::id() {
            let mut questions = lock(&own.watchdog.questions);
            (questions.ended, questions.asleep) = (true, false);
            own.watchdog.wake.notify_one();
            drop(questions);
            let _ = own.thread.join();
        } else {
            mem::forget(own);
        }
    }
}

impl Watchdog {
    fn look(&self) {
        let mut idle = 0;
        loop {
            thread::sleep(TICK);
            let mut questions = lock(&self.questions);
            if questions.ended {
                return;
            }
            for (_, since, cancel) in &questions.asked {
                if since.elapsed() > BUDGET {
                    cancel.store(true, Relaxed);
                }
            }
            idle = if questions.asked.is_empty() { idle + 1 } else { 0 };
            if idle > IDLE {
                questions.asleep = true;
                while questions.asleep {
                    questions = self.wake.wait(questions).unwrap_or_else(PoisonError::into_inner);
                }
                idle = 0;
            }
        }
    }
}
