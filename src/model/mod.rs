//! A mesh and its BVH, owned.

mod blob;
mod certificates;
mod deform;
mod in_f64;
mod moves;
mod outline;
mod passes;
mod rebuild;
mod renewed;
mod segment;
mod stamp;
mod tree;

pub use deform::Scalar;
pub(crate) use outline::Outline;
pub use stamp::Stamp;

use crate::Error;
use crate::environment::with_default;
use crate::memory::{copy, filled};
use crate::sphere::Sphere;
use certificates::Certificates;
use in_f64::Exact;
use moves::Moves;
pub(crate) use passes::{ONE_THREAD, Parallel, THREADS};
use pfront_core::bvh::BuildOptions;
use pfront_core::one_ring::Certified;
use pfront_core::relation::{NotSolid, Rule};
use pfront_core::triangle::Adjacency;
use pfront_core::{Bvh, Mesh};
use renewed::Renewed;
pub(crate) use segment::hits;
use std::fmt;
use std::panic::resume_unwind;
use std::sync::{Arc, OnceLock};
use tree::Tree;

/// A triangle mesh with the BVH that queries traverse. Scenes and batches share it in an [`Arc`](std::sync::Arc); pair and
/// self queries borrow it.
///
/// Takes 12 bytes a vertex, 24 more in f64, and, a triangle, 12 for its indices, 4 for the order and up to 64 for
/// nodes (about 11 with the default leaf size); once it was asked about itself, 4 more a vertex, and once
/// it deforms on four threads or more, 4 a vertex and 16 a triangle beside; once few of its vertices have
/// moved, up to 24 more a triangle (about 4).
///
/// # Examples
/// ```
/// use pfront::Model;
/// let model = Model::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
/// assert_eq!(model.mesh().triangles().len(), 1);
/// # Ok::<(), pfront::Error>(())
/// ```
pub struct Model {
    /// The positions, or those of the shadow for a mesh in f64.
    positions: Vec<[f32; 3]>,
    /// Set for a mesh in f64.
    exact: Option<Exact>,
    triangles: Vec<[u32; 3]>,
    options: BuildOptions<'static>,
    stamp: Stamp,
    /// Since the tree fitted, or fitted last.
    moves: Moves,
    tree: Renewed<Tree>,
    /// Made when the mesh is first asked about itself.
    certificates: Renewed<Certificates>,
    /// Whether there are vertices of many triangles; found when the mesh is first asked about itself without neighbours.
    has_fans: OnceLock<bool>,
    /// Made when a scene first asks for it.
    sphere: OnceLock<Option<Sphere>>,
    /// Found when a scene first asks whether a point is inside.
    rule: OnceLock<Result<Rule, NotSolid>>,
}

/// Without the mesh, which may be large.
impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Model")
            .field("vertices", &self.positions.len())
            .field("triangles", &self.triangles.len())
            .finish_non_exhaustive()
    }
}

