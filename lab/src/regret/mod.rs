//! The regret of the plans that an executor chooses: their cost against that of the best plan that never changes.
//!
//! Regret is the chooser's time for a whole case, deciding included, over that of the best fixed plan, minus
//! one; the best is known only afterwards, and may be another for each case. It is the one over which the chooser
//! took longest: the largest of some ratios, of which each is the median over rounds.
//!
//! - [`recipes`]: the cases, drawn from a seed; [`Case`]: one of them, built.
//! - [`Field`]: who plays. [`race()`]: a case, played by all of them in turn.
//! - [`Row`], [`summary`]: what that came to, as text or with [`write_csv`].

mod case;
mod cloth;
mod crowd;
mod pair;
mod race;
mod recipe;
mod row;
mod scale;
mod shapes;

pub use case::{Case, Verb};
pub use race::{Effort, Field, race};
pub use recipe::{Recipe, recipes};
pub use row::{Lane, Row, summary, write_csv};
pub use scale::Scale;
