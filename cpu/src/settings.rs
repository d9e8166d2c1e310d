//! Settings of a pool. None of them changes an answer.

/// The way in which the nodes of a frame are assigned to workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Schedule {
    /// The schedule of the paper: a front with one part per worker, and no synchronisation until the end.
    Static,
    /// The same with repairs while it runs: a worker that is done takes nodes that others have not begun, and then half of what they have begun. Taking
    /// from others makes up for wrong costs, so the front is coarse: g is at most 2, and after a frame unlike the last
    /// there is no more than the starting front.
    #[default]
    Hybrid,
}

/// Settings of a [`Pool`](crate::Pool).
///
/// # Examples
/// ```
/// use pfront_cpu::{Pool, Schedule, Settings};
/// let settings = Settings { schedule: Schedule::Static, g: 2.0, ..Settings::default() };
/// let pool = Pool::new(16).with_settings(settings);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The way in which nodes are assigned to workers.
    pub schedule: Schedule,
    /// The g of eq. 1, 8 by default: no node of a front that can be split costs more than 1/g of the mean load of a worker.
    /// Nodes whose cost is an estimate are six times as fine. For [`Schedule::Static`]; under [`Schedule::Hybrid`] it is at most 2.
    pub g: f64,
    /// Whether the costs of the last frame are used. Without them each frame is independent, as in
    /// section 3.2.2.
    pub coherence: bool,
    /// The most nodes a front may have; it then stays coarser. At least one for each query, or for each node pair that the
    /// calling thread has left pending, is needed and taken.
    pub max_nodes: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { schedule: Schedule::default(), g: 8.0, coherence: true, max_nodes: 1 << 20 }
    }
}
