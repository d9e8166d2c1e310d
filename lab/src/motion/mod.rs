//! Slow slides through contact, in which an answer must not flicker.
//!
//! A body that rests, closes or meshes is asked about again and again while it hardly moves. A test whose
//! rounding errors depend on the last bits of its input then changes its mind from frame to frame, and whoever
//! builds on it sees contacts come and go. [`run`] moves four scenes through contact in steps from one unit in
//! the last place up, asks each of [`METHODS`] about the same triangle pairs in every frame, and counts the
//! [`Row::flips`]: changes of an answer where the truth, from exact arithmetic that shares no code with the
//! library, does not change. [`figure`] charts them, and [`write_csv`] lists them.
//!
//! The truth flickers too where a face slides over a face, since posed positions are rounded to f32 in every
//! frame; an exact answer follows it, and that is no flip.

mod flips;
mod slide;

pub use flips::{METHODS, Row, STEPS, figure, run, write_csv};
pub use slide::{NAMES, Slide};
