//! Every query on the device against the core. One process, one device.

#![expect(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking")]

mod build;
mod common;
mod deforming;
mod in_f64;
mod itself;
mod near;
mod order;
mod pairs;
mod scene;
mod vertices;
mod world;
