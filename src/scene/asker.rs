//! Who asks: the calling thread, several, or whoever a planner picks.

use super::SceneHit;
use super::bodies::{Bodies, BodyId};
use super::broad::Broad;
#[cfg(feature = "threads")]
use super::crew::Crew;
use super::frame::{Found, Frame, Given};
use super::planned::Planned;
use crate::answer::Want;
use crate::{Accuracy, Error, Model};
use pfront_core::bvtt::{PairQuery, Query};
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
    /// Answers with no broad phase; into `hits`, which are empty, if all are wanted. `None` if it needs one.
    pub(super) fn ask_ahead(
        &mut self,
        accuracy: Accuracy,
        bodies: &Bodies,
        want: Want,
        hits: &mut Vec<SceneHit>,
    ) -> Option<Given> {
        match self {
            Self::Planned(planned) => planned.ask_ahead(accuracy, bodies, want, hits),
            _ => None,
        }
    }

    /// Brings the broad phase up to date.
    pub(super) fn update(&mut self, broad: &mut Broad, bodies: &mut Bodies) -> Result<(), Error> {
        match self {
            Self::Planned(planned) => planned.update(broad, bodies),
            _ => broad.update(bodies),
        }
    }

    /// Answers; into `hits`, which are empty, if all are wanted.
    pub(super) fn ask(&mut self, frame: &Frame<'_>, want: Want, hits: &mut Vec<SceneHit>) -> Found {
        match self {
            Self::Alone => Found::New(alone(frame, want, hits)),
            #[cfg(feature = "threads")]
            Self::Crew(crew) => Found::New(crew.ask(frame, want, hits)),
            Self::Planned(planned) => planned.ask(frame, want, hits),
        }
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

fn alone(frame: &Frame<'_>, want: Want, hits: &mut Vec<SceneHit>) -> Given {
    match want {
        Want::All => {
            for (bodies, query) in frame.queries() {
                let first = hits.len();
                let _ = query.visit(&mut query.start(), |pair| {
                    hits.push(SceneHit { bodies, pair });
                    ControlFlow::Continue(())
                });
                hits[first..].sort_unstable();
            }
            Given::listed(hits)
        }
        Want::Count => Given::counted(frame.queries().map(|(_, query)| query.count()).sum()),
        Want::Any => {
            let hit = |(bodies, query): ([BodyId; 2], PairQuery<'_>)| {
                Some(SceneHit { bodies, pair: query.any()? })
            };
            Given::found(frame.queries().find_map(hit))
        }
    }
}
