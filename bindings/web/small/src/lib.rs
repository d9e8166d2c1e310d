//! The small module: meshes in f32, and which triangles of two, or of one and itself, intersect. It is made of the core alone,
//! without what f64, distances and solids take.

#[path = "../../cpu/src/contacts.rs"]
mod contacts;
#[path = "../../cpu/src/error.rs"]
mod error;
#[path = "../../cpu/src/values.rs"]
mod values;

use crate::contacts::{Contacts, bytes_out, contacts_out, f32_out, octets};
use crate::error::{error, of_mesh, of_pose};
use crate::values::{Matrix, Positions, Triangles, columns, coordinates_f32, corners};
use crate::values::{pairs_out, pose_f32, u32_out, zeros};
use js_sys::{Float32Array, Uint8Array, Uint32Array};
use pfront_blob::{Blob, BlobError, BlobStorage, Counts, write};
use pfront_core::bvh::{BuildOptions, BvhStorage, Refit, node_bound, refit, sah};
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt, TrianglePair};
use pfront_core::one_ring::{Certified, OneRings, history_bound, link_scratch_bound};
use pfront_core::triangle::{Adjacency, Contact};
use pfront_core::{Bvh, CapacityError, Mesh as View, Node};
use std::ops::ControlFlow;
use wasm_bindgen::prelude::*;

/// A triangle mesh with the BVH that queries traverse.
#[wasm_bindgen]
#[derive(Default)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// The certificates of one-rings; empty until the mesh is asked about itself.
    history: Vec<u32>,
}

impl Mesh {
    /// It was checked when it was made.
    fn view(&self) -> View<'_> {
        View::new_unchecked(&self.positions, &self.triangles)
    }

    fn bvh(&self) -> Bvh<'_> {
        Bvh::new_unchecked(self.view(), &self.nodes, &self.order)
    }

    /// Builds the BVH of a mesh that was checked.
    fn build(&mut self) -> Result<(), JsValue> {
        let n = self.triangles.len();
        let (mut nodes, mut order) = (zeros(node_bound(n), Node::EMPTY)?, zeros(n, 0)?);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let mut scratch = zeros(n, Node::EMPTY)?;
        let built = sah(self.view(), &BuildOptions::default(), storage, &mut scratch);
        let used = built.map_err(|fault| of_capacity(&fault))?.nodes().len();
        nodes.truncate(used);
        (self.nodes, self.order) = (nodes, order);
        Ok(())
    }

    fn certify(&mut self) -> Result<(), JsValue> {
        let (vertices, n) = (self.positions.len(), self.triangles.len());
        let mut history = zeros(history_bound(vertices), 0)?;
        let mut scratch = zeros(link_scratch_bound(vertices, n), 0)?;
        let rings = OneRings::new(vertices, &self.triangles, &mut history, &mut scratch);
        rings.map_err(|fault| of_capacity(&fault))?.certify(self.view(), None);
        self.history = history;
        Ok(())
    }
}

#[wasm_bindgen]
impl Mesh {
    /// Checks a mesh and builds its BVH. Throws a `MeshError` with the `vertex` or the `triangle` at fault.
    #[wasm_bindgen(constructor)]
    pub fn new(positions: &Positions, triangles: &Triangles) -> Result<Self, JsValue> {
        let positions = coordinates_f32(positions)?.ok_or_else(in_f64)?;
        let mut mesh = Self { positions, triangles: corners(triangles)?, ..Self::default() };
        View::new(&mesh.positions, &mesh.triangles).map_err(|fault| of_mesh(&fault))?;
        mesh.build()?;
        Ok(mesh)
    }

