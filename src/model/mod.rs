//! A mesh and its BVH, owned.

mod stamp;

pub use stamp::Stamp;

use crate::Error;
use pfront_core::build::{self, BuildOptions, BvhStorage, REBUILD_RATIO, SahItem};
use pfront_core::bvh::node_bound;
use pfront_core::fans::{self, Fan};
use pfront_core::sphere::Sphere;
use pfront_core::{Bvh, CapacityError, Mesh, Node};
use std::sync::OnceLock;

/// A triangle mesh with the BVH that queries walk.
///
/// Takes 12 bytes a vertex and, a triangle, 12 for its indices, 4 for the order and up to 64 for
/// nodes (about 11 with the default leaf size); once it was asked about itself, 4 more a vertex.
///
/// # Examples
/// ```
/// use pfront::Model;
/// let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
/// assert_eq!(model.mesh().triangles().len(), 1);
/// # Ok::<(), pfront::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Model {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    order: Vec<u32>,
    options: BuildOptions,
    stamp: Stamp,
    /// The quality figure right after the last build.
    built: f32,
    /// Made when the mesh is first asked about itself.
    fans: OnceLock<Vec<Fan>>,
    /// Made when a scene first asks for it.
    sphere: OnceLock<Option<Sphere>>,
}

/// The passes over a whole model, on as many threads as one likes.
struct Passes {
    sah: Sah,
    refit: Refit,
    /// The quality figure of a tree that fits.
    quality: Refit,
    /// Does two things, at once if it can.
    both: Both,
}

