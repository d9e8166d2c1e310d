//! The broad phase: which bodies' boxes and spheres overlap.
//!
//! A box is a triangle through two of its opposite corners, so that a BVH over boxes is the BVH of a
//! [`Model`], which is refitted while the boxes move and rebuilt when its quality says so; and the pairs
//! that overlap are those of a self-query that looks at boxes only.

use super::bodies::Bodies;
use crate::{BuildOptions, Error, Model};
use pfront_core::query::{Query, SelfQuery};
use pfront_core::sphere::Sphere;
use std::ops::ControlFlow;

/// Two bodies by their places in the list.
pub(super) type Places = [u32; 2];

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
}

impl Broad {
    /// Finds the pairs anew.
    ///
    /// # Complexity
    /// O(n + pairs) for n bodies that move little, O(n log n) when their number has changed.
    pub(super) fn update(&mut self, bodies: &Bodies) -> Result<(), Error> {
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
                let (corners, options) = (self.corners.clone(), BuildOptions { leaf_size: 2 });
                self.boxes.insert(Model::with_options(corners, diagonals.collect(), options)?)
            }
        };
        let query = SelfQuery::new(boxes.bvh()).boxes_only();
        self.pairs.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            let [a, b] = [pair.a, pair.b].map(|i| i as usize);
            if self.spheres[a].overlaps(&self.spheres[b]) {
                self.pairs.push([self.places[a], self.places[b]]);
            }
            ControlFlow::Continue(())
        });
        self.pairs.sort_unstable();
        Ok(())
    }

    /// The pairs in order of bodies, the first of each before the second.
    pub(super) fn pairs(&self) -> &[Places] {
        &self.pairs
    }
}
