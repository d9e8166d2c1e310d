//! Models as bytes: see [`pfront_blob`].

use super::Model;
use super::in_f64::Exact;
use super::passes::ONE_THREAD;
use super::tree::Tree;
use crate::Error;
use crate::environment::with_default;
use crate::memory::filled;
use pfront_blob::{Blob, BlobError, BlobStorage, Counts, write};
use pfront_core::Node;
use pfront_core::bvh::BuildOptions;

impl Model {
    /// Copies a mesh, in f32 or in f64, and its BVH out of a blob, wherever that lies, instead of building the BVH. Nothing in it
    /// is trusted.
    ///
    /// A BVH whose nodes do not lie as a build lays them is built anew, since refits rely on that. Rebuilds
    /// of a deforming mesh use [`BuildOptions::default`].
    ///
    /// # Errors
    /// [`Error::Blob`] says what is wrong with the bytes, [`Error::Mesh`] with the mesh in them.
    ///
    /// # Complexity
    /// O(bytes).
    ///
    /// # Examples
    /// ```
    /// use pfront::Model;
    /// let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// let mut bytes = model.to_blob()?;
    /// assert_eq!(Model::from_blob(&bytes)?.bvh().nodes(), model.bvh().nodes());
    ///
    /// bytes[100] ^= 1;
    /// assert!(Model::from_blob(&bytes).is_err());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn from_blob(bytes: &[u8]) -> Result<Self, Error> {
        with_default(|| Self::read_blob(bytes))
    }

    fn read_blob(bytes: &[u8]) -> Result<Self, Error> {
        let blob = Blob::new(bytes)?;
        let counts = blob.counts();
        let mut nodes = filled(Node::EMPTY, counts.nodes)?;
        let mut positions = filled([0.0; 3], counts.vertices)?;
        let mut triangles = filled([0; 3], counts.triangles)?;
        let mut order = filled(0, counts.triangles)?;
        let mut positions_f64 = filled([0.0; 3], counts.positions_f64)?;
        let storage = BlobStorage {
            nodes: &mut nodes,
            positions: &mut positions,
            triangles: &mut triangles,
            order: &mut order,
        };
        let mut scratch = filled(0, counts.triangles.div_ceil(32))?;
        let bvh = blob.read_into_f64(storage, &mut positions_f64, &mut scratch)?;
        let (as_built, origin) = (bvh.is_depth_first(), bvh.mesh().origin());
        let exact = blob.is_f64().then_some(Exact { positions: positions_f64, origin });
        let mesh = Exact::mesh(exact.as_ref(), &positions, &triangles);
        let options = BuildOptions::default();
        let tree = if as_built {
            Tree::adopt(mesh, nodes, order, ONE_THREAD)
        } else {
            Tree::build(mesh, options, ONE_THREAD)?
        };
        Ok(Self { exact, ..Self::of(positions, triangles, options, tree) })
    }

    /// The mesh and its BVH as a blob, the same on every machine.
    ///
    /// # Errors
    /// [`Error::Blob`] if there are 2³² vertices or more; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(bytes); they are [`Counts::bytes`].
    pub fn to_blob(&self) -> Result<Vec<u8>, Error> {
        let bvh = self.bvh();
        let mut bytes = filled(0, Counts::of(&bvh).bytes())?;
        with_default(|| write(&bvh, &mut bytes)).map_err(BlobError::from)?;
        Ok(bytes)
    }
}