type Sah = for<'a> fn(
    Mesh<'a>,
    &BuildOptions,
    BvhStorage<'a>,
    &mut [SahItem],
) -> Result<Bvh<'a>, CapacityError>;
type Both = fn(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send));
type Refit = fn(Mesh<'_>, &mut [Node], &[u32]) -> f32;

const ONE_THREAD: Passes = Passes {
    sah: build::sah,
    refit: build::refit,
    quality: |mesh, nodes, order| build::quality(&Bvh::trusted(mesh, nodes, order)),
    both: |one, other| {
        one();
        other();
    },
};

/// A refit changes no box that fits.
#[cfg(feature = "threads")]
const THREADS: Passes = Passes {
    sah: crate::threads::sah,
    refit: crate::threads::refit,
    quality: crate::threads::refit,
    both: crate::threads::join,
};

impl Model {
    /// Checks the mesh and builds its BVH with the surface area heuristic.
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first vertex or triangle at fault.
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        Self::with_options(positions, triangles, BuildOptions::default())
    }

    /// [`Model::new`] with other build options. They change speed and memory, never an answer.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn with_options(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions,
    ) -> Result<Self, Error> {
        Self::built_by(&ONE_THREAD, positions, triangles, options)
    }

    /// [`Model::with_options`] in the rayon pool of whoever asks; worth it from some 50,000 triangles
    /// on. The BVH is the same.
    ///
    /// # Errors
    /// As [`Model::new`].
    #[cfg(feature = "threads")]
    pub fn new_with_threads(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions,
    ) -> Result<Self, Error> {
        Self::built_by(&THREADS, positions, triangles, options)
    }

    fn built_by(
        passes: &Passes,
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions,
    ) -> Result<Self, Error> {
        Mesh::new(&positions, &triangles)?;
        let (nodes, order, stamp) = (Vec::new(), Vec::new(), Stamp::new());
        let (built, fans, sphere) = (0.0, OnceLock::new(), OnceLock::new());
        let mut model =
            Self { positions, triangles, nodes, order, options, stamp, built, fans, sphere };
        model.rebuild(passes)?;
        Ok(model)
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh::trusted(&self.positions, &self.triangles)
    }

    /// The BVH.
    #[must_use]
    pub fn bvh(&self) -> Bvh<'_> {
        Bvh::trusted(self.mesh(), &self.nodes, &self.order)
    }

    /// What self-collision knows of the triangles about each vertex: made at the first call, which takes
    /// as long as a refit or two, and kept up to date by [`Model::set_positions`] from then on.
    #[must_use]
    pub fn fans(&self) -> &[Fan] {
        self.fans.get_or_init(|| {
            let mesh = self.mesh();
            let mut fans = vec![Fan::default(); mesh.positions().len()];
            let need = fans::link_scratch_bound(fans.len(), mesh.triangles().len());
            // Neither fails with buffers of the right size; without a certificate a query is slower.
            let made = fans::link(mesh, &mut vec![0; need], &mut fans)
                .and_then(|()| fans::certify(mesh, &mut fans));
            debug_assert_eq!(made, Ok(()));
            fans
        })
    }

    /// A sphere that contains every triangle, found at the first call and at the next after the model has
    /// changed, in O(n); `None` if there is no triangle.
    ///
    /// # Examples
    /// ```
    /// let model = pfront::Model::new(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], vec![[0, 1, 2]])?;
    /// assert!(model.sphere().is_some_and(|sphere| (1.41..1.42).contains(&sphere.radius)));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    #[must_use]
    pub fn sphere(&self) -> Option<Sphere> {
        *self.sphere.get_or_init(|| Sphere::of(&self.bvh()))
    }

    /// Which mesh, BVH and positions these are: what is equal to an earlier stamp need not be looked at
    /// again.
    ///
    /// # Complexity
    /// O(1).
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// How the BVH is built.
    #[must_use]
    pub fn options(&self) -> BuildOptions {
        self.options
    }

    /// Moves the vertices of a deforming mesh and refits the BVH; rebuilds it when its quality
    /// figure has grown by [`REBUILD_RATIO`] since the last build. On error nothing has changed.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices + triangles); a rebuild is O(n log n) and allocates 32 bytes a triangle while it
    /// runs. A refit allocates nothing.
    ///
    /// # Examples
    /// ```
    /// # let mut model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// assert!(model.set_positions(&[[0.0, f32::INFINITY, 0.0]; 3]).is_err());
    /// model.set_positions(&[[1.0; 3]; 3])?;
    /// assert_eq!(model.mesh().positions()[2], [1.0; 3]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.deform(positions, &ONE_THREAD)
    }

    /// [`Model::set_positions`] in the rayon pool of whoever asks; worth it from some 50,000 triangles on.
    /// A rebuild may come a frame earlier or later.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    #[cfg(feature = "threads")]
    pub fn set_positions_with_threads(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.deform(positions, &THREADS)
    }

    fn deform(&mut self, positions: &[[f32; 3]], passes: &Passes) -> Result<(), Error> {
        self.mesh().with_positions(positions)?;
        if same_bits(positions, &self.positions) {
            return Ok(());
        }
        self.positions.copy_from_slice(positions);
        self.stamp.moved();
        self.sphere.take();
        let mesh = Mesh::trusted(&self.positions, &self.triangles);
        let (mut cost, mut certified) = (0.0, Ok(()));
        let mut refit = || cost = (passes.refit)(mesh, &mut self.nodes, &self.order);
        match self.fans.get_mut() {
            Some(fans) => (passes.both)(&mut refit, &mut || certified = fans::certify(mesh, fans)),
            None => refit(),
        }
        certified?;
        if cost > self.built * REBUILD_RATIO {
            self.stamp.rebuilt();
            self.rebuild(passes)?;
        }
        Ok(())
    }

    /// Builds the BVH anew for the present positions.
    fn rebuild(&mut self, passes: &Passes) -> Result<(), Error> {
        let n = self.triangles.len();
        let mesh = Mesh::trusted(&self.positions, &self.triangles);
        self.nodes.resize(node_bound(n), Node::EMPTY);
        self.order.resize(n, 0);
        let mut scratch = vec![SahItem::default(); build::sah_scratch_bound(n)];
        let storage = BvhStorage { nodes: &mut self.nodes, order: &mut self.order };
        let used = (passes.sah)(mesh, &self.options, storage, &mut scratch)?.nodes().len();
        self.nodes.truncate(used);
        self.nodes.shrink_to_fit();
        self.built = (passes.quality)(mesh, &mut self.nodes, &self.order);
        Ok(())
    }

    /// Bytes of heap memory the model holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.positions.capacity() * size_of::<[f32; 3]>()
            + self.triangles.capacity() * size_of::<[u32; 3]>()
            + self.nodes.capacity() * size_of::<Node>()
            + self.order.capacity() * size_of::<u32>()
            + self.fans.get().map_or(0, |fans| fans.capacity() * size_of::<Fan>())
    }
}

/// Whether the same numbers are in both, zeros with their signs.
fn same_bits(a: &[[f32; 3]], b: &[[f32; 3]]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits))
}
