//! Any question, asked by another thread.

use super::{Outcome, Planned, Ticket};
use crate::executor::{Backend, Reason};
use crate::{Error, Executor};
use std::sync::Arc;

impl Executor {
    /// Has whatever `ask` asks asked in the background, and returns at once: a scene, a mesh that deforms, several questions one
    /// after the other. The queries go with it, and come back by the ticket with whatever it returns; they keep what they remember, so
    /// that asking them again for what they have just found costs nothing. They are lost with a ticket that is dropped or
    /// cancelled, and after a panic, which is [`Error::Panicked`].
    ///
    /// On threads, one of the pool begins, and queries of the same executor divide their frames among all of them. With a GPU that
    /// answers everything, its thread for tickets asks, after the tickets that were submitted before. On one thread, nobody else
    /// can: whoever polls, waits for or reads the ticket does all of the work then, whatever the timeout. So it is for a ticket that
    /// the thread of a GPU submits, from within `ask`. `ask` runs in the default floating-point environment.
    ///
    /// Cancelling or dropping the ticket ends what has not begun. Work that has begun goes on to its end, unless the queries' own executor
    /// has a flag, see [`Executor::with_cancel`].
    ///
    /// # Errors
    /// `Error::Gpu` if the thread for tickets of a GPU cannot be started.
    ///
    /// # Examples
    /// ```
    /// use pfront::{Error, Executor, Model, Pose, SceneQuery};
    /// # let tile = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// # let tile = std::sync::Arc::new(tile);
    /// let executor = Executor::threads(4);
    /// let mut scene = SceneQuery::new().on(&executor);
    /// let bodies = [scene.add(tile.clone(), Pose::IDENTITY)?, scene.add(tile, Pose::IDENTITY)?];
    /// for frame in 0..3 {
    ///     scene.set_pose(bodies[1], Pose::from_translation([0.6 * frame as f32, 0.0, 0.0]))?;
    ///     let ticket = executor.submit(move || {
    ///         scene.update()?;
    ///         Ok::<_, Error>(scene)
    ///     })?;
    ///     // ... the rest of the frame ...
    ///     scene = ticket.read()??;
    ///     assert_eq!(scene.hits().len(), usize::from(frame < 2));
    /// }
    /// # Ok::<(), Error>(())
    /// ```
    pub fn submit<T, F>(&self, ask: F) -> Result<Ticket<T>, Error>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let planned = |backend| Planned {
            questions: 0,
            backend,
            reason: Reason::NoChoice,
            on_cpu: Vec::new(),
        };
        let outcome = Arc::<Outcome<T>>::default();
        let own = outcome.clone();
        let work = |ask: F| {
            move || {
                // The guard is also for answers and functions that nobody awaits, which are dropped in it.
                own.guard(|| {
                    if !own.is_known() {
                        own.set(Ok(ask()));
                    }
                    Ok(())
                });
            }
        };
        if let Some((_, reader)) = self.for_tickets() {
            let seat = reader.add_function(Box::new(work(ask)), outcome.flag().clone())?;
            let mut ticket = Ticket::new(outcome, planned(Backend::Gpu));
            ticket.seat = Some(seat);
            return Ok(ticket);
        }
        if let Some(pool) = &self.pool {
            pool.spawn(work(ask));
            return Ok(Ticket::new(outcome, planned(Backend::Threads)));
        }
        let mut ask = Some(ask);
        let step = move || Ok(ask.take().map(|ask| ask()));
        Ok(Ticket::in_steps(Box::new(step), planned(Backend::Sequential)))
    }
}
