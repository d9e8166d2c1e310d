//! A frame of a scene, as each kind of executor answers it.

#[cfg(feature = "threads")]
use super::batches::Batches;
#[cfg(feature = "gpu")]
use super::cache::merge;
#[cfg(feature = "gpu")]
use super::device::Mirror;
use super::frame::{Answer, Frame};
use super::{Error, SceneHit};
#[cfg(feature = "gpu")]
use crate::Accuracy;
#[cfg(feature = "gpu")]
use crate::executor::{Backend, Device, Executor};
use crate::executor::{Question, Verb, list, sort, visit};
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

pub(super) struct Asking<'s> {
    pub(super) frame: Frame<'s>,
    /// New hits; empty.
    pub(super) hits: &'s mut Vec<SceneHit>,
    #[cfg(feature = "threads")]
    pub(super) batches: &'s mut Batches,
    #[cfg(feature = "gpu")]
    pub(super) mirror: &'s mut Mirror,
    /// The part of the CPU that answered about pairs in f64, beside a GPU.
    #[cfg(feature = "gpu")]
    pub(super) beside: Option<Backend>,
}

impl Question for Asking<'_> {
    type Answer = Answer;

    #[cfg(feature = "gpu")]
    fn accuracy(&self) -> Accuracy {
        self.frame.accuracy
    }

    /// Where no pair is in f32 only.
    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        self.frame.bodies.in_f64() > 0 && self.frame.in_f64(false).pairs().next().is_none()
    }

    fn on_one_thread(&mut self, verb: Verb, cancel: Option<&AtomicBool>) -> Result<Answer, Error> {
        let Self { frame, hits, .. } = self;
        Ok(match verb {
            Verb::All => {
                for (bodies, query) in frame.queries() {
                    let first = hits.len();
                    list(&query, cancel, hits, |pair| SceneHit { bodies, pair })?;
                    sort(&mut hits[first..], cancel)?;
                }
                Answer::listed(hits)
            }
            Verb::Count => {
                let mut count = 0;
                for (_, query) in frame.queries() {
                    visit(&query, cancel, |_| {
                        count += 1;
                        ControlFlow::Continue(())
                    })?;
                }
                Answer::counted(count)
            }
            Verb::Any => {
                let mut first = None;
                for (bodies, query) in frame.queries() {
                    visit(&query, cancel, |pair| {
                        first = Some(SceneHit { bodies, pair });
                        ControlFlow::Break(())
                    })?;
                    if first.is_some() {
                        break;
                    }
                }
                Answer::found(first)
            }
        })
    }

    #[cfg(feature = "threads")]
    fn on_threads(&mut self, traversal: &mut Traversal, verb: Verb) -> Result<Answer, Error> {
        self.batches.ask(traversal, &self.frame, verb, self.hits)
    }

    /// A scene stays itself, whichever bodies it has.
    #[cfg(feature = "gpu")]
    fn meshes(&self) -> [u64; 2] {
        [0; 2]
    }

    #[cfg(feature = "gpu")]
    fn to_upload(&mut self) -> usize {
        self.mirror.lacks(self.frame.bodies)
    }

    /// Pairs with a body in f64 are asked about on the CPU beside, and both lists are merged.
    #[cfg(feature = "gpu")]
    fn on_gpu(&mut self, device: &Device, cpu: &mut Executor, verb: Verb) -> Result<Answer, Error> {
        if self.frame.bodies.in_f64() == 0 {
            return self.mirror.ask(device, &self.frame, verb, self.hits);
        }
        let whole = self.frame;
        let own = self.mirror.ask(device, &whole.in_f64(false), verb, self.hits)?;
        if own.first.is_some() && verb == Verb::Any {
            return Ok(own);
        }
        let rest = whole.in_f64(true);
        if rest.pairs().next().is_none() {
            return Ok(own);
        }
        let found = std::mem::take(self.hits);
        self.frame = rest;
        let (backend, answer) = cpu.on_cpu(self, verb);
        self.frame = whole;
        self.beside = Some(backend);
        let answer = answer?;
        Ok(match verb {
            Verb::All => {
                let late = std::mem::replace(self.hits, found);
                merge(self.hits, &late)?;
                Answer::listed(self.hits)
            }
            Verb::Count => Answer::counted(own.count + answer.count),
            Verb::Any => answer,
        })
    }
}
