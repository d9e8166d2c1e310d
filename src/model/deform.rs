//! Moving the vertices of a model, and updating its tree and certificates.

use super::Model;
use super::in_f64::{Exact, Shadow};
use super::moves::same_bits;
use super::passes::{ONE_THREAD, Parallel, all_parts, both, copy_parts, if_four_threads};
use super::tree::Tree;
use crate::environment::with_default;
use crate::memory::{copy, filled};
use crate::{Aabb, Error};
use pfront_core::bvh::BuildOptions;
use pfront_core::{Mesh, MeshError};

impl Model {
    /// Moves the vertices of a deforming mesh and refits the BVH. When its quality figure has grown by
    /// [`REBUILD_RATIO`](pfront_core::bvh::REBUILD_RATIO) since the last build, another one is built over the next calls, a
    /// part with each that takes about half as long as the refit; when it has doubled, at once. On the threads of an executor:
    /// [`Executor::refit`](crate::Executor::refit).
    ///
    /// On error nothing has changed, nor if the positions are the present ones to the bit: the
    /// [`Model::stamp`] stays. Where few vertices have moved, only the BVH near these is looked at.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite, or beyond 2^125 in f64, if the number of vertices differs, or if the
    /// positions are not in the precision of the model. (Rust takes numbers like `0.1` for f64 unless told otherwise.)
    ///
    /// # Complexity
    /// O(vertices + triangles); O(vertices) if few have moved that are near one another. A rebuild is
    /// O(n log n) in all and holds up to 100 bytes a triangle while it is under way. A refit allocates nothing, but for the
    /// first of few vertices: see [`Model`]. In f64 all positions count as moved, and 36 bytes a vertex are allocated.
    ///
    /// # Examples
    /// ```
    /// # let mut model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// assert!(model.set_positions(&[[0.0, f32::INFINITY, 0.0]; 3]).is_err());
    /// model.set_positions(&[[1.0_f32; 3]; 3])?;
    /// assert_eq!(model.mesh().shadow()[2], [1.0; 3]);
    ///
    /// let mut in_f64 = pfront::Model::from_f64(vec![[0.1; 3]; 3], vec![[0, 1, 2]])?;
    /// in_f64.set_positions(&[[0.3_f64; 3]; 3])?;
    /// assert_eq!(in_f64.mesh().positions_f64(), Some(&[[0.3; 3]; 3][..]));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions<S: Scalar>(&mut self, positions: &[[S; 3]]) -> Result<(), Error> {
        self.deform(positions, ONE_THREAD)
    }

    /// [`Model::set_positions`] that leaves the BVH alone until it is asked for, as a query on a GPU never
    /// does.
    ///
    /// The first query refits it then on its own thread; [`Model::fit`] does
    /// it ahead of time. If the quality figure has grown too much by then, these rebuild the BVH; else the
    /// refit after the next call of this is a rebuild, and the [`Model::stamp`] says so from that call on.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    ///
    /// # Complexity
    /// O(vertices).
    ///
    /// # Examples
    /// ```
    /// # let mut model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// model.set_positions_unfitted(&[[1.0_f32; 3]; 3])?;
    /// model.set_positions_unfitted(&[[2.0_f32; 3]; 3])?;
    /// assert_eq!(model.bvh().nodes()[0].min, [2.0; 3]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions_unfitted<S: Scalar>(&mut self, positions: &[[S; 3]]) -> Result<(), Error> {
        with_default(|| {
            let checked = S::check(self, positions, ONE_THREAD)?;
            S::store(self, positions, checked, ONE_THREAD);
            Ok(())
        })
    }

    /// Fits the BVH, and rebuilds it if that is due, after [`Model::set_positions_unfitted`].
    ///
    /// # Complexity
    /// As [`Model::set_positions`]; O(1) if the BVH fits.
    pub fn fit(&mut self) {
        with_default(|| self.fit_by(ONE_THREAD));
    }

    pub(crate) fn deform<S: Scalar>(
        &mut self,
        positions: &[[S; 3]],
        parallel: Parallel,
    ) -> Result<(), Error> {
        with_default(|| {
            let checked = S::check(self, positions, parallel)?;
            self.deform_checked(positions, checked, parallel);
            Ok(())
        })
    }

    /// Takes positions that are checked, and fits the BVH to them.
    pub(crate) fn deform_checked<S: Scalar>(
        &mut self,
        positions: &[[S; 3]],
        checked: S::Checked,
        parallel: Parallel,
    ) {
        if S::store(self, positions, checked, parallel) {
            self.fit_by(parallel);
        }
    }

    /// Takes note, before positions change, that nothing will fit them.
    pub(super) fn outdate(&mut self) {
        // It will be built for these positions.
        let mesh = Exact::mesh(self.exact.as_ref(), &self.positions, &self.triangles);
        if self.tree.map(|tree| tree.is_due(mesh)) == Some(true) {
            self.stamp.rebuilt();
        }
        if self.tree.fresh().is_some() {
            self.moves.clear();
        }
        self.stamp.moved();
        self.tree.outdate();
        self.certificates.outdate();
        self.sphere.take();
        self.rule.take();
    }

    pub(super) fn fit_by(&mut self, parallel: Parallel) {
        let mesh = Exact::mesh(self.exact.as_ref(), &self.positions, &self.triangles);
        let (moves, options) = (&self.moves, self.options);
        let fit = |tree: &mut Tree| tree.fit(mesh, options, moves, parallel);
        // After few moves, certificates would take longer than the rest: they wait until they are asked for.
        let few = moves.few().is_some();
        match (self.tree.stale_mut(), self.certificates.stale_mut().filter(|_| !few)) {
            (Some(tree), Some(certificates)) => {
                both(parallel, &mut || fit(tree), &mut || {
                    certificates.renew(mesh, if_four_threads(parallel));
                });
            }
            (Some(tree), None) => fit(tree),
            (None, Some(certificates)) => certificates.renew(mesh, parallel),
            (None, None) => {}
        }
        self.tree.renewed();
        if !few {
            self.certificates.renewed();
        }
        if let Some(tree) = self.tree.fresh_mut().filter(|tree| tree.is_worn_out()) {
            // Without memory for another it stays, only slower, until the next positions.
            if tree.rebuild(mesh, options, parallel).is_ok() {
                self.stamp.rebuilt();
            }
        }
    }

    /// Makes room for what refits need that are of few vertices, so that not even the first allocates.
    pub(crate) fn reserve(&mut self) {
        self.moves.reserve(self.positions.len());
        if let Some(tree) = self.tree.fresh_mut() {
            tree.reserve();
        }
    }
}

