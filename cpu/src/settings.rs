//! What can be chosen about a traversal. None of it changes an answer.

use crate::TRIANGLE_COST;
use pfront_core::front::{Estimate, Grain};

/// Who walks what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// The paper: one task per partition, no synchronisation until the end.
    Static,
    /// No front: rayon's recursion from the root, in which idle threads steal. Knows nothing of the
    /// last frame.
    Stealing,
    /// [`Schedule::Static`], and a worker that is done takes nodes that others have not begun. That makes
    /// up for wrong estimates, so estimated nodes are no finer than measured ones.
    #[default]
    Hybrid,
}

/// How a [`Traversal`](crate::Traversal) works.
///
/// # Examples
/// ```
/// use pfront_core::front::Grain;
/// use pfront_cpu::{Schedule, Settings, Traversal};
/// let settings = Settings { schedule: Schedule::Static, grain: Grain::uniform(2.0), ..Settings::default() };
/// let traversal = Traversal::new(16).with_settings(settings);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Who walks what.
    pub schedule: Schedule,
    /// The g of the paper.
    pub grain: Grain,
    /// How costs are estimated where the last frame tells nothing.
    pub estimate: Estimate,
    /// The k of |n| = m1 + k·m2: what a triangle test costs, in box tests.
    ///
    /// A constant by default, [`TRIANGLE_COST`], measured once and not anew on each machine: fronts, and
    /// all that a [`Report`](crate::Report) counts, are then the same everywhere and in each run. For the
    /// last per cent of speed on a machine that differs, measure it at start-up and keep it:
    ///
    /// ```
    /// # use pfront_cpu::Settings;
    /// let settings = Settings { triangle_cost: pfront_cpu::calibrate(), ..Settings::default() };
    /// ```
    pub triangle_cost: f32,
    /// Whether the costs of the last frame are used. Without, each frame stands for itself, as in
    /// section 3.2.2.
    pub coherence: bool,
    /// The most nodes a front may have; it then stays coarser. At least 1 per query is needed and taken.
    pub most_nodes: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            schedule: Schedule::default(),
            grain: Grain::default(),
            estimate: Estimate::default(),
            triangle_cost: TRIANGLE_COST,
            coherence: true,
            most_nodes: 1 << 20,
        }
    }
}
