//! What the tests of every crate of pfront share: random numbers, shapes, hard triangle pairs, and the truth about them.
//!
//! Nothing here depends on the library, and meshes are plain arrays: unit tests of `pfront-core` can use them too, and a
//! fault of the library cannot hide behind its twin.

pub mod families;
pub mod oracle;
pub mod rng;
pub mod shapes;

/// A point in f32, finite.
pub type Point = [f32; 3];

/// A triangle by its corners.
pub type Triangle = [Point; 3];
