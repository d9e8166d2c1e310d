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

/// Whether a GPU lacks the memory for a question, which is no fault of it.
fn lacks_memory(error: &anyhow::Error) -> bool {
    #[cfg(feature = "gpu")]
    if let Some(pfront::Error::Gpu(error)) = error.downcast_ref() {
        use pfront::gpu::GpuError::{OutOfMemory, TooLarge};
        return matches!(error, TooLarge { .. } | OutOfMemory { .. });
    }
    let _ = error;
    false
}
