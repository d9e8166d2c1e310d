//! The module that asks a GPU, through WebGPU: which triangles of two meshes, or of one and itself, intersect, in f32.
//!
//! Answers are those of the CPU, to the bit. Every call that needs the device is awaited, and a query answers one question at a
//! time: `js/gpu.js` has the others wait.

#[path = "../../cpu/src/error.rs"]
mod error;
#[path = "../../cpu/src/values.rs"]
mod values;

use crate::error::{error, of_memory, of_mesh, of_pose};
use crate::values::{Matrix, Positions, Triangles, columns, coordinates_f32, corners, pairs_out};
use crate::values::{pose_f32, zeros};
use js_sys::Uint32Array;
use pfront_core::bvh::{BuildOptions, BvhStorage, node_bound, sah};
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::Adjacency;
use pfront_core::{Mesh as View, Node};
use pfront_gpu::{Budget, GpuError, GpuModel, GpuQuery, GpuQuestion, GpuSettings, GpuVerb};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r"
export namespace Mesh {
  /** The mesh of a BufferGeometry of three.js, with its index or without; its draw range and groups are not looked at. */
  function fromGeometry(gpu: Gpu, geometry: { attributes: { [name: string]: any }; index: any }): Promise<Mesh>;
}";

/// A GPU of the browser, with the passes compiled for it.
#[wasm_bindgen]
pub struct Gpu(pfront_gpu::Gpu);

#[wasm_bindgen]
impl Gpu {
    /// Opens the best GPU that the browser gives. Throws a `GpuError` where there is none.
    pub async fn open() -> Result<Self, JsValue> {
        pfront_gpu::Gpu::open().await.map(Self).map_err(thrown)
    }
}

/// A triangle mesh with its BVH in the memory of a GPU.
#[wasm_bindgen]
pub struct Mesh(GpuModel);

#[wasm_bindgen]
impl Mesh {
    /// Checks a mesh, builds its BVH and uploads both. Throws a `MeshError` with the `vertex` or the `triangle` at fault, or a
    /// `GpuError`.
    pub async fn upload(
        gpu: &Gpu,
        positions: &Positions,
        triangles: &Triangles,
    ) -> Result<Self, JsValue> {
        let positions = coordinates_f32(positions)?.ok_or_else(in_f64)?;
        let triangles = corners(triangles)?;
        let mesh = View::new(&positions, &triangles).map_err(|fault| of_mesh(&fault))?;
        let n = triangles.len();
        let (mut nodes, mut order) = (zeros(node_bound(n), Node::EMPTY)?, zeros(n, 0)?);
        let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
        let mut scratch = zeros(n, Node::EMPTY)?;
        let built = sah(mesh, &BuildOptions::default(), storage, &mut scratch);
        let bvh = built.map_err(|fault| thrown(fault.into()))?;
        let model = GpuModel::new(&gpu.0, bvh).map_err(thrown)?;
        gpu.0.settle().await.map_err(thrown)?;
        Ok(Self(model))
    }
}

/// The lists of a query on the device, and the pairs of its last answer.
struct Asker(GpuQuery, Vec<TrianglePair>);

impl Asker {
    fn new(gpu: &Gpu, budget: Option<f64>) -> Result<Self, JsValue> {
        let mut settings = gpu.0.settings();
        if let Some(bytes) = budget {
            settings = GpuSettings { budget: Budget { bytes: bytes as u64 }, ..settings };
        }
        let query = GpuQuery::with_settings(&gpu.0, settings).map_err(thrown)?;
        Ok(Self(query, Vec::new()))
    }

    async fn ask(&mut self, question: &GpuQuestion<'_>, verb: GpuVerb) -> Result<u64, JsValue> {
        self.0.submit(question, verb).map_err(thrown)?;
        self.0.read(&mut self.1).await.map_err(thrown)
    }

    async fn all(&mut self, question: &GpuQuestion<'_>) -> Result<Uint32Array, JsValue> {
        self.ask(question, GpuVerb::All).await?;
        pairs_out(&self.1)
    }

    async fn any(&mut self, question: &GpuQuestion<'_>) -> Result<Option<Uint32Array>, JsValue> {
        self.ask(question, GpuVerb::Any).await?;
        self.1.first().map(|pair| pairs_out(&[*pair])).transpose()
    }

