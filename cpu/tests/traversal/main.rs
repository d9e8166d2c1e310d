//! Tests of whole traversals, on generated scenes.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod answers;
mod common;
mod deadline;
mod deep;
mod robustness;
