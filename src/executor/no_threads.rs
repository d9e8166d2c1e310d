//! Without the feature `threads` there is one thread: what others use of `threads.rs`, of which nothing has a value.

use super::{Answer, Backend, Named, Verb};
use crate::Error;
use crate::{Distance, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Gap, PairBvtt};
use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Has no value.
#[derive(Clone, Debug)]
pub(crate) enum NoPool {}

pub(crate) type Pool = NoPool;

impl NoPool {
    pub(crate) fn threads(&self) -> usize {
        match *self {}
    }

    pub(crate) fn install<R>(&self, _: impl FnOnce() -> R) -> R {
        match *self {}
    }

    pub(crate) fn spawn(&self, _: impl FnOnce()) {
        match *self {}
    }

    pub(crate) fn by_pieces<T, R>(
        &self,
        _: &[T],
        _: usize,
        _: impl Fn(&[T], &mut Vec<R>) -> Result<(), Error>,
        _: &mut Vec<R>,
    ) -> Result<(), Error> {
        match *self {}
    }

    pub(crate) fn sort<T, K>(&self, _: &mut [T], _: impl Fn(&T) -> K) {
        match *self {}
    }
}

pub(crate) fn wait_in_pool(most: Duration) -> Option<Duration> {
    Some(most)
}

pub(super) fn all() -> Option<Pool> {
    None
}

/// Has no value.
#[derive(Clone, Debug)]
pub(super) struct NoHistory<N>(Infallible, PhantomData<N>);

pub(super) type ThreadsHistory<N> = NoHistory<N>;

impl<N> NoHistory<N> {
    pub(super) fn new(pool: &Pool, _: Option<Arc<AtomicBool>>) -> Self {
        match *pool {}
    }

    pub(super) fn was_at_once(&self) -> bool {
        match self.0 {}
    }

    pub(super) fn distance(
        &self,
        _: &PairBvtt<'_>,
        _: Option<Distance>,
        _: Option<TrianglePair>,
        _: Option<&AtomicBool>,
    ) -> (Backend, Option<Gap>) {
        match self.0 {}
    }

    pub(super) fn ask_one<F: Named<Name = N>>(
        &mut self,
        _: N,
        _: &AnyBvtt<'_>,
        _: Verb,
        _: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        match self.0 {}
    }

    pub(super) fn ask_many<'q, F: Named<Name = N>, S>(
        &mut self,
        _: impl Iterator<Item = (N, S)>,
        _: impl Fn(&S) -> AnyBvtt<'q>,
        _: Verb,
        _: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        match self.0 {}
    }
}
