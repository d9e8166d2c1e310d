//! Where a p-partition front could fail, as named scenes: ours, and the paper's equations as printed.
//!
//! [`ROWS`] is the matrix. Each row plays its scenes with any numbers of workers p under a static schedule, in
//! counted work, so that its figures are the same on every machine; whatever else is measured, each frame's
//! pairs must be those that one core finds, and those of the exact oracle where that is small, and each figure
//! a number.
//!
//! - [`limit`]: what an imbalance may be.
//! - [`scene`]: what a scene is; the scenes themselves are private to the rows.
//! - [`plain`]: the method as printed.
//! - [`play`]: a scene with all methods. [`rows`]: the matrix and its findings.

mod catalogue;
pub mod limit;
pub mod plain;
pub mod play;
mod reference;
pub mod rows;
pub mod scene;
mod shapes;

pub use play::{Frame, Method, Series};
pub use reference::Reference;
pub use rows::{Finding, Outcome, ROWS, Row};
