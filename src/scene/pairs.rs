//! The pairs of bodies that have to be asked about in a frame; a body twice stands for the body and itself.

use super::bodies::Bodies;
use super::body::Body;
use super::broad::{Broad, Places};
use super::id::BodyId;
use crate::executor::Meeting;
use crate::subject::itself;
use crate::{Distance, Error};
use pfront_core::bvtt::{AnyBvtt, PairBvtt};

/// The bodies of a frame, and which of them may meet.
#[derive(Clone, Copy)]
pub(super) struct BodyPairs<'s> {
    pub(super) bodies: &'s Bodies,
    pairs: &'s [Places],
    /// If there is a number, a pair of bodies that have both not changed since is not asked about.
    since: Option<u64>,
    /// Only pairs that a GPU answers, or only others, are asked about; all if there is nothing here.
    of_gpu: Option<bool>,
}

impl<'s> BodyPairs<'s> {
    pub(super) fn since(since: u64, bodies: &'s Bodies, broad: &'s Broad) -> Self {
        let (pairs, since) = match broad.changed_since(since) {
            Some(changed) => (changed, None),
            None => (broad.pairs(), Some(since)),
        };
        Self { bodies, pairs, since, of_gpu: None }
    }

    /// The pairs that a GPU answers, or the others.
    pub(super) fn of_gpu(self, of_gpu: bool) -> Self {
        Self { of_gpu: Some(of_gpu), ..self }
    }

    /// Bodies that may meet and whose bounds overlap, by their places and in order.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Places> + use<'s> {
        let Self { bodies, pairs, since, of_gpu, .. } = *self;
        let changed = move |two: &Places| since.is_none_or(|t| bodies.changed_at(*two) > t);
        let is_asked = move |two: &Places| {
            bodies.may_meet(*two) && of_gpu.is_none_or(|of_gpu| bodies.are_of_gpu(*two) == of_gpu)
        };
        pairs.iter().copied().filter(changed).filter(is_asked)
    }

    /// The bodies themselves, by their ids.
    pub(super) fn bodies(&self) -> impl Iterator<Item = ([BodyId; 2], TwoBodies<'s>)> {
        let own = *self;
        self.pairs().filter_map(move |places| own.at(places))
    }

    /// Two bodies by their places.
    fn at(&self, places: Places) -> Option<([BodyId; 2], TwoBodies<'s>)> {
        // Always there: the places are those of this frame.
        let [Some(a), Some(b)] = places.map(|place| self.bodies.at(place)) else { return None };
        Some(([a.id(), b.id()], TwoBodies { bodies: [a, b], within: self.bodies.within }))
    }

    /// The query about two bodies by their places.
    pub(super) fn query(&self, places: Places) -> Option<([BodyId; 2], AnyBvtt<'s>)> {
        self.at(places).map(|(ids, two)| (ids, two.tree()))
    }
}

/// Two bodies, or one twice, that are asked about.
#[derive(Clone, Copy)]
pub(super) struct TwoBodies<'s> {
    bodies: [&'s Body; 2],
    within: Distance,
}

impl<'s> TwoBodies<'s> {
    /// Their BVTT.
    pub(super) fn tree(&self) -> AnyBvtt<'s> {
        let Self { bodies: [a, b], within } = *self;
        tree(a, b, within)
    }
}

/// The BVTT of two bodies in the world, or of one and itself in its own frame.
pub(super) fn tree<'s>(a: &'s Body, b: &'s Body, within: Distance) -> AnyBvtt<'s> {
    match a.options.itself {
        Some(adjacency) if a.id() == b.id() => itself(&a.model, adjacency, within),
        _ => AnyBvtt::Pair(PairBvtt::in_world(a.placed(), b.placed()).within(within)),
    }
}

/// Two bodies whose triangles are known to meet, or one twice, whose contacts are posed.
///
/// # Errors
/// [`Error::StaleBody`] if one of them is not there.
pub(super) fn meeting(bodies: &Bodies, [a, b]: [BodyId; 2]) -> Result<Meeting<'_>, Error> {
    let (first, second) = (bodies.get(a)?, bodies.get(b)?);
    Ok(match tree(first, second, Distance::default()) {
        AnyBvtt::Itself(tree) => Meeting::Posed(tree, first.pose),
        tree => Meeting::InTree(tree),
    })
}
