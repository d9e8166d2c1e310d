//! Scenes whose answer has a closed form.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "physical/gears.rs"]
mod gears;
#[path = "physical/spheres.rs"]
mod spheres;
