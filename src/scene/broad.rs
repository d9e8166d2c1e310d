//! The broad phase: which bodies' boxes and spheres overlap.
//!
//! A box is a triangle through two of its opposite corners, so that a BVH over boxes is the BVH of a
//! [`Model`], which is refitted while the boxes move and rebuilt when its quality says so; and the pairs
//! that overlap are those of a self-query that looks at boxes only. Where few bodies have moved, only their
//! boxes go down that BVH, and all other pairs are those of the last frame.

use super::bodies::Bodies;
use super::body::Body;
use super::cache::merge;
use crate::executor::{BLOCK, check, visit};
use crate::memory::{copy, push, reserve};
use crate::model::ONE_THREAD;
use crate::sphere::Sphere;
use crate::{Aabb, BuildOptions, Bvh, Distance, Error, Model, Pose, TrianglePair};
use pfront_core::bvh::{MAX_DEPTH, Refit, refit};
use pfront_core::bvtt::{PosedBvh, SelfBvtt};
use pfront_core::motion::MovingBvh;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;

/// Two bodies by their places in the list.
pub(super) type Places = [u32; 2];

/// With one in so many bodies moving, all pairs are found anew.
const MANY: usize = 8;

#[derive(Clone, Debug, Default)]
pub(super) struct Broad {
    /// The boxes of the last frame.
    boxes: Option<Model>,
    /// Smallest and largest corner of each box.
    corners: Vec<[f32; 3]>,
    /// The sphere of each box that one of another body has overlapped.
    spheres: Vec<Option<Sphere>>,
    /// The place of the body of each box: empty ones have none.
    places: Vec<u32>,
    pairs: Vec<Places>,
    /// Pairs of bodies that have moved, and these.
    found: Vec<Places>,
    /// Where the pairs of each body begin, while pairs are sorted.
    starts: Vec<usize>,
    moved: Vec<u32>,
    /// The time since when the pairs of bodies that have changed are `found`, if they are.
    found_since: Option<u64>,
    /// The time of the last frame.
    at: u64,
}