    async fn count(&mut self, question: &GpuQuestion<'_>) -> Result<f64, JsValue> {
        Ok(self.ask(question, GpuVerb::Count).await? as f64)
    }
}

/// Asks which triangles of two meshes intersect, the second in a pose: `matrix` takes coordinates of `b` to those of `a`.
#[wasm_bindgen]
pub struct PairQuery(Asker);

#[wasm_bindgen]
impl PairQuery {
    /// A query whose lists take so many bytes on the device, 64 MiB if nothing else is said. Where they are full it goes on in
    /// parts. Throws a `GpuError`.
    #[wasm_bindgen(constructor)]
    pub fn new(gpu: &Gpu, budget: Option<f64>) -> Result<Self, JsValue> {
        Asker::new(gpu, budget).map(Self)
    }

    /// All pairs that intersect, sorted: a triangle of `a` and one of `b` in turn. Throws a `PoseError` or a `GpuError`, as all
    /// questions do.
    pub async fn all(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Uint32Array, JsValue> {
        self.0.all(&pair(a, b, matrix)?).await
    }

    /// Some pair that intersects, if any does.
    pub async fn any(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<Option<Uint32Array>, JsValue> {
        self.0.any(&pair(a, b, matrix)?).await
    }

    /// How many pairs intersect.
    pub async fn count(
        &mut self,
        a: &Mesh,
        b: &Mesh,
        matrix: Option<Matrix>,
    ) -> Result<f64, JsValue> {
        self.0.count(&pair(a, b, matrix)?).await
    }
}

/// Asks which triangles of one mesh intersect. A vertex or an edge that two share by index is no contact.
#[wasm_bindgen]
pub struct SelfQuery(Asker, Adjacency);

#[wasm_bindgen]
impl SelfQuery {
    /// A query as of two meshes; it may leave out all pairs of triangles that share a vertex.
    #[wasm_bindgen(constructor)]
    pub fn new(
        gpu: &Gpu,
        skip_neighbours: Option<bool>,
        budget: Option<f64>,
    ) -> Result<Self, JsValue> {
        let adjacency = match skip_neighbours {
            Some(true) => Adjacency::SkipNeighbours,
            _ => Adjacency::SharedIndexRule,
        };
        Ok(Self(Asker::new(gpu, budget)?, adjacency))
    }

    /// All pairs that intersect, sorted: two triangles in turn, the smaller number first.
    pub async fn all(&mut self, mesh: &Mesh) -> Result<Uint32Array, JsValue> {
        self.0.all(&itself(mesh, self.1)).await
    }

    /// Some pair that intersects, if any does.
    pub async fn any(&mut self, mesh: &Mesh) -> Result<Option<Uint32Array>, JsValue> {
        self.0.any(&itself(mesh, self.1)).await
    }

    /// How many pairs intersect.
    pub async fn count(&mut self, mesh: &Mesh) -> Result<f64, JsValue> {
        self.0.count(&itself(mesh, self.1)).await
    }
}

fn pair<'m>(a: &'m Mesh, b: &'m Mesh, matrix: Option<Matrix>) -> Result<GpuQuestion<'m>, JsValue> {
    let (columns, is_f64) = columns(matrix.as_ref())?;
    if is_f64 {
        return Err(in_f64());
    }
    Ok(GpuQuestion::pair(&a.0, &b.0, &pose_f32(&columns)))
}

fn itself(mesh: &Mesh, adjacency: Adjacency) -> GpuQuestion<'_> {
    GpuQuestion::Itself { model: &mesh.0, adjacency }
}

fn in_f64() -> JsValue {
    error("PfrontError", "GPUs have no f64 in a browser: ask on the CPU", "", &[])
}

/// The error that says the same.
fn thrown(fault: GpuError) -> JsValue {
    match fault {
        GpuError::Mesh(fault) => of_mesh(&fault),
        GpuError::Pose(fault) => of_pose(&fault),
        GpuError::Memory { needed } => of_memory(needed),
        _ => error("GpuError", &fault.to_string(), "", &[]),
    }
}
