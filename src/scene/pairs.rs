//! The pairs of bodies that have to be asked about in a frame.

use super::bodies::Bodies;
use super::body::Body;
use super::broad::{Broad, Places};
use super::id::BodyId;
use pfront_core::bvtt::PairBvtt;

/// The bodies of a frame, and which of them may meet.
#[derive(Clone, Copy)]
pub(super) struct BodyPairs<'s> {
    pub(super) bodies: &'s Bodies,
    pairs: &'s [Places],
    /// If there is a number, a pair of bodies that have both not changed since is not asked about.
    since: Option<u64>,
    /// Only pairs with a body in f64, or only others, are asked about; all if there is nothing here.
    in_f64: Option<bool>,
}

impl<'s> BodyPairs<'s> {
    pub(super) fn since(since: u64, bodies: &'s Bodies, broad: &'s Broad) -> Self {
        let (pairs, since) = match broad.changed_since(since) {
            Some(changed) => (changed, None),
            None => (broad.pairs(), Some(since)),
        };
        Self { bodies, pairs, since, in_f64: None }
    }

    /// The pairs with a body in f64, or the others.
    #[cfg(feature = "gpu")]
    pub(super) fn in_f64(self, in_f64: bool) -> Self {
        Self { in_f64: Some(in_f64), ..self }
    }

    /// Bodies that may meet and whose bounds overlap, by their places and in order.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Places> + use<'s> {
        let Self { bodies, pairs, since, in_f64, .. } = *self;
        let changed = move |two: &Places| since.is_none_or(|t| bodies.changed_at(*two) > t);
        let is_asked = move |two: &Places| {
            bodies.may_meet(*two) && in_f64.is_none_or(|in_f64| bodies.is_f64(*two) == in_f64)
        };
        pairs.iter().copied().filter(changed).filter(is_asked)
    }

    /// The same as queries.
    pub(super) fn queries(&self) -> impl Iterator<Item = ([BodyId; 2], PairBvtt<'s>)> {
        let own = *self;
        self.pairs().filter_map(move |places| own.query(places))
    }

    /// The query about two bodies by their places.
    pub(super) fn query(&self, [a, b]: Places) -> Option<([BodyId; 2], PairBvtt<'s>)> {
        // Always there: the places are those of this frame.
        let (a, b) = (self.bodies.at(a)?, self.bodies.at(b)?);
        Some(([a.id(), b.id()], meeting(a, b)))
    }
}

/// Whether two bodies meet in the world.
pub(super) fn meeting<'s>(a: &'s Body, b: &'s Body) -> PairBvtt<'s> {
    PairBvtt::in_world(a.placed(), b.placed())
}
