//! The compiled half of the Python package `pfront`: models, questions about one model, two or a scene, and the executors
//! that answer them. Arrays that arrive here are aligned, in C order and of native dtypes, which the Python half sees to.
//!
//! Nothing here holds the interpreter while it traverses. Traversals on the calling thread go on in steps or are ended by
//! [`watchdog`], and what other threads do is waited for in slices of time, so that a signal is heard within twice
//! [`threads::PATIENCE`]. All arithmetic is done in the default floating-point environment: [`threads::apart`].

#![expect(unreachable_pub, reason = "the macros of pyo3 write public items")]

mod arrays;
mod asking;
mod batch;
mod contacts;
mod distance;
mod ending;
mod errors;
mod executor;
mod files;
mod impacts;
mod lock;
mod memory;
mod model;
mod mutex;
mod part;
mod patches;
mod poses;
mod question;
mod relation;
mod scene;
mod scene_impacts;
mod segment;
mod threads;
mod watchdog;

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// The compiled half of the package.
#[pymodule(gil_used = false)]
mod _pfront {
    use super::{PyModule, PyResult, load};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.setattr("__version__", env!("CARGO_PKG_VERSION"))?;
        load(module.py())
    }

    #[pymodule_export]
    use crate::contacts::contacts;
    #[pymodule_export]
    use crate::distance::distance;
    #[pymodule_export]
    use crate::ending::forked;
    #[pymodule_export]
    use crate::executor::{Executor, adapters};
    #[pymodule_export]
    use crate::files::read;
    #[pymodule_export]
    use crate::impacts::{any_impact, count_impacts, first_impact, impacts};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::patches::patches;
    #[pymodule_export]
    use crate::question::{all, any, at_least, count, first};
    #[pymodule_export]
    use crate::relation::{overlap_volume, relation, relations};
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::scene_impacts::{
        scene_any_impact, scene_count_impacts, scene_first_impact, scene_impacts,
    };
    #[pymodule_export]
    use crate::segment::{inside, segment, segment_first};
    #[pymodule_export]
    use crate::threads::join;
}

/// Loads now what is otherwise loaded when it is first used: a fork in the midst of that would leave the child waiting for it.
fn load(py: Python<'_>) -> PyResult<()> {
    errors::load(py)?;
    poses::load(py)?;
    PyArray1::<u8>::zeros(py, 1, false).readonly();
    Ok(())
}
