//! Without the feature `threads` there is one thread: what others use of `threads.rs`, of which nothing has a value.

use super::{Answer, Backend, Named, Verb};
use crate::Error;
use pfront_core::bvtt::AnyBvtt;
use std::convert::Infallible;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[derive(Clone, Debug)]
pub(crate) enum Pool {}

impl Pool {
    pub(crate) fn threads(&self) -> usize {
        match *self {}
    }

    pub(crate) fn install<R>(&self, _: impl FnOnce() -> R) -> R {
        match *self {}
    }

    pub(crate) fn by_pieces<T, R>(
        &self,
        _: &[T],
        _: impl Fn(&[T], &mut Vec<R>) -> Result<(), Error>,
        _: &mut Vec<R>,
    ) -> Result<(), Error> {
        match *self {}
    }
}

pub(super) fn all() -> Option<Pool> {
    None
}

#[derive(Clone, Debug)]
pub(super) struct ThreadsHistory<N>(Infallible, PhantomData<N>);

impl<N> ThreadsHistory<N> {
    pub(super) fn new(pool: &Pool, _: Option<Arc<AtomicBool>>) -> Self {
        match *pool {}
    }

    pub(super) fn was_at_once(&self) -> bool {
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

    pub(super) fn ask_in_turn<'q, F: Named<Name = N>>(
        &mut self,
        _: impl Iterator<Item = (N, AnyBvtt<'q>)>,
        _: Verb,
        _: &mut Vec<F>,
    ) -> (Backend, Result<Answer<F>, Error>) {
        match self.0 {}
    }
}
