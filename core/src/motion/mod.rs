//! Which triangles meet while both move, and when first.
//!
//! TODO
mod apart;
mod impact;
mod meets;
mod pair;
#[cfg(test)]
mod tests;

pub use impact::{Impact, impact};
pub use pair::MovingTriangle;
