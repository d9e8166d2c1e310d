//! The compiled half of the Python package `pfront`: models, questions about one model, two or a scene, and the executors
//! that answer them. Arrays that arrive here are aligned, in C order and of native dtypes, which the Python half sees to.
//!
//! Nothing here holds the interpreter while it traverses. Traversals on the calling thread go on in steps or are ended by
//! [`watchdog`], and what other threads do is waited for in slices of time, so that a signal is heard within
//! [`executor::PATIENCE`].

#![expect(unreachable_pub, reason = "the macros of pyo3 write public items")]

mod arrays;
mod batch;
mod contacts;
mod errors;
mod executor;
mod model;
mod part;
mod poses;
mod question;
mod scene;
mod watchdog;

use pyo3::prelude::*;

/// The compiled half of the package.
#[pymodule(gil_used = false)]
mod _pfront {
    #[pymodule_export]
    use crate::contacts::contacts;
    #[pymodule_export]
    use crate::executor::{Executor, adapters};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::question::{all, any, count};
    #[pymodule_export]
    use crate::scene::Scene;
}
