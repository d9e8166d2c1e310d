//! Without the feature `gpu` there is no GPU: what others use of `gpu/mod.rs`, of which nothing has a value.

use super::choice::Line;
use super::{Answer, Executor, Verb};
use crate::subject::Subject;
use crate::{Error, Model, TrianglePair};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Has no value.
#[derive(Debug)]
pub(crate) enum NoGpu {}

pub(crate) type Device = NoGpu;
pub(crate) type Reader = NoGpu;
pub(crate) type Seat = NoGpu;

impl NoGpu {
    pub(crate) fn choice_line(&self) -> Option<&Line> {
        match *self {}
    }

    pub(crate) fn is_lost_by(&self, _: &Error) -> Option<bool> {
        match *self {}
    }

    pub(crate) fn leave(&self) {
        match *self {}
    }

    pub(crate) fn is_this_thread(&self) -> bool {
        match *self {}
    }

    pub(crate) fn add_function(
        &self,
        _: Box<dyn FnOnce() + Send>,
        _: Arc<AtomicBool>,
    ) -> Result<Seat, Error> {
        match *self {}
    }
}

/// Has no mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct NoMirrors;

pub(crate) type Mirrors = NoMirrors;

impl NoMirrors {
    pub(crate) fn lack(&self, _: &[&Model]) -> usize {
        0
    }

    pub(crate) fn ask(
        &mut self,
        device: &Device,
        _: &Subject<&Model>,
        _: Option<&Arc<AtomicBool>>,
        _: Verb,
        _: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, Error> {
        match *device {}
    }
}

impl Executor {
    pub(super) fn and_best_gpu(self) -> Self {
        self
    }
}
