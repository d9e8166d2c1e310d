//! Two meshes.

use crate::contacts::{Contacts, contacts_out};
use crate::mesh::Mesh;
use crate::thrown::{not_solid, thrown};
use crate::values::{Matrix, pairs_out};
use crate::wide::{JsGap, distance, f64_out, gap_out, pose};
use js_sys::{Float64Array, Uint32Array};
use pfront::{Error, Relation};
use std::mem::take;
use wasm_bindgen::prelude::*;

/// Asks which triangles of two meshes meet, the second in a pose: `matrix` takes coordinates of `b` to those of `a`. Keep one for each
/// two meshes that are asked about every frame.
#[wasm_bindgen]
#[derive(Default)]
pub struct PairQuery(pfront::PairQuery);

#[wasm_bindgen]
impl PairQuery {
    /// A query with empty buffers.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
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

    /// All pairs that meet, sorted: a triangle of `a` and one of `b` in turn. Throws a `PoseError`, as all questions do.
    pub fn all(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Uint32Array, JsValue> {
        let pose = pose(matrix.as_ref())?;
        pairs_out(self.0.all(&a.model, &b.model, pose).map_err(thrown)?)
    }

    /// Some pair that meets, if any does.
    pub fn any(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Option<Uint32Array>, JsValue> {
        let pose = pose(matrix.as_ref())?;
        let found = self.0.any(&a.model, &b.model, pose).map_err(thrown)?;
        found.map(|pair| pairs_out(&[pair])).transpose()
    }

    /// How many pairs meet.
    pub fn count(&mut self, a: &Mesh, b: &Mesh, matrix: Option<Matrix>) -> Result<f64, JsValue> {
        let pose = pose(matrix.as_ref())?;
        Ok(self.0.count(&a.model, &b.model, pose).map_err(thrown)? as f64)
    }

    /// All pairs that meet, with the segment in which they do and their normals, in the frame of `a`.
    pub fn contacts(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Contacts, JsValue> {
        let pose = pose(matrix.as_ref())?;
        let found = self.0.contacts(&a.model, &b.model, pose).map_err(thrown)?;
        contacts_out(found.iter().map(|(pair, contact)| (*pair, contact)), None)
    }

    /// The smallest distance of two surfaces, if it is at most `limit`. `undefined` also if a mesh has no triangles.
    pub fn distance(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
        limit: Option<f64>,
    ) -> Result<Option<JsGap>, JsValue> {
        let (a, b, pose) = (&a.model, &b.model, pose(matrix.as_ref())?);
        let found = match limit {
            None => self.0.distance(a, b, pose),
            Some(limit) => self.0.distance_below(a, b, pose, distance(limit)?),
        };
        found.map_err(thrown)?.map(|gap| gap_out(&gap, None)).transpose()
    }

    /// Tells in a word what one solid is to the other: `apart`, `near` (after `within`), `touching`, `crossing`, `a_in_b`, `b_in_a` or `equal`;
    /// `undefined` where it hangs on triangles that meet their own mesh. Throws a `NotSolid`, whose `mesh` is `"a"` or `"b"`, with
    /// the `triangle` and its `edge` that is open.
    #[wasm_bindgen(
        unchecked_return_type = "'apart' | 'near' | 'touching' | 'crossing' | 'a_in_b' | 'b_in_a' | 'equal' | undefined"
    )]
    pub fn relation(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Option<String>, JsValue> {
        let (a, b, pose) = (a.solid("a")?, b.solid("b")?, pose(matrix.as_ref())?);
        let between = self.0.relation(a, b, pose).map_err(thrown)?;
        Ok(between.relation.map(|word| Relation::as_str(word).to_owned()))
    }

    /// The volume that two solids have in common: the least and the greatest that it can be. Throws a `NotSolid`.
    #[wasm_bindgen(js_name = overlapVolume)]
    pub fn overlap_volume(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Float64Array, JsValue> {
        let (a, b, pose) = (a.solid("a")?, b.solid("b")?, pose(matrix.as_ref())?);
        let volume = self.0.overlap_volume(a, b, pose);
        f64_out(&volume.map_err(|fault| match fault {
            fault @ Error::Solid(_) => not_solid(fault, "a or b"),
            fault => thrown(fault),
        })?)
    }
}