impl Model {
    /// Checks the mesh and builds its BVH with the surface area heuristic. With options, on threads:
    /// [`Executor::build`](crate::Executor::build).
    ///
    /// Positions in f64 have a name of their own, [`Model::from_f64`], since Rust takes numbers like `0.1` for f64 where both do.
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first vertex or triangle at fault; [`Error::Memory`].
    ///
    /// # Complexity
    /// O(n log n) for n triangles.
    ///
    /// # Examples
    /// The buffers of an engine take a line each. Vertices that interleave with more, and 16-bit indices:
    /// ```
    /// # use pfront::Model;
    /// # struct Vertex { position: [f32; 3], normal: [f32; 3] }
    /// # let normal = [0.0, 0.0, 1.0];
    /// # let vertices = [[0.0; 3], normal, [1.0; 3]].map(|position| Vertex { position, normal });
    /// let indices: &[u16] = &[0, 1, 2];
    /// let positions = vertices.iter().map(|vertex| vertex.position).collect();
    /// let (triangles, rest) = indices.as_chunks::<3>();
    /// assert!(rest.is_empty());
    /// let model = Model::new(positions, triangles.iter().map(|t| t.map(u32::from)).collect())?;
    /// # assert_eq!(model.mesh().shadow_triangle(0)[1], normal);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    /// Flat arrays:
    /// ```
    /// # use pfront::Model;
    /// let (flat, indices) = ([0.0_f32; 9], [0_u32, 1, 2]);
    /// let model = Model::new(flat.as_chunks().0.to_vec(), indices.as_chunks().0.to_vec())?;
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        Self::build(positions, triangles, BuildOptions::default(), ONE_THREAD)
    }

    pub(crate) fn build<S: Scalar>(
        positions: Vec<[S; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Self, Error> {
        with_default(|| S::build(positions, triangles, options, parallel))
    }

    fn built(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Self, Error> {
        let tree = Tree::build(Mesh::new(&positions, &triangles)?, options, parallel)?;
        Ok(Self::of(positions, triangles, options, tree))
    }

    /// [`Model::new`] with positions in f64: queries pose and decide them there, exactly, whatever the other model and the
    /// pose.
    ///
    /// Takes 24 bytes a vertex more, unless f32 holds every coordinate. A GPU answers about two models of which one or the pose is in f64
    /// by their shadows, and leaves to the CPU what these do not tell; about one model in f64 and itself, and about such bodies of a
    /// scene, only a CPU answers.
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first vertex or triangle at fault; coordinates are at most 2^125. [`Error::Memory`].
    ///
    /// # Complexity
    /// As [`Model::new`].
    ///
    /// # Examples
    /// ```
    /// use pfront::{Model, PairQuery, Pose};
    /// // A square metre in a coordinate system of the earth, and one a micrometre above it: f32 tells neither apart.
    /// let square = |z| {
    ///     let corner = |x, y| [500_000.0 + x, 5_000_000.0 + y, 1_000.0 + z];
    ///     Model::from_f64(vec![corner(0.1, 0.1), corner(1.1, 0.1), corner(0.1, 1.1)], vec![[0, 1, 2]])
    /// };
    /// let (floor, above) = (square(0.0)?, square(1e-6)?);
    /// assert_eq!(PairQuery::new().count(&floor, &above, Pose::IDENTITY)?, 0);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn from_f64(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, Error> {
        Self::build(positions, triangles, BuildOptions::default(), ONE_THREAD)
    }

    fn built_from_f64(
        positions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Self, Error> {
        let mut shadow = filled([0.0; 3], positions.len())?;
        let mesh = Mesh::from_f64(&positions, &triangles, &mut shadow)?;
        let widened =
            |p: &[f64; 3]| p.iter().all(|x| f64::from(*x as f32).to_bits() == x.to_bits());
        let exact = if positions.iter().all(widened) {
            let narrowed = positions.iter().map(|p| p.map(|x| x as f32));
            shadow.iter_mut().zip(narrowed).for_each(|(own, p)| *own = p);
            Exact { positions: Vec::new(), origin: [0.0; 3] }
        } else {
            let origin = mesh.origin();
            Exact { positions, origin }
        };
        let mesh = Exact::mesh(Some(&exact), &shadow, &triangles);
        let tree = Tree::build(mesh, options, parallel)?;
        Ok(Self { exact: Some(exact), ..Self::of(shadow, triangles, options, tree) })
    }

    /// A mesh that is checked, and its tree.
    fn of(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        tree: Tree,
    ) -> Self {
        Self {
            positions,
            exact: None,
            triangles,
            options,
            stamp: Stamp::new(),
            moves: Moves::default(),
            tree: Renewed::new(tree),
            certificates: Renewed::unmade(),
            has_fans: OnceLock::new(),
            sphere: OnceLock::new(),
            rule: OnceLock::new(),
        }
    }

    /// Whether positions are in f64: the model is one of [`Model::from_f64`].
    #[must_use]
    pub fn is_f64(&self) -> bool {
        self.exact.is_some()
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> Mesh<'_> {
        Exact::mesh(self.exact.as_ref(), &self.positions, &self.triangles)
    }

    /// The BVH. After [`Model::set_positions_unfitted`], it is refitted at the first call.
    #[inline]
    #[must_use]
    pub fn bvh(&self) -> Bvh<'_> {
        self.tree().bvh(self.mesh())
    }

    /// The one-ring certificates that self-collision uses: made at the first call, which takes as long as a
    /// refit or two, and kept up to date from then on, as the BVH is. None, and another try at the next call, if there is no
    /// memory for them.
    #[must_use]
    pub fn certificates(&self) -> Certified<'_> {
        let mesh = self.mesh();
        let renew = |stale: &mut Certificates| with_default(|| stale.renew(mesh, ONE_THREAD));
        let make = || with_default(|| Certificates::new(mesh)).ok();
        let Some(certificates) = self.certificates.try_get(renew, make) else {
            return Certified::new_unchecked(mesh, &[]);
        };
        let certified = certificates.certified(mesh);
        if certificates.has_fans() { self.tree().with_fans(certified, mesh) } else { certified }
    }

    /// The certificates that a self query under a rule for neighbours uses. Where they are left out, a common vertex is enough,
    /// and only the marks around vertices of many triangles save time.
    pub(crate) fn certificates_for(&self, adjacency: Adjacency) -> Certified<'_> {
        let mesh = self.mesh();
        let has_fans =
            || *self.has_fans.get_or_init(|| with_default(|| Certificates::are_for_fans(mesh)));
        if adjacency == Adjacency::SkipNeighbours && !has_fans() {
            return Certified::new_unchecked(mesh, &[]);
        }
        self.certificates()
    }

    /// A sphere that contains every triangle, found at the first call and at the next after the model has
    /// changed, in O(n); `None` if there is no triangle.
    #[must_use]
    pub fn sphere(&self) -> Option<Sphere> {
        *self.sphere.get_or_init(|| with_default(|| Sphere::of(&self.bvh())))
    }

    /// Numbers that tell this mesh, BVH and positions from all others: what is equal to an earlier stamp need not be
    /// looked at again.
    ///
    /// # Complexity
    /// O(1).
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// How the BVH is built.
    #[must_use]
    pub fn options(&self) -> BuildOptions<'static> {
        self.options
    }

    /// Bytes of heap memory the model holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.positions.capacity() * size_of::<[f32; 3]>()
            + self.exact.as_ref().map_or(0, Exact::bytes)
            + self.triangles.capacity() * size_of::<[u32; 3]>()
            + self.moves.bytes()
            + self.tree.map(Tree::bytes).unwrap_or_else(|| self.tree().bytes())
            + self.certificates.map(Certificates::bytes).unwrap_or_default()
    }

    /// The model of an [`Arc`], which is copied first, without what is made lazily, if others have it too.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub(crate) fn make_mut(model: &mut Arc<Self>) -> Result<&mut Self, Error> {
        if Arc::get_mut(model).is_none() {
            *model = Arc::new(model.try_clone()?);
        }
        Ok(Arc::make_mut(model))
    }

    /// A copy with the same [stamp](Model::stamp), without what is made lazily, as [`Clone`] makes it where memory may not be
    /// missing.
    ///
    /// # Errors
    /// [`Error::Memory`].
    ///
    /// # Complexity
    /// O(vertices + triangles).
    ///
    /// # Examples
    /// ```
    /// # let model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// assert_eq!(model.try_clone()?.stamp(), model.stamp());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn try_clone(&self) -> Result<Self, Error> {
        let (positions, triangles) = (copy(&self.positions)?, copy(&self.triangles)?);
        let exact = self.exact.as_ref().map(Exact::try_clone).transpose()?;
        let tree = self.tree().try_clone()?;
        let (stamp, sphere, rule) = (self.stamp, self.sphere.clone(), self.rule.clone());
        let new = Self::of(positions, triangles, self.options, tree);
        Ok(Self { exact, stamp, sphere, rule, ..new })
    }

    /// The tree as it fits the positions.
    #[inline]
    fn tree(&self) -> &Tree {
        self.tree.fresh().unwrap_or_else(|| self.fitted())
    }

    /// The tree, after it has been fitted. This is no place for threads: see [`Renewed`].
    #[cold]
    fn fitted(&self) -> &Tree {
        let (mesh, options) = (self.mesh(), &self.options);
        self.tree.get(
            |tree| with_default(|| tree.fit(mesh, *options, &self.moves, ONE_THREAD)),
            // Lost by a thread that panicked: where there is no memory for another, that panic goes on here.
            || {
                let built = with_default(|| Tree::build(mesh, *options, ONE_THREAD));
                built.unwrap_or_else(|error| resume_unwind(Box::new(error)))
            },
        )
    }
}

