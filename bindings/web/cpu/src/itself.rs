//! One mesh with itself.

use crate::contacts::{Contacts, contacts_out};
use crate::mesh::Mesh;
use crate::thrown::thrown;
use crate::values::pairs_out;
use crate::wide::distance;
use js_sys::Uint32Array;
use pfront::Adjacency;
use std::mem::take;
use wasm_bindgen::prelude::*;

/// Asks which triangles of one mesh meet each other. A vertex or an edge that two share by index is no contact.
#[wasm_bindgen]
pub struct SelfQuery(pfront::SelfQuery);

#[wasm_bindgen]
impl SelfQuery {
    /// A query with empty buffers; it may leave out all pairs of triangles that share a vertex.
    #[wasm_bindgen(constructor)]
    pub fn new(skip_neighbours: Option<bool>) -> Self {
        let adjacency = match skip_neighbours {
            Some(true) => Adjacency::SkipNeighbours,
            _ => Adjacency::SharedIndexRule,
        };
        Self(pfront::SelfQuery::new().with_adjacency(adjacency))
    }

    /// Asks from now on for pairs at most so far apart, in place of those that intersect. Throws a `DistanceError`.
    pub fn within(&mut self, apart: f64) -> Result<(), JsValue> {
        let apart = distance(apart)?;
        self.0 = take(&mut self.0).within(apart).map_err(thrown)?;
        Ok(())
    }

    /// Forgets the last answer, so that the same question is answered anew, as a measurement wants it.
    pub fn forget(&mut self) {
        self.0.forget();
    }

    /// All pairs that meet, sorted: two triangles in turn, the smaller number first.
    pub fn all(&mut self, mesh: &Mesh) -> Result<Uint32Array, JsValue> {
        pairs_out(self.0.all(&mesh.model).map_err(thrown)?)
    }

    /// Some pair that meets, if any does.
    pub fn any(&mut self, mesh: &Mesh) -> Result<Option<Uint32Array>, JsValue> {
        let found = self.0.any(&mesh.model).map_err(thrown)?;
        found.map(|pair| pairs_out(&[pair])).transpose()
    }

    /// How many pairs meet.
    pub fn count(&mut self, mesh: &Mesh) -> Result<f64, JsValue> {
        Ok(self.0.count(&mesh.model).map_err(thrown)? as f64)
    }

    /// All pairs that meet, with the segment in which they do and their normals.
    pub fn contacts(&mut self, mesh: &Mesh) -> Result<Contacts, JsValue> {
        let found = self.0.contacts(&mesh.model).map_err(thrown)?;
        contacts_out(found.iter().map(|(pair, contact)| (*pair, contact)), None)
    }
}
