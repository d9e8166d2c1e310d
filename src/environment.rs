//! The floating-point environment of the calls of this crate: the default, whatever that of the caller is.
//!
//! It is set where a caller or a thread comes in, and nowhere below:
//! - [`Model`](crate::Model): where it is built, moved or read from a blob, and where a BVH, certificates or a sphere are
//!   made that somebody asks for;
//! - queries about one model or two: in [`History`](crate::history::History), which all their verbs call, and in
//!   [`PairQuery`](crate::PairQuery) where a pose is checked;
//! - scenes, batches and poses: in each method that computes;
//! - tickets: where a slice is done or a thread works on an outcome;
//! - executors: where they are made, since they are measured then;
//! - threads of a pool: around each job, in `pfront-cpu`.
//!
//! Closures of the caller run in the caller's environment again.

pub(crate) use pfront_core::environment::{Environment, with_default};
