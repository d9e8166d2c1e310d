//! What a plan costs that was chosen, against the best of all that never change: its regret.
//!
//! Regret is the chooser's time for a whole case, deciding included, over that of the best fixed plan, minus
//! one; the best is known only afterwards, and may be another for each case. It is the one over which the chooser
//! took longest: the largest of some ratios, of which each is the median over rounds.
//!
//! - [`recipes`]: the cases, drawn from a seed; [`Case`]: one of them, built.
//! - [`Field`]: who plays. [`race`]: a case, played by all of them in turn.
//! - [`Row`], [`Summary`]: what that came to, as text or with [`write_csv`].

mod case;
mod cloth;
mod crowd;
mod field;
mod latin;
mod race;
mod recipe;
mod row;
mod shapes;
mod table;
mod two;

pub use case::{Case, Frame, Verb};
pub use field::{Field, Lane};
pub use race::{Effort, HOPELESS, race};
pub use recipe::{Recipe, Scale, recipes};
pub use row::{Outcome, Row, Summary};
pub use table::{Heading, write_csv};

use crate::engine::EngineError;

/// Why a case could not be built or played.
#[derive(Debug, thiserror::Error)]
pub enum RegretError {
    /// A mesh is refused.
    #[error(transparent)]
    Refused(#[from] pfront::Error),
    /// A scene cannot be made.
    #[error(transparent)]
    Scene(#[from] pfront_testkit::scenes::SceneError),
    /// A question is refused, or the GPU fails.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// There are no threads to be had.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Two plans answer differently.
    #[error(
        "frame {frame} of {case}: {plan} answers otherwise than one thread: please report this"
    )]
    Differs {
        /// The case.
        case: String,
        /// Who differs.
        plan: String,
        /// Where.
        frame: usize,
    },
    /// Nobody to compare with.
    #[error("there is no fixed plan to compare with: give at least that of one thread")]
    NoPlan,
}