/// The precision of positions: f32 or f64.
pub trait Scalar: Positions {}

impl Scalar for f32 {}
impl Scalar for f64 {}

/// Positions of one precision. Nobody else implements it.
pub trait Positions: Copy + Send + Sync + 'static {
    /// The result of a check: the shadow in f64, nothing in f32.
    type Checked: Send;

    fn build(
        positions: Vec<[Self; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Model, Error>;

    /// Checks other positions of a model.
    fn check(
        model: &Model,
        positions: &[[Self; 3]],
        parallel: Parallel,
    ) -> Result<Self::Checked, Error>;

    /// The box of positions, rounded to f32.
    fn bounds(positions: &[[Self; 3]], checked: &Self::Checked) -> Aabb;

    /// Whether they are those of a model, to the bit.
    fn is_same(model: &Model, positions: &[[Self; 3]]) -> bool;

    /// Takes positions that are checked, after which nothing fits any more; returns whether they are others.
    fn store(
        model: &mut Model,
        positions: &[[Self; 3]],
        checked: Self::Checked,
        parallel: Parallel,
    ) -> bool;
}

impl Positions for f32 {
    type Checked = ();

    fn build(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Model, Error> {
        Model::built(positions, triangles, options, parallel)
    }

    fn check(model: &Model, positions: &[[f32; 3]], parallel: Parallel) -> Result<(), Error> {
        // The floating-point environment of this thread, which may do no part.
        Mesh::new(&[], &[])?;
        if model.exact.is_some() {
            return Err(MeshError::OtherPrecision.into());
        }
        let is_valid = model.positions.len() == positions.len()
            && all_parts(parallel, positions, &|part| Mesh::new(part, &[]).is_ok());
        if !is_valid {
            model.mesh().with_positions(positions)?;
        }
        Ok(())
    }

    fn bounds(positions: &[[f32; 3]], (): &()) -> Aabb {
        Aabb::of(positions)
    }

    fn is_same(model: &Model, positions: &[[f32; 3]]) -> bool {
        model.exact.is_none() && same_bits(positions, &model.positions)
    }

    fn store(model: &mut Model, positions: &[[f32; 3]], (): (), parallel: Parallel) -> bool {
        if Self::is_same(model, positions) {
            return false;
        }
        model.outdate();
        model.moves.add(&model.positions, positions);
        copy_parts(parallel, positions, &mut model.positions);
        true
    }
}

impl Positions for f64 {
    type Checked = Shadow;

    fn build(
        positions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
        parallel: Parallel,
    ) -> Result<Model, Error> {
        Model::built_from_f64(positions, triangles, options, parallel)
    }

    fn check(model: &Model, positions: &[[f64; 3]], _: Parallel) -> Result<Shadow, Error> {
        let mut shadow = filled([0.0; 3], positions.len())?;
        let origin = model.mesh().with_positions_f64(positions, &mut shadow)?.origin();
        Ok(Shadow { exact: copy(positions)?, positions: shadow, origin })
    }

    fn bounds(_: &[[f64; 3]], shadow: &Shadow) -> Aabb {
        shadow.bounds()
    }

    fn is_same(model: &Model, positions: &[[f64; 3]]) -> bool {
        let Some(exact) = &model.exact else { return false };
        let bits = positions.iter().map(|p| p.map(f64::to_bits));
        match exact.positions[..] {
            // The shadow holds every coordinate.
            [] => bits.eq(model.positions.iter().map(|p| p.map(|x| f64::from(x).to_bits()))),
            _ => bits.eq(exact.positions.iter().map(|p| p.map(f64::to_bits))),
        }
    }

    fn store(model: &mut Model, positions: &[[f64; 3]], shadow: Shadow, _: Parallel) -> bool {
        if Self::is_same(model, positions) {
            return false;
        }
        model.outdate();
        model.moves.add_all();
        let Shadow { exact: positions, positions: shadow, origin } = shadow;
        model.positions = shadow;
        model.exact = Some(Exact { positions, origin });
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::scenes::icosphere;

    #[cfg(feature = "threads")]
    #[test]
    fn a_fault_in_the_last_part_changes_nothing() {
        use crate::model::passes::THREADS;
        let ball = icosphere(40_000);
        let mut model = Model::new(ball.positions.clone(), ball.triangles).unwrap();
        let certified = |model: &Model| -> Vec<bool> {
            let vertices = 0..model.positions.len() as u32;
            vertices.map(|vertex| model.certificates().is_certified(vertex)).collect()
        };
        let (before, known, last) = (model.stamp(), certified(&model), ball.positions.len() - 1);
        let mut moved: Vec<_> = ball.positions.iter().map(|p| [2.0 * p[0], p[1], p[2]]).collect();
        let end = std::mem::replace(&mut moved[last], [0.0, 0.0, f32::INFINITY]);
        let fault = model.deform(&moved, THREADS).unwrap_err();
        let expected = model.mesh().with_positions(&moved).unwrap_err();
        assert_eq!(fault.to_string(), Error::from(expected).to_string());
        assert_eq!(expected, pfront_core::MeshError::NonFinite { vertex: last });
        assert!(model.stamp() == before && certified(&model) == known);
        assert_eq!(model.positions, ball.positions);

        moved[last] = end;
        // Some triangles turn edgeways.
        moved.iter_mut().step_by(7).for_each(|p| p[1] = -p[1]);
        let mut alone = model.clone();
        alone.set_positions(&moved).unwrap();
        model.deform(&moved, THREADS).unwrap();
        assert_eq!(model.positions, moved);
        assert_eq!(model.bvh().nodes(), alone.bvh().nodes());
        assert_eq!(certified(&model), certified(&alone));
        assert_ne!(certified(&model), known);
    }

    #[test]
    fn with_room_made_for_it_no_refit_grows_a_model() {
        let ball = icosphere(2_000);
        let grown = |reserve: bool| {
            let mut model = Model::new(ball.positions.clone(), ball.triangles.clone()).unwrap();
            if reserve {
                model.reserve();
            }
            let before = model.bytes();
            let mut moved = ball.positions.clone();
            for _ in 0..2 {
                moved[7][0] += 0.01;
                model.set_positions(&moved).unwrap();
            }
            model.bytes() - before
        };
        assert!(grown(false) > 0 && grown(true) == 0);
    }
}
