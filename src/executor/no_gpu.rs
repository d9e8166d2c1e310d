//! Without the feature `gpu` there is no GPU: what others use of `gpu/mod.rs`, of which nothing has a value.

use super::choice::Line;
use super::{Answer, Executor, Verb};
use crate::subject::Subject;
use crate::{Error, Model, TrianglePair};

#[derive(Debug)]
pub(crate) enum Device {}

impl Device {
    pub(crate) fn line(&self) -> Option<&Line> {
        match *self {}
    }

    pub(crate) fn is_lost_by(&self, _: &Error) -> Option<bool> {
        match *self {}
    }
}

#[derive(Debug)]
pub(crate) enum Reader {}

#[derive(Clone, Debug, Default)]
pub(crate) struct Mirrors;

impl Mirrors {
    pub(crate) fn lack(&self, _: &[&Model]) -> usize {
        0
    }

    pub(crate) fn ask(
        &mut self,
        device: &Device,
        _: &Subject<&Model>,
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
