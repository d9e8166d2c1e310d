//! Ends questions that the calling thread answers itself, if they take long: it hears no signals meanwhile.
//!
//! One thread of the process looks at all of them from time to time, so that a question costs two list entries and not a
//! thread of its own.

use crate::executor::lock;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{process, thread};

/// How long a question may take on the thread that asks it.
pub(crate) const BRIEF: Duration = Duration::from_millis(5);
/// The time between two looks.
const TICK: Duration = Duration::from_millis(2);
/// Looks that find no question, after which the thread sleeps until there is one.
const IDLE: u32 = 200;

/// The watch of this process. It is locked only by threads that hold the interpreter, as the one that forks does.
static OWN: Mutex<Option<(u32, Arc<Watch>)>> = Mutex::new(None);

#[derive(Default)]
struct Watch {
    questions: Mutex<Questions>,
    wake: Condvar,
}

#[derive(Default)]
struct Questions {
    asleep: bool,
    /// The id of the next question.
    next: u64,
    /// Questions by id, since when they are asked, and the flags that end them.
    asked: Vec<(u64, Instant, Arc<AtomicBool>)>,
}

/// A question that is watched until this is dropped.
pub(crate) struct Watched {
    id: u64,
    watch: Arc<Watch>,
}

impl Watched {
    /// Watches a question that begins now; `None` if there is no thread to be had.
    pub(crate) fn new(cancel: &Arc<AtomicBool>) -> Option<Self> {
        let watch = {
            let mut own = lock(&OWN);
            match &*own {
                Some((process, watch)) if *process == process::id() => watch.clone(),
                _ => {
                    let watch = Arc::<Watch>::default();
                    let watching = watch.clone();
                    let thread = thread::Builder::new().name("pfront watch".into());
                    thread.spawn(move || watching.look()).ok()?;
                    // The watch of a parent is left as it is: its thread is not here.
                    std::mem::forget(own.replace((process::id(), watch.clone())));
                    watch
                }
            }
        };
        let mut questions = lock(&watch.questions);
        let id = questions.next;
        questions.next += 1;
        questions.asked.push((id, Instant::now(), cancel.clone()));
        if std::mem::take(&mut questions.asleep) {
            watch.wake.notify_one();
        }
        drop(questions);
        Some(Self { id, watch })
    }
}

/// No flag is set from here on.
impl Drop for Watched {
    fn drop(&mut self) {
        lock(&self.watch.questions).asked.retain(|&(id, ..)| id != self.id);
    }
}

impl Watch {
    fn look(&self) {
        let mut idle = 0;
        loop {
            thread::sleep(TICK);
            let mut questions = lock(&self.questions);
            for (_, since, cancel) in &questions.asked {
                if since.elapsed() > BRIEF {
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
