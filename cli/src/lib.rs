//! The parts of the `pfront` command: mesh files, recorded workloads, pair files,
//! recorded contacts.
//!
//! They are a library so that tests, benches and fuzz targets can call them.

mod binary;
pub mod mesh;
pub mod pairs;
pub mod recorded;
pub mod workload;
