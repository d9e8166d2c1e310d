//! The broad phase: which bodies' boxes and spheres overlap.
//!
//! A box is a triangle through two of its opposite corners, so that a BVH over boxes is the BVH of a
//! [`Model`], which is refitted while the boxes move and rebuilt when its quality says so; and the pairs
//! that overlap are those of a self-query that looks at boxes only. Where few bodies have moved, only their
//! boxes go down that BVH, and all other pairs are those of the last frame.

use super::bodies::Bodies;
use super::cache::merge;
use crate::sphere::Sphere;
use crate::{Aabb, BuildOptions, Error, Model};
use pfront_core::bvh::MAX_DEPTH;
use pfront_core::bvtt::{Query, SelfBvtt};
use std::ops::ControlFlow;

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
    spheres: Vec<Sphere>,
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
    pub(super) fn update(&mut self, bodies: &mut Bodies) -> Result<(), Error> {
        if self.at == bodies.time() {
            return Ok(());
        }
        // After an error nothing is known of the last frame.
        let at = std::mem::take(&mut self.at);
        self.found_since = None;
        let known = bodies.take_moved(&mut self.moved) && bodies.gathered() <= at;
        if known && self.moved.len() < self.places.len() / MANY {
            self.update_moved(bodies, at)?;
        } else {
            self.update_all(bodies)?;
        }
        self.at = bodies.time();
        Ok(())
    }

    fn update_all(&mut self, bodies: &Bodies) -> Result<(), Error> {
        self.corners.clear();
        self.spheres.clear();
        self.places.clear();
        for (body, place) in bodies.iter().zip(0..) {
            if let Some((aabb, sphere)) = body.bounds() {
                self.corners.extend([aabb.min, aabb.max]);
                self.spheres.push(sphere);
                self.places.push(place);
            }
        }
        let boxes = match &mut self.boxes {
            Some(model) if model.mesh().triangles().len() == self.places.len() => {
                model.set_positions(&self.corners)?;
                model
            }
            _ => {
                let diagonals =
                    (0..self.places.len() as u32).map(|i| [2 * i, 2 * i + 1, 2 * i + 1]);
                let (corners, options) = (
                    self.corners.clone(),
                    BuildOptions { leaf_size: 2, ..BuildOptions::default() },
                );
                let model = Model::with_options(corners, diagonals.collect(), options)?;
                let model = self.boxes.insert(model);
                model.reserve();
                model
            }
        };
        let query = SelfBvtt::new(boxes.bvh()).boxes_only();
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            let [a, b] = [pair.a, pair.b].map(|i| i as usize);
            if self.spheres[a].overlaps(&self.spheres[b]) {
                self.pairs.push([self.places[a], self.places[b]]);
            }
            ControlFlow::Continue(())
        });
        // No pair of bodies that have moved is known by itself now, so its memory is free.
        let bodies = self.places.last().map_or(0, |last| *last as usize + 1);
        sort(&mut self.pairs, &mut self.found, &mut self.starts, bodies);
        Ok(())
    }

    /// Where the bodies are those of the last frame, at the time `at`, and few have moved.
    fn update_moved(&mut self, bodies: &Bodies, at: u64) -> Result<(), Error> {
        let Some(boxes) = &mut self.boxes else { return Ok(()) };
        for &place in &self.moved {
            let (Ok(i), Some(body)) = (self.places.binary_search(&place), bodies.at(place)) else {
                continue;
            };
            if let Some((aabb, sphere)) = body.bounds() {
                self.corners[2 * i..][..2].copy_from_slice(&[aabb.min, aabb.max]);
                self.spheres[i] = sphere;
            }
        }
        boxes.set_positions(&self.corners)?;
        self.pairs.retain(|&pair| bodies.changed_at(pair) <= at);
        self.found.clear();
        for &place in &self.moved {
            let Ok(own) = self.places.binary_search(&place) else { continue };
            let [min, max] = [self.corners[2 * own], self.corners[2 * own + 1]];
            overlapping(boxes, &Aabb { min, max }, |i| {
                let other = self.places[i];
                // If two have moved, the first finds the second.
                let once = other > place || other < place && bodies.changed_at([other; 2]) <= at;
                if once && self.spheres[own].overlaps(&self.spheres[i]) {
                    self.found.push([place.min(other), place.max(other)]);
                }
            });
        }
        self.found.sort_unstable();
        merge(&mut self.pairs, &self.found, |pair| *pair);
        self.found_since = Some(at);
        Ok(())
    }

    /// The pairs in order of bodies, the first of each before the second.
    pub(super) fn pairs(&self) -> &[Places] {
        &self.pairs
    }

    /// Pairs with a body that has changed since, if they are a list of their own.
    pub(super) fn changed_since(&self, since: u64) -> Option<&[Places]> {
        match since {
            0 => Some(&self.pairs),
            _ => self.found_since.is_some_and(|own| own == since).then_some(&self.found),
        }
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
) {
    for side in [1, 0] {
        starts.clear();
        starts.resize(bodies + 1, 0);
        pairs.iter().for_each(|pair| starts[pair[side] as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        scratch.clear();
        scratch.resize(pairs.len(), Places::default());
        for pair in &*pairs {
            let start = &mut starts[pair[side] as usize];
            scratch[*start] = *pair;
            *start += 1;
        }
        std::mem::swap(pairs, scratch);
    }
    scratch.clear();
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
