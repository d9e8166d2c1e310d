//! A frame of a scene, as each kind of executor answers it.

#[cfg(feature = "threads")]
use super::batches::Batches;
use super::bodies::Bodies;
#[cfg(feature = "gpu")]
use super::bodies::Body;
use super::broad::Broad;
#[cfg(feature = "gpu")]
use super::device::Mirror;
use super::frame::{Answer, Frame};
use super::{Accuracy, Error, SceneHit};
#[cfg(feature = "gpu")]
use crate::executor::Device;
use crate::executor::{Question, Verb, list, visit};
#[cfg(feature = "threads")]
use crate::threads::Traversal;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

pub(super) struct Asking<'s> {
    pub(super) accuracy: Accuracy,
    /// Hits are known of pairs of bodies that have not changed since then.
    pub(super) since: u64,
    pub(super) bodies: &'s mut Bodies,
    pub(super) broad: &'s mut Broad,
    /// New hits; empty.
    pub(super) hits: &'s mut Vec<SceneHit>,
    #[cfg(feature = "threads")]
    pub(super) batches: &'s mut Batches,
    #[cfg(feature = "gpu")]
    pub(super) mirror: &'s mut Mirror,
}

impl Question for Asking<'_> {
    type Answer = Answer;

    #[cfg(feature = "gpu")]
    fn accuracy(&self) -> Accuracy {
        self.accuracy
    }

    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        self.bodies.iter().any(Body::is_f64)
    }

    fn on_one_thread(&mut self, verb: Verb, cancel: Option<&AtomicBool>) -> Result<Answer, Error> {
        self.broad.update(self.bodies)?;
        let frame = Frame::since(self.since, self.accuracy, self.bodies, self.broad);
        Ok(match verb {
            Verb::All => {
                for (bodies, query) in frame.queries() {
                    let first = self.hits.len();
                    list(&query, cancel, self.hits, |pair| SceneHit { bodies, pair })?;
                    self.hits[first..].sort_unstable();
                }
                Answer::listed(self.hits)
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
        self.broad.update(self.bodies)?;
        let frame = Frame::since(self.since, self.accuracy, self.bodies, self.broad);
        self.batches.ask(traversal, &frame, verb, self.hits)
    }

    /// A scene stays itself, whichever bodies it has.
    #[cfg(feature = "gpu")]
    fn meshes(&self) -> [u64; 2] {
        [0; 2]
    }

    #[cfg(feature = "gpu")]
    fn to_upload(&mut self) -> usize {
        self.mirror.lacks(self.bodies)
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(&mut self, device: &Device, verb: Verb) -> Result<Answer, Error> {
        self.broad.update(self.bodies)?;
        let frame = Frame::since(self.since, self.accuracy, self.bodies, self.broad);
        Ok(self.mirror.ask(device, &frame, verb, self.hits)?)
    }
}
