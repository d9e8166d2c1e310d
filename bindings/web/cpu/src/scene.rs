//! Many bodies in one world.

use crate::contacts::{Contacts, contacts_out};
use crate::mesh::Mesh;
use crate::thrown::thrown;
use crate::values::{Matrix, Positions, list, u32_out};
use crate::wide::{Coordinates, JsGap, coordinates, distance, gap_out, pose};
use js_sys::Uint32Array;
use pfront::{Adjacency, BodyId, BodyOptions, Error, SceneHit};
use wasm_bindgen::prelude::*;

/// Asks which triangles of many bodies meet, each body against each. A body is a mesh in a pose: its matrix takes coordinates of the
/// mesh to those of the world. Ids are 0, 1, 2, ... in the order of adding, and none is used again. Hits of bodies that stand still
/// are kept.
#[wasm_bindgen]
#[derive(Default)]
pub struct SceneQuery(pfront::SceneQuery);

#[wasm_bindgen]
impl SceneQuery {
    /// A query of no bodies.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body and returns its id. It is asked about itself, too, if that is wanted, as cloth is. Throws a `PoseError`.
    pub fn add(
        &mut self,
        mesh: &Mesh,
        matrix: Option<Matrix>,
        itself: Option<bool>,
    ) -> Result<u32, JsValue> {
        let itself = itself.unwrap_or_default().then_some(Adjacency::SharedIndexRule);
        let options = BodyOptions { itself, ..BodyOptions::default() };
        let pose = pose(matrix.as_ref())?;
        let id = self.0.add_with(mesh.model.clone(), pose, options).map_err(thrown)?;
        if id.to_bits() >= u64::from(u32::MAX) {
            self.0.remove(id).map_err(thrown)?;
            return Err(thrown(Error::StaleBody { id }));
        }
        Ok(id.to_bits() as u32)
    }

    /// Removes a body. Throws a `StaleBody` if it is not there, as all that names one does.
    pub fn remove(&mut self, body: u32) -> Result<(), JsValue> {
        self.0.remove(name(body)).map(drop).map_err(thrown)
    }

    /// Moves a body. Throws a `PoseError`.
    #[wasm_bindgen(js_name = setPose)]
    pub fn set_pose(&mut self, body: u32, matrix: Matrix) -> Result<(), JsValue> {
        self.0.set_pose(name(body), pose(Some(&matrix))?).map_err(thrown)
    }

    /// Moves the vertices of a body in its own frame. Throws a `MeshError`.
    #[wasm_bindgen(js_name = setPositions)]
    pub fn set_positions(&mut self, body: u32, positions: &Positions) -> Result<(), JsValue> {
        let moved = match coordinates(positions)? {
            Coordinates::F32(positions) => self.0.set_positions(name(body), &positions),
            Coordinates::F64(positions) => self.0.set_positions(name(body), &positions),
        };
        moved.map_err(thrown)
    }

    /// Leaves two bodies out, as the links of a joint, or no longer.
    pub fn ignore(&mut self, a: u32, b: u32, ignored: bool) -> Result<(), JsValue> {
        self.0.ignore(name(a), name(b), ignored).map_err(thrown)
    }

    /// Asks from now on for pairs at most so far apart, in place of those that intersect. Throws a `DistanceError`.
    pub fn within(&mut self, apart: f64) -> Result<(), JsValue> {
        self.0.within(distance(apart)?).map_err(thrown)
    }

    /// All pairs that meet, sorted: two bodies, a triangle of the first and one of the second in turn.
    pub fn all(&mut self) -> Result<Uint32Array, JsValue> {
        let hits = self.0.all().map_err(thrown)?;
        let mut rows = list(hits.len())?;
        hits.iter().for_each(|hit| rows.push(row(hit)));
        u32_out(rows.as_flattened())
    }

    /// Some pair that meets, if any does.
    pub fn any(&mut self) -> Result<Option<Uint32Array>, JsValue> {
        self.0.any().map_err(thrown)?.map(|hit| u32_out(&row(&hit))).transpose()
    }

    /// How many pairs meet.
    pub fn count(&mut self) -> Result<f64, JsValue> {
        Ok(self.0.count().map_err(thrown)? as f64)
    }

    /// All pairs that meet, with their bodies, the segment in which they do and their normals, in the world.
    pub fn contacts(&mut self) -> Result<Contacts, JsValue> {
        let found = self.0.contacts().map_err(thrown)?;
        let mut bodies = list(found.len())?;
        found.iter().for_each(|(hit, _)| bodies.push(hit.bodies.map(number)));
        let rows = found.iter().map(|(hit, contact)| (hit.pair, contact));
        contacts_out(rows, Some(bodies.as_flattened()))
    }

    /// The bodies that meet, two in turn.
    #[wasm_bindgen(js_name = intersectingBodies)]
    pub fn intersecting_bodies(&mut self) -> Result<Uint32Array, JsValue> {
        let found = self.0.intersecting_bodies().map_err(thrown)?;
        let mut rows = list(found.len())?;
        found.iter().for_each(|bodies| rows.push(bodies.map(number)));
        u32_out(rows.as_flattened())
    }

    /// The body that is nearest to one, and how far it is, if that is at most `limit`; `undefined` if there is none.
    pub fn distance(&mut self, body: u32, limit: Option<f64>) -> Result<Option<JsGap>, JsValue> {
        let found = match limit {
            None => self.0.distance(name(body)),
            Some(limit) => self.0.distance_below(name(body), distance(limit)?),
        };
        let found = found.map_err(thrown)?;
        found.map(|(nearest, gap)| gap_out(&gap, Some(number(nearest)))).transpose()
    }
}

fn name(body: u32) -> BodyId {
    BodyId::from_bits(body.into())
}

/// No body of a larger number is in a scene.
fn number(id: BodyId) -> u32 {
    id.to_bits() as u32
}

fn row(hit: &SceneHit) -> [u32; 4] {
    let [a, b] = hit.bodies.map(number);
    [a, b, hit.pair.a, hit.pair.b]
}
