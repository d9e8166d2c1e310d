//! The bodies of a scene, in the order in which they were added.

use super::body::{Body, BodyOptions};
use super::id::BodyId;
use crate::memory::reserve;
use crate::{AnyPose, Distance, Error, Model};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Bodies by ascending id. A body that is removed leaves a gap until the next frame, or until there are more gaps than bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    /// The ids, and when each body has last changed, or [`GONE`]: apart, since far more is asked of these.
    known: Vec<(BodyId, u64)>,
    bodies: Vec<Option<Body>>,
    live: usize,
    /// How many bodies are in f64 or are asked about themselves.
    not_of_gpu: usize,
    next: u64,
    /// Bodies are near within it.
    pub(super) within: Distance,
    /// Counts changes.
    time: u64,
    /// When a body last came or went.
    gathered: u64,
    /// When a body last went, or its mesh did.
    lost: u64,
    /// The places of bodies that have changed, some twice; as soon as there are more than bodies, not of all.
    moved: Vec<u32>,
    /// Pairs that are not asked about, each in both orders, so that those of one body are together.
    ignored: BTreeSet<[BodyId; 2]>,
}

/// Later than any change.
const GONE: u64 = u64::MAX;

/// So many gaps are kept, however few bodies there are.
const GAPS: usize = 32;

impl Bodies {
    pub(super) fn len(&self) -> usize {
        self.live
    }

    /// Whether a GPU answers about all pairs.
    pub(super) fn are_all_of_gpu(&self) -> bool {
        self.not_of_gpu == 0 && self.within == Distance::default()
    }

    /// Time of the last change; 0 before any.
    pub(super) fn time(&self) -> u64 {
        self.time
    }

    /// When a body last came or went.
    pub(super) fn gathered(&self) -> u64 {
        self.gathered
    }

    /// When a body last went, or its mesh did.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// Whether two bodies are there, with the meshes that they had at this time.
    pub(super) fn have_stayed(&self, two: [BodyId; 2], time: u64) -> bool {
        two.iter().all(|&id| self.get(id).is_ok_and(|body| body.meshed <= time))
    }

    /// Whether every body has changed since then.
    pub(super) fn all_changed_since(&self, time: u64) -> bool {
        self.known.iter().all(|&(_, changed)| changed > time)
    }

    /// When the later of two bodies changed, or was removed.
    pub(super) fn changed(&self, two: [BodyId; 2]) -> u64 {
        let [a, b] = two.map(|id| self.place(id).map_or(GONE, |place| self.known[place].1));
        a.max(b)
    }

    /// The same by places, as [`Bodies::compact`] left them.
    pub(super) fn changed_at(&self, two: [u32; 2]) -> u64 {
        let [a, b] = two.map(|place| self.known[place as usize].1);
        a.max(b)
    }

    /// The places of the bodies that have changed since the last call, each once, ascending; whether these
    /// are all. If one has come or gone since, that means nothing, but the call must be made.
    pub(super) fn take_moved(&mut self, into: &mut Vec<u32>) -> bool {
        into.clear();
        into.append(&mut self.moved);
        let all = into.len() <= self.live;
        into.sort_unstable();
        into.dedup();
        all
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter().flatten()
    }

    pub(super) fn add(
        &mut self,
        model: Arc<Model>,
        pose: AnyPose,
        options: BodyOptions,
    ) -> Result<BodyId, Error> {
        let id = BodyId(self.next);
        let body = Body::new(id, model, pose, options, self.time + 1)?;
        let is_of_gpu = body.is_of_gpu();
        self.reserve(1)?;
        self.bodies.push(Some(body));
        self.not_of_gpu += usize::from(!is_of_gpu);
        self.regathered();
        self.known.push((id, self.time));
        self.live += 1;
        self.next += 1;
        Ok(id)
    }

    /// Makes room for so many more bodies.
    pub(super) fn reserve(&mut self, additional: usize) -> Result<(), Error> {
        reserve(&mut self.known, additional)?;
        reserve(&mut self.bodies, additional)
    }

    pub(super) fn get(&self, id: BodyId) -> Result<&Body, Error> {
        let body = self.place(id).and_then(|place| self.bodies[place].as_ref());
        body.ok_or(Error::StaleBody { id })
    }

    /// A body and its place, as [`Bodies::compact`] left it.
    pub(super) fn placed(&self, id: BodyId) -> Result<(u32, &Body), Error> {
        let place = self.place(id).ok_or(Error::StaleBody { id })?;
        Ok((place as u32, self.get(id)?))
    }

