//! The compiled half of the npm package `pfront`: meshes, and queries about two, about one and itself, and about scenes, all on
//! the calling thread.
//!
//! Typed arrays are copied in and out: a view would be of no use once the memory has grown. Matrices are by columns, as three.js
//! keeps them. `js/values.js` and `js/errors.js` check and make what JavaScript does better.

mod contacts;
mod error;
mod itself;
mod mesh;
mod pair;
mod scene;
mod thrown;
mod values;
mod wide;
