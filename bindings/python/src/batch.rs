//! Questions about two models in many poses.

use crate::asking::wait;
use crate::ending::Inside;
use crate::errors::exception;
use crate::executor::Executor;
use crate::threads::apart;
use pfront::{AnyPose, Batch, Distance, Error, Model, Ticket};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::{mem, process};

/// Poses that are asked about in one submission.
const CHUNK: usize = 1 << 14;

/// Two models in many poses, and who is told how far the question has come.
pub(crate) struct PoseBatch<'py> {
    pub(crate) models: [Arc<Model>; 2],
    pub(crate) poses: Vec<AnyPose>,
    pub(crate) progress: Option<Bound<'py, PyAny>>,
    pub(crate) within: Distance,
}

impl PoseBatch<'_> {
    /// Asks about all poses, in chunks whose answers are read in turn.
    pub(crate) fn ask<T: Send>(
        &self,
        py: Python<'_>,
        on: &Executor,
        verb: impl Fn(&mut Batch, &pfront::Executor) -> Result<Ticket<T>, Error> + Sync,
        mut read: impl FnMut(&[AnyPose], T) -> PyResult<()>,
    ) -> PyResult<()> {
        let Self { models: [a, b], poses, progress, within } = self;
        let executor = on.for_batches(py)?;
        let own = process::id();
        let mut batch = Batch::new();
        batch.within(within.get()).map_err(|error| exception(py, error, None))?;
        let mut done = 0;
        for chunk in poses.chunks(CHUNK) {
            let start = || {
                batch.clear();
                for (i, pose) in chunk.iter().enumerate() {
                    batch.pair(a, b, *pose).map_err(|error| (error, Some(done + i)))?;
                }
                verb(&mut batch, &executor).map_err(|error| (error, None))
            };
            let ticket = apart(py, start).map_err(|(error, pose)| exception(py, error, pose))?;
            read(chunk, wait(py, on, ticket)?)?;
            done += chunk.len();
            if let Some(progress) = progress {
                let _inside = Inside::enter();
                progress.call1((done, poses.len()))?;
            }
            if own != process::id() {
                // The threads and the device of this question are not here.
                mem::forget((batch, executor));
                return Err(PyRuntimeError::new_err(
                    "the process was forked inside a question: ask again here",
                ));
            }
        }
        Ok(())
    }

    /// Whether the question is in f64.
    pub(crate) fn is_f64(&self) -> bool {
        self.poses.iter().any(AnyPose::is_f64) || self.models.iter().any(|model| model.is_f64())
    }
}