impl Broad {
    /// Finds the pairs as of now, of bodies without gaps.
    ///
    /// # Complexity
    /// O(n + pairs) for n bodies, O(n log n) when their number has changed. With m of them moving, the box
    /// tests are O(m log n + pairs).
    ///
    /// # Errors
    /// [`Error::Cancelled`] once the flag is set, [`Error::Memory`]; [`Error::Mesh`] if there are more than 2^31 bodies.
    pub(super) fn update(
        &mut self,
        bodies: &mut Bodies,
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Error> {
        if self.at == bodies.time() {
            return Ok(());
        }
        // After an error nothing is known of the last frame.
        let at = std::mem::take(&mut self.at);
        self.found_since = None;
        let known = bodies.take_moved(&mut self.moved) && bodies.gathered() <= at;
        if known && self.moved.len() < self.places.len() / MANY {
            self.update_moved(bodies, at, cancel)?;
        } else {
            self.update_all(bodies, cancel)?;
        }
        self.at = bodies.time();
        Ok(())
    }

    fn update_all(&mut self, bodies: &Bodies, cancel: Option<&AtomicBool>) -> Result<(), Error> {
        self.corners.clear();
        self.spheres.clear();
        self.places.clear();
        reserve(&mut self.corners, 2 * bodies.len())?;
        reserve(&mut self.places, bodies.len())?;
        reserve(&mut self.spheres, bodies.len())?;
        self.pairs.clear();
        for (body, place) in bodies.iter().zip(0..) {
            if let Some(aabb) = body.aabb() {
                self.corners.extend([aabb.min, aabb.max]);
                self.places.push(place);
                if body.options.itself.is_some() {
                    push(&mut self.pairs, [place; 2])?;
                }
            }
        }
        self.spheres.resize(self.places.len(), None);
        check(cancel)?;
        let boxes = match &mut self.boxes {
            Some(model) if model.mesh().triangles().len() == self.places.len() => {
                model.set_positions(&self.corners)?;
                model
            }
            _ => {
                let mut diagonals = Vec::new();
                reserve(&mut diagonals, self.places.len())?;
                let count = self.places.len() as u32;
                diagonals.extend((0..count).map(|i| [2 * i, 2 * i + 1, 2 * i + 1]));
                let (corners, options) = (copy(&self.corners)?, BuildOptions::default());
                let model = Model::build(corners, diagonals, options, ONE_THREAD)?;
                let model = self.boxes.insert(model);
                model.reserve();
                model
            }
        };
        check(cancel)?;
        let query = SelfBvtt::new(boxes.bvh()).boxes_only().within(bodies.within);
        let Self { pairs, spheres, places, .. } = self;
        let mut pushed = Ok(());
        visit(&query, cancel, |pair| {
            let [a, b] = [pair.a, pair.b].map(|i| i as usize);
            if overlap(bodies, places, spheres, [a, b]) {
                pushed = push(pairs, [places[a], places[b]]);
            }
            if pushed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })?;
        pushed?;
        // No pair of bodies that have moved is known by itself now, so its memory is free.
        let bodies = self.places.last().map_or(0, |last| *last as usize + 1);
        sort(&mut self.pairs, &mut self.found, &mut self.starts, bodies, cancel)
    }

    /// Where the bodies are those of the last frame, at the time `at`, and few have moved.
    fn update_moved(
        &mut self,
        bodies: &Bodies,
        at: u64,
        cancel: Option<&AtomicBool>,
    ) -> Result<(), Error> {
        let Some(boxes) = &mut self.boxes else { return Ok(()) };
        for &place in &self.moved {
            let (Ok(i), Some(body)) = (self.places.binary_search(&place), bodies.at(place)) else {
                continue;
            };
            if let Some(aabb) = body.aabb() {
                self.corners[2 * i..][..2].copy_from_slice(&[aabb.min, aabb.max]);
                self.spheres[i] = None;
            }
        }
        boxes.set_positions(&self.corners)?;
        check(cancel)?;
        self.pairs.retain(|&pair| bodies.changed_at(pair) <= at);
        let Self { found, spheres, places, .. } = self;
        found.clear();
        let mut pushed = Ok(());
        for &place in &self.moved {
            check(cancel)?;
            let Ok(own) = places.binary_search(&place) else { continue };
            if bodies.at(place).is_some_and(|body| body.options.itself.is_some()) {
                push(found, [place; 2])?;
            }
            let [min, max] = [self.corners[2 * own], self.corners[2 * own + 1]];
            overlapping(boxes, &grown(&Aabb { min, max }, bodies.within), |i| {
                let other = places[i];
                // If two have moved, the first finds the second.
                let once = other > place || other < place && bodies.changed_at([other; 2]) <= at;
                if once && pushed.is_ok() && overlap(bodies, places, spheres, [own, i]) {
                    pushed = push(found, [place.min(other), place.max(other)]);
                }
            });
        }
        pushed?;
        crate::executor::sort(&mut self.found, cancel)?;
        merge(&mut self.pairs, &self.found)?;
        self.found_since = Some(at);
        Ok(())
    }

    /// The pairs in order of bodies, the first of each before the second; a body that is asked about itself is there twice.
    pub(super) fn pairs(&self) -> &[Places] {
        &self.pairs
    }

    /// The places of the bodies whose box overlaps one, in no order.
    pub(super) fn in_box(&self, aabb: &Aabb, mut visit: impl FnMut(u32)) {
        if let Some(boxes) = &self.boxes {
            overlapping(boxes, aabb, |i| visit(self.places[i]));
        }
    }

    /// Calls `visit` for each two bodies whose boxes are within a distance at a time while they move, until it breaks. The boxes at the end are those given, by
    /// ascending places, and those of now of all other bodies.
    ///
    /// # Errors
    /// [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n + pairs) for n bodies.
    pub(super) fn while_moving(
        &self,
        ends: &[(u32, Option<Aabb>)],
        within: Distance,
        mut visit: impl FnMut(Places) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let Some(boxes) = &self.boxes else { return Ok(()) };
        let mut corners = copy(&self.corners)?;
        for (place, aabb) in ends {
            if let (Ok(i), Some(Aabb { min, max })) = (self.places.binary_search(place), *aabb) {
                corners[2 * i..][..2].copy_from_slice(&[min, max]);
            }
        }
        let start = boxes.bvh();
        let (mesh, mut nodes) = (start.mesh().with_positions(&corners)?, copy(start.nodes())?);
        refit(mesh, &mut nodes, start.order(), Refit::default())?;
        let end = Bvh::new_unchecked(mesh, &nodes, start.order());
        let [start, end] = [start, end].map(|bvh| PosedBvh::new_unchecked(bvh, &Pose::IDENTITY));
        let query = SelfBvtt::moving(MovingBvh::new_unchecked(start, end)).boxes_only();
        let query = query.within(within);
        let _ = query.visit(|TrianglePair { a, b }, _| {
            let [a, b] = [a, b].map(|i| self.places[i as usize]);
            visit([a.min(b), a.max(b)])
        });
        Ok(())
    }

    /// Pairs with a body that has changed since, if they are a list of their own.
    pub(super) fn changed_since(&self, since: u64) -> Option<&[Places]> {
        match since {
            0 => Some(&self.pairs),
            _ => self.found_since.is_some_and(|own| own == since).then_some(&self.found),
        }
    }
}

/// Whether the spheres of two bodies are as near as is asked, whose boxes are, by the numbers of these.
fn overlap(
    bodies: &Bodies,
    places: &[u32],
    spheres: &mut [Option<Sphere>],
    two: [usize; 2],
) -> bool {
    let [a, b] = two.map(|i| match spheres[i] {
        Some(sphere) => Some(sphere),
        None => {
            spheres[i] = bodies.at(places[i]).map(Body::sphere);
            spheres[i]
        }
    });
    let (Some(a), Some(b)) = (a, b) else { return false };
    a.is_near(&b, bodies.within)
}

/// A box that contains all that is so near another.
fn grown(aabb: &Aabb, within: Distance) -> Aabb {
    if within == Distance::default() {
        return *aabb;
    }
    Aabb {
        min: aabb.min.map(|x| (x - within.get()).next_down()),
        max: aabb.max.map(|x| (x + within.get()).next_up()),
    }
}

/// Sorts pairs of so many bodies: counting sorts by the second of each and then by the first, since comparing would take longer
/// than it took to find them.
///
/// # Complexity
/// O(bodies + pairs).
fn sort(
    pairs: &mut Vec<Places>,
    scratch: &mut Vec<Places>,
    starts: &mut Vec<usize>,
    bodies: usize,
    cancel: Option<&AtomicBool>,
) -> Result<(), Error> {
    scratch.clear();
    starts.clear();
    reserve(scratch, pairs.len())?;
    reserve(starts, bodies + 1)?;
    for side in [1, 0] {
        starts.clear();
        starts.resize(bodies + 1, 0);
        for block in pairs.chunks(BLOCK) {
            check(cancel)?;
            block.iter().for_each(|pair| starts[pair[side] as usize + 1] += 1);
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        scratch.clear();
        scratch.resize(pairs.len(), Places::default());
        for block in pairs.chunks(BLOCK) {
            check(cancel)?;
            for pair in block {
                let start = &mut starts[pair[side] as usize];
                scratch[*start] = *pair;
                *start += 1;
            }
        }
        std::mem::swap(pairs, scratch);
    }
    scratch.clear();
    Ok(())
}

/// The boxes that overlap one, which is perhaps among them.
fn overlapping(boxes: &Model, aabb: &Aabb, mut visit: impl FnMut(usize)) {
    let bvh = boxes.bvh();
    let nodes = bvh.nodes();
    // A descent leaves one node behind a level.
    let (mut waiting, mut len) = ([0_u32; MAX_DEPTH + 1], usize::from(!nodes.is_empty()));
    while len > 0 {
        len -= 1;
        let node = &nodes[waiting[len] as usize];
        if !node.aabb().overlaps(aabb) {
            continue;
        }
        if node.is_leaf() {
            for &i in &bvh.order()[node.first as usize..][..node.count as usize] {
                if Aabb::of(&bvh.mesh().shadow_triangle(i)).overlaps(aabb) {
                    visit(i as usize);
                }
            }
        } else {
            waiting[len..len + 2].copy_from_slice(&[node.first, node.first + 1]);
            len += 2;
        }
    }
}