    /// Reads a mesh and its BVH out of the bytes of a `.pfb`, which `pfront bake` writes. Throws a `BlobError` or a `MeshError`.
    #[wasm_bindgen(js_name = fromBlob)]
    pub fn from_blob(
        #[wasm_bindgen(unchecked_param_type = "Uint8Array | ArrayBuffer")] bytes: &JsValue,
    ) -> Result<Self, JsValue> {
        let bytes = octets(bytes)?;
        let blob = Blob::new(&bytes).map_err(|fault| of_blob(&fault))?;
        let counts = blob.counts();
        let mut mesh = Self {
            positions: zeros(counts.vertices, [0.0; 3])?,
            triangles: zeros(counts.triangles, [0; 3])?,
            nodes: zeros(counts.nodes, Node::EMPTY)?,
            order: zeros(counts.triangles, 0)?,
            history: Vec::new(),
        };
        let storage = BlobStorage {
            nodes: &mut mesh.nodes,
            positions: &mut mesh.positions,
            triangles: &mut mesh.triangles,
            order: &mut mesh.order,
        };
        let mut scratch = zeros(counts.triangles.div_ceil(32), 0)?;
        let bvh = blob.read_into(storage, &mut scratch).map_err(|fault| of_blob(&fault))?;
        // Refits rely on nodes that lie as a build lays them.
        if !bvh.is_depth_first() {
            mesh.build()?;
        }
        Ok(mesh)
    }

    /// The bytes of a `.pfb`.
    #[wasm_bindgen(js_name = toBlob)]
    pub fn to_blob(&self) -> Result<Uint8Array, JsValue> {
        let bvh = self.bvh();
        let mut bytes = zeros(Counts::of(&bvh).bytes(), 0)?;
        write(&bvh, &mut bytes).map_err(|fault| of_blob(&fault.into()))?;
        bytes_out(&bytes)
    }

    /// Moves the vertices, and refits the BVH. Throws a `MeshError`.
    #[wasm_bindgen(js_name = setPositions)]
    pub fn set_positions(&mut self, positions: &Positions) -> Result<(), JsValue> {
        let positions = coordinates_f32(positions)?.ok_or_else(in_f64)?;
        self.view().with_positions(&positions).map_err(|fault| of_mesh(&fault))?;
        self.positions = positions;
        self.history.clear();
        let mesh = View::new_unchecked(&self.positions, &self.triangles);
        let fitted = refit(mesh, &mut self.nodes, &self.order, Refit::default());
        fitted.map(drop).map_err(|fault| of_capacity(&fault))
    }

    /// A copy of the positions.
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Result<Float32Array, JsValue> {
        f32_out(self.positions.as_flattened())
    }

    /// A copy of the corners of triangles.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> Result<Uint32Array, JsValue> {
        u32_out(self.triangles.as_flattened())
    }

    /// The number of triangles.
    #[wasm_bindgen(getter, js_name = triangleCount)]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The number of vertices.
    #[wasm_bindgen(getter, js_name = vertexCount)]
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }
}

/// The pairs of the last question, in memory that the next uses again.
#[derive(Default)]
struct Pairs(Vec<TrianglePair>);

impl Pairs {
    /// Finds all pairs, sorted.
    #[inline(never)]
    fn all(&mut self, query: &impl Query) -> &[TrianglePair] {
        self.0.clear();
        let _ = query.visit(&mut query.start(), |pair| {
            self.0.push(pair);
            ControlFlow::Continue(())
        });
        self.0.sort_unstable();
        &self.0
    }

    fn contacts(&mut self, query: &impl Query) -> Result<Contacts, JsValue> {
        let mut found = crate::values::list::<(TrianglePair, Contact)>(self.all(query).len())?;
        // Each pair intersects, and has a contact.
        found.extend(self.0.iter().filter_map(|&pair| Some((pair, query.contact(pair)?))));
        contacts_out(found.iter().map(|(pair, contact)| (*pair, contact)), None)
    }
}

/// Asks which triangles of two meshes intersect, the second in a pose: `matrix` takes coordinates of `b` to those of `a`.
#[wasm_bindgen]
#[derive(Default)]
pub struct PairQuery(Pairs);