    /// Changes a body, unless that fails.
    pub(super) fn change(
        &mut self,
        id: BodyId,
        change: impl FnOnce(&mut Body) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let place = self.place(id).ok_or(Error::StaleBody { id })?;
        let body = self.bodies[place].as_mut().ok_or(Error::StaleBody { id })?;
        // With as many as that it no longer pays to know which.
        let is_listed = self.moved.len() <= self.live;
        if is_listed {
            reserve(&mut self.moved, 1)?;
        }
        let was_of_gpu = body.is_of_gpu();
        change(body)?;
        self.not_of_gpu = self.not_of_gpu + usize::from(was_of_gpu) - usize::from(body.is_of_gpu());
        self.time += 1;
        self.known[place].1 = self.time;
        if is_listed {
            self.moved.push(place as u32);
        }
        Ok(())
    }

    /// Gives a body another mesh.
    pub(super) fn set_mesh(&mut self, id: BodyId, model: Arc<Model>) -> Result<(), Error> {
        let meshed = self.time + 1;
        self.change(id, |body| {
            body.pose.check(model.bvh())?;
            (body.model, body.meshed) = (model, meshed);
            body.reshaped();
            Ok(())
        })?;
        self.regathered();
        self.lost = self.time;
        Ok(())
    }

    /// # Complexity
    /// O(m log n) if m of n ignored pairs are of this body; amortised over the bodies that are removed.
    pub(super) fn remove(&mut self, id: BodyId) -> Result<Body, Error> {
        let place = self.place(id).ok_or(Error::StaleBody { id })?;
        let body = self.bodies[place].take().ok_or(Error::StaleBody { id })?;
        self.known[place].1 = GONE;
        self.live -= 1;
        self.not_of_gpu -= usize::from(!body.is_of_gpu());
        self.regathered();
        self.lost = self.time;
        let own = [id, BodyId(0)]..=[id, BodyId(u64::MAX)];
        while let Some(&[_, other]) = self.ignored.range(own.clone()).next() {
            self.ignored.remove(&[id, other]);
            self.ignored.remove(&[other, id]);
        }
        if self.bodies.len() - self.live > self.live + GAPS {
            self.compact();
        }
        Ok(body)
    }

    /// Ignores two bodies, or no longer.
    pub(super) fn ignore(&mut self, two: [BodyId; 2], ignored: bool) -> Result<(), Error> {
        for id in two {
            self.get(id)?;
        }
        let [a, b] = two;
        if self.ignored.contains(&[a, b]) == ignored {
            return Ok(());
        }
        // Hits that are kept of the two are no longer true, or no longer all.
        self.change(a, |_| Ok(()))?;
        for pair in [[a, b], [b, a]] {
            if ignored {
                self.ignored.insert(pair)
            } else {
                self.ignored.remove(&pair)
            };
        }
        Ok(())
    }

    pub(super) fn ignored(&self) -> impl Iterator<Item = [BodyId; 2]> {
        // A body may ignore itself, which means nothing.
        self.ignored.iter().copied().filter(|[a, b]| a <= b)
    }

    /// Whether two bodies are asked about if their bounds overlap, by their places.
    pub(super) fn may_meet(&self, two: [u32; 2]) -> bool {
        let [Some(a), Some(b)] = two.map(|place| self.at(place)) else { return false };
        if a.id == b.id {
            return a.options.itself.is_some();
        }
        a.options.groups.meet(&b.options.groups)
            && (self.ignored.is_empty() || !self.ignored.contains(&[a.id, b.id]))
    }

    /// Whether a GPU answers about two bodies, by their places: they are two, none is in f64, and no distance is asked for.
    pub(super) fn are_of_gpu(&self, two: [u32; 2]) -> bool {
        let is_f64 = |&place: &u32| self.at(place).is_some_and(Body::is_f64);
        self.are_all_of_gpu()
            || self.within == Distance::default() && two[0] != two[1] && !two.iter().any(is_f64)
    }

    pub(super) fn get_mut(&mut self, id: BodyId) -> Result<&mut Body, Error> {
        let place = self.place(id).ok_or(Error::StaleBody { id })?;
        self.bodies[place].as_mut().ok_or(Error::StaleBody { id })
    }

    /// Bodies have come or gone, or have other meshes.
    pub(super) fn regathered(&mut self) {
        self.time += 1;
        self.gathered = self.time;
    }

    /// By place, as [`Bodies::compact`] left them.
    pub(super) fn at(&self, place: u32) -> Option<&Body> {
        self.bodies[place as usize].as_ref()
    }

    /// Closes the gaps.
    pub(super) fn compact(&mut self) {
        if self.live < self.bodies.len() {
            self.known.retain(|&(_, changed)| changed != GONE);
            self.bodies.retain(Option::is_some);
        }
    }

    /// Where no earlier body has gone, a body is as far from the first as their ids are.
    fn place(&self, id: BodyId) -> Option<usize> {
        let guess = id.0.checked_sub(self.known.first()?.0.0)?.min(self.known.len() as u64 - 1);
        let guess = guess as usize;
        if self.known[guess].0 == id {
            return Some(guess);
        }
        self.known[..guess].binary_search_by_key(&id, |&(id, _)| id).ok()
    }
}