impl Clone for Model {
    fn clone(&self) -> Self {
        let mut tree = self.tree.clone();
        // A thread that fits it is waited for: built anew it would be another.
        if tree.map(|_| ()).is_none() {
            tree = Renewed::new(self.tree().clone());
        }
        Self {
            positions: self.positions.clone(),
            exact: self.exact.clone(),
            triangles: self.triangles.clone(),
            options: self.options,
            stamp: self.stamp,
            moves: self.moves.clone(),
            tree,
            certificates: self.certificates.clone(),
            has_fans: self.has_fans.clone(),
            sphere: self.sphere.clone(),
            rule: self.rule.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::bvtt::Query;
    use pfront_testkit::rng::{RngExt, seeded};
    use pfront_testkit::shapes::sheet;

    /// Neighbours are left out without one-rings, but for the marks around a vertex of many triangles, certified or not.
    #[test]
    fn one_rings_are_made_for_fans_alone_where_neighbours_are_left_out() {
        let rule = Adjacency::SkipNeighbours;
        let flat = sheet(5, |_, _| 0.0);
        let model = Model::new(flat.positions, flat.triangles).unwrap();
        model.certificates_for(rule);
        assert!(model.certificates.fresh().is_none());
        // A disc that is crumpled, so that its centre is not certified.
        let rim = |i: u32| [(0.5 * i as f32).cos(), (0.5 * i as f32).sin(), (i % 3) as f32];
        let points = std::iter::once([0.0; 3]).chain((0..100).map(rim)).collect();
        let triangles = (0..100).map(|i| [0, 1 + i, 1 + (i + 1) % 100]).collect();
        let model = Model::new(points, triangles).unwrap();
        assert!(!model.certificates_for(rule).is_certified(0));
        let tree = pfront_core::bvtt::SelfBvtt::new(model.bvh()).with_adjacency(rule);
        assert!(!tree.start().is_done());
        assert!(tree.with_certificates(model.certificates_for(rule)).start().is_done());
    }

    #[test]
    fn the_stamp_of_a_tree_that_is_to_be_built_changes_with_the_positions() {
        let (island, count) = (sheet(5, |_, _| 0.0), 60);
        let n = island.positions.len();
        let mut rng = seeded(1);
        // Many sheets, each somewhere else.
        let mut thrown = |spread: f32| -> Vec<[f32; 3]> {
            let places = (0..count).map(|_| [0; 3].map(|_| rng.random_range(-spread..=spread)));
            let place = |by: [f32; 3]| island.positions.iter().map(move |&p| add(p, by));
            places.flat_map(place).collect()
        };
        let name = |k: usize| move |t: &[u32; 3]| t.map(|vertex| vertex + (k * n) as u32);
        let triangles = (0..count).flat_map(|k| island.triangles.iter().map(name(k))).collect();
        let mut model = Model::new(thrown(0.0), triangles).unwrap();
        model.set_positions_unfitted(&thrown(60.0)).unwrap();
        assert!(model.tree().is_worn_out(), "to be built at the next positions");
        model.set_positions_unfitted(&thrown(60.0)).unwrap();
        let mut copy = model.clone();
        copy.set_positions(&thrown(60.0)).unwrap();
        assert_ne!(model.bvh().order(), copy.bvh().order());
        assert_ne!(model.stamp().tree(), copy.stamp().tree());
    }

    fn add(p: [f32; 3], by: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| p[k] + by[k])
    }
}