#[wasm_bindgen]
impl PairQuery {
    /// A query with empty buffers.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// All pairs that intersect, sorted: a triangle of `a` and one of `b` in turn. Throws a `PoseError`, as all questions do.
    pub fn all(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Uint32Array, JsValue> {
        pairs_out(self.0.all(&pair(a, b, matrix)?))
    }

    /// Some pair that intersects, if any does.
    pub fn any(
        &self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Option<Uint32Array>, JsValue> {
        pair(a, b, matrix)?.any().map(|pair| pairs_out(&[pair])).transpose()
    }

    /// How many pairs intersect.
    pub fn count(&self, a: &Mesh, b: &Mesh, matrix: Option<Matrix>) -> Result<f64, JsValue> {
        Ok(pair(a, b, matrix)?.count() as f64)
    }

    /// All pairs that intersect, with the segment in which they do and their normals, in the frame of `a`.
    pub fn contacts(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Contacts, JsValue> {
        self.0.contacts(&pair(a, b, matrix)?)
    }
}

/// Asks which triangles of one mesh intersect. A vertex or an edge that two share by index is no contact.
#[wasm_bindgen]
pub struct SelfQuery(Pairs, Adjacency);

#[wasm_bindgen]
impl SelfQuery {
    /// A query with empty buffers; it may leave out all pairs of triangles that share a vertex.
    #[wasm_bindgen(constructor)]
    pub fn new(skip_neighbours: Option<bool>) -> Self {
        match skip_neighbours {
            Some(true) => Self(Pairs::default(), Adjacency::SkipNeighbours),
            _ => Self(Pairs::default(), Adjacency::SharedIndexRule),
        }
    }

    /// All pairs that intersect, sorted: two triangles in turn, the smaller number first.
    pub fn all(&mut self, mesh: &mut Mesh) -> Result<Uint32Array, JsValue> {
        pairs_out(self.0.all(&itself(mesh, self.1)?))
    }

    /// Some pair that intersects, if any does.
    pub fn any(&self, mesh: &mut Mesh) -> Result<Option<Uint32Array>, JsValue> {
        itself(mesh, self.1)?.any().map(|pair| pairs_out(&[pair])).transpose()
    }

    /// How many pairs intersect.
    pub fn count(&self, mesh: &mut Mesh) -> Result<f64, JsValue> {
        Ok(itself(mesh, self.1)?.count() as f64)
    }

    /// All pairs that intersect, with the segment in which they do and their normals.
    pub fn contacts(&mut self, mesh: &mut Mesh) -> Result<Contacts, JsValue> {
        self.0.contacts(&itself(mesh, self.1)?)
    }
}

fn pair<'m>(a: &'m Mesh, b: &'m Mesh, matrix: Option<Matrix>) -> Result<PairBvtt<'m>, JsValue> {
    let (columns, is_f64) = columns(matrix.as_ref())?;
    if is_f64 {
        return Err(in_f64());
    }
    PairBvtt::new(a.bvh(), b.bvh(), pose_f32(&columns)).map_err(|fault| of_pose(&fault))
}

fn itself(mesh: &mut Mesh, adjacency: Adjacency) -> Result<SelfBvtt<'_>, JsValue> {
    if mesh.history.is_empty() {
        mesh.certify()?;
    }
    let certified = Certified::new_unchecked(mesh.view(), &mesh.history);
    Ok(SelfBvtt::new(mesh.bvh()).with_adjacency(adjacency).with_certificates(certified))
}

fn in_f64() -> JsValue {
    error("PfrontError", "the small module has no f64: import pfront instead", "", &[])
}

fn of_capacity(fault: &CapacityError) -> JsValue {
    error("PfrontError", &fault.to_string(), "", &[])
}

fn of_blob(fault: &BlobError) -> JsValue {
    match fault {
        BlobError::Mesh(fault) => of_mesh(fault),
        BlobError::InF64 => in_f64(),
        _ => error("BlobError", &fault.to_string(), "", &[]),
    }
}
