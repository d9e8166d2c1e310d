//! Moving the vertices of a model, and updating its tree and certificates.

use super::Model;
use super::in_f64::{Exact, Shadow};
use super::moves::same_bits;
#[cfg(feature = "threads")]
use super::passes::THREADS;
use super::passes::{ONE_THREAD, Parallel, both, by_parts, if_four_threads};
use super::tree::Tree;
use crate::Error;
use crate::environment::with_default;
use crate::memory::{copy, filled};
use pfront_core::{Mesh, MeshError};

impl Model {
    /// Moves the vertices of a deforming mesh and refits the BVH. When its quality figure has grown by
    /// [`REBUILD_RATIO`](pfront_core::bvh::REBUILD_RATIO) since the last build, another one is built over the next calls, a
    /// part with each that takes about half as long as the refit; when it has doubled, at once.
    ///
    /// On error nothing has changed, nor if the positions are the present ones to the bit: the
    /// [`Model::stamp`] stays. Where few vertices have moved, only the BVH near these is looked at.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices + triangles); O(vertices) if few have moved that are near one another. A rebuild is
    /// O(n log n) in all and holds up to 100 bytes a triangle while it is under way. A refit allocates nothing, but for the
    /// first of few vertices: see [`Model`].
    ///
    /// # Examples
    /// ```
    /// # let mut model = pfront::Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// assert!(model.set_positions(&[[0.0, f32::INFINITY, 0.0]; 3]).is_err());
    /// model.set_positions(&[[1.0; 3]; 3])?;
    /// assert_eq!(model.mesh().shadow()[2], [1.0; 3]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.deform(positions, ONE_THREAD)
    }

    /// [`Model::set_positions`] in the rayon pool of whoever asks; worth it from some 50,000
    /// triangles on, or 3,000 if threads are awake.
    /// A rebuild may come a frame earlier or later.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    #[cfg(feature = "threads")]
    pub fn set_positions_with_threads(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        self.deform(positions, THREADS)
    }

    /// [`Model::set_positions`] of a model in f64.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite or beyond 2^125, if the number of vertices differs, or if the model is in
    /// f32.
    ///
    /// # Complexity
    /// As [`Model::set_positions`], but that all positions count as moved; allocates 36 bytes a vertex.
    ///
    /// # Examples
    /// ```
    /// # let mut model = pfront::Model::from_f64(vec![[0.1; 3]; 3], vec![[0, 1, 2]])?;
    /// model.set_positions_f64(&[[0.3; 3]; 3])?;
    /// assert_eq!(model.mesh().positions_f64(), Some(&[[0.3; 3]; 3][..]));
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions_f64(&mut self, positions: &[[f64; 3]]) -> Result<(), Error> {
        with_default(|| {
            let shadow = self.shadow_of(positions)?;
            self.set_shadowed(shadow);
            Ok(())
        })
    }

    /// The shadow of other positions.
    pub(crate) fn shadow_of(&self, positions: &[[f64; 3]]) -> Result<Shadow, Error> {
        let mut shadow = filled([0.0; 3], positions.len())?;
        let origin = self.mesh().with_positions_f64(positions, &mut shadow)?.origin();
        Ok(Shadow { exact: copy(positions)?, positions: shadow, origin })
    }

    /// Moves the vertices of a model in f64 to the positions that have this shadow.
    pub(crate) fn set_shadowed(&mut self, shadow: Shadow) {
        let Shadow { exact: positions, positions: shadow, origin } = shadow;
        let is_same = |(p, q): (&[f64; 3], &[f64; 3])| p.map(f64::to_bits) == q.map(f64::to_bits);
        if let Some(exact) = &self.exact
            && exact.positions.len() == positions.len()
            && exact.positions.iter().zip(&positions).all(is_same)
        {
            return;
        }
        self.outdate();
        self.moves.add_all();
        self.positions = shadow;
        self.exact = Some(Exact { positions, origin });
        self.fit_by(ONE_THREAD);
    }

    /// [`Model::set_positions`] that leaves the BVH alone until it is asked for, as a query on a GPU never
    /// does.
    ///
    /// The first query refits it then on its own thread; [`Model::fit`] and `Model::fit_with_threads` do
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
    /// model.set_positions_unfitted(&[[1.0; 3]; 3])?;
    /// model.set_positions_unfitted(&[[2.0; 3]; 3])?;
    /// assert_eq!(model.bvh().nodes()[0].min, [2.0; 3]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn set_positions_unfitted(&mut self, positions: &[[f32; 3]]) -> Result<(), Error> {
        with_default(|| self.store(positions, ONE_THREAD).map(drop))
    }

    /// Fits the BVH, and rebuilds it if that is due, after [`Model::set_positions_unfitted`].
    ///
    /// # Complexity
    /// As [`Model::set_positions`]; O(1) if the BVH fits.
    pub fn fit(&mut self) {
        with_default(|| self.fit_by(ONE_THREAD));
    }

    /// [`Model::fit`] in the rayon pool of whoever asks.
    #[cfg(feature = "threads")]
    pub fn fit_with_threads(&mut self) {
        with_default(|| self.fit_by(THREADS));
    }

    fn deform(&mut self, positions: &[[f32; 3]], parallel: Parallel) -> Result<(), Error> {
        with_default(|| {
            if self.store(positions, parallel)? {
                self.fit_by(parallel);
            }
            Ok(())
        })
    }

    /// Takes other positions, after which nothing fits any more; returns whether they are others.
    fn store(&mut self, positions: &[[f32; 3]], parallel: Parallel) -> Result<bool, Error> {
        // The floating-point environment of this thread, which may do no part.
        Mesh::new(&[], &[])?;
        if self.exact.is_some() {
            return Err(MeshError::OtherPrecision.into());
        }
        let own = &mut self.positions;
        let checked = own.len() == positions.len()
            && by_parts(parallel, positions, own, &|new, _| Mesh::new(new, &[]).is_ok());
        if !checked {
            self.mesh().with_positions(positions)?;
        }
        if same_bits(positions, &self.positions) {
            return Ok(false);
        }
        self.outdate();
        self.moves.add(&self.positions, positions);
        by_parts(parallel, positions, &mut self.positions, &|new, own| {
            own.copy_from_slice(new);
            true
        });
        Ok(true)
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

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::scenes::icosphere;

    #[cfg(feature = "threads")]
    #[test]
    fn a_fault_in_the_last_part_changes_nothing() {
        let ball = icosphere(40_000);
        let mut model = Model::new(ball.positions.clone(), ball.triangles).unwrap();
        let certified = |model: &Model| -> Vec<bool> {
            let vertices = 0..model.positions.len() as u32;
            vertices.map(|vertex| model.certificates().is_certified(vertex)).collect()
        };
        let (before, known, last) = (model.stamp(), certified(&model), ball.positions.len() - 1);
        let mut moved: Vec<_> = ball.positions.iter().map(|p| [2.0 * p[0], p[1], p[2]]).collect();
        let end = std::mem::replace(&mut moved[last], [0.0, 0.0, f32::INFINITY]);
        let fault = model.set_positions_with_threads(&moved).unwrap_err();
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
        model.set_positions_with_threads(&moved).unwrap();
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
