//! Who asks: the calling thread, several, or whoever a planner picks.

use super::SceneHit;
#[cfg(feature = "threads")]
use super::crew::Crew;
use super::frame::{Found, Frame};
use super::planned::Planned;
use crate::answer::Want;
use crate::{Error, Model};
use pfront_core::query::Query;
use std::ops::ControlFlow;

#[derive(Clone, Debug, Default)]
pub(super) enum Asker {
    #[default]
    Alone,
    #[cfg(feature = "threads")]
    Crew(Box<Crew>),
    Planned(Box<Planned>),
}

impl Asker {
    /// All hits, in order, into an empty list.
    pub(super) fn all(&mut self, frame: &Frame<'_>, hits: &mut Vec<SceneHit>) -> Found<()> {
        match self {
            Self::Alone => {
                for (bodies, query) in frame.queries() {
                    let first = hits.len();
                    let _ = query.visit(&mut query.start(), |pair| {
                        hits.push(SceneHit { bodies, pair });
                        ControlFlow::Continue(())
                    });
                    hits[first..].sort_unstable();
                }
            }
            #[cfg(feature = "threads")]
            Self::Crew(crew) => crew.all(frame, hits),
            Self::Planned(planned) => return planned.ask(frame, Want::All, hits).map(|_| ()),
        }
        Found::New(())
    }

    pub(super) fn any(&mut self, frame: &Frame<'_>) -> Option<SceneHit> {
        match self {
            Self::Alone => {
                let mut found = frame.queries().filter_map(|(bodies, query)| {
                    let pair = query.any()?;
                    Some(SceneHit { bodies, pair })
                });
                found.next()
            }
            #[cfg(feature = "threads")]
            Self::Crew(crew) => crew.any(frame),
            Self::Planned(planned) => planned.ask(frame, Want::Any, &mut Vec::new()).get().first,
        }
    }

    pub(super) fn count(&mut self, frame: &Frame<'_>) -> Found<u64> {
        Found::New(match self {
            Self::Alone => frame.queries().map(|(_, query)| query.count()).sum(),
            #[cfg(feature = "threads")]
            Self::Crew(crew) => crew.count(frame),
            Self::Planned(planned) => {
                return planned.ask(frame, Want::Count, &mut Vec::new()).map(|given| given.count);
            }
        })
    }

    pub(super) fn set_positions(
        &self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        match self {
            Self::Alone => model.set_positions(positions),
            #[cfg(feature = "threads")]
            Self::Crew(crew) => crew.set_positions(model, positions),
            Self::Planned(planned) => planned.planner().set_positions(model, positions),
        }
    }

    /// Whether the last answer is not what was asked for.
    pub(super) fn has_conceded(&self) -> bool {
        match self {
            Self::Planned(planned) => planned.has_conceded(),
            _ => false,
        }
    }

    /// A frame begins.
    pub(super) fn start(&mut self) {
        if let Self::Planned(planned) = self {
            planned.start();
        }
    }

    /// It is over: nothing has changed.
    pub(super) fn keep(&mut self) {
        if let Self::Planned(planned) = self {
            planned.keep();
        }
    }
}
