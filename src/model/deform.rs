//! What moves the vertices of a model, and brings along what depends on them.

use super::Model;
use super::moves::same_bits;
#[cfg(feature = "threads")]
use super::passes::THREADS;
use super::passes::{ONE_THREAD, Passes};
use crate::Error;
use pfront_core::Mesh;

impl Model {
    /// Moves the vertices of a deforming mesh and refits the BVH; rebuilds it when its quality
    /// figure has grown by [`REBUILD_RATIO`](crate::core::build::REBUILD_RATIO) since the last build.
    ///
    /// On error nothing has changed, nor if the positions are the present ones to the bit: the
    /// [`Model::stamp`] stays. Where few vertices have moved, only the BVH near these is looked at.
    ///
    /// # Errors
    /// [`Error::Mesh`] if a coordinate is not finite or the number of vertices differs.
    ///
    /// # Complexity
    /// O(vertices + triangles); O(vertices) if few have moved that are near one another. A rebuild is
    /// O(n log n) and allocates 32 bytes a triangle while it runs. A refit allocates nothing, but for the
    /// first ones of which few vertices have moved, after a build: see [`Model`].
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

    /// [`Model::set_positions`] that leaves the BVH alone until it is asked for, as a query on a GPU never
    /// does.
    ///
    /// Whoever asks first then refits it on his own thread; [`Model::fit`] and `Model::fit_with_threads` do
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
        self.store(positions).map(drop)
    }

    /// Fits the BVH, and rebuilds it if that is due, after [`Model::set_positions_unfitted`].
    ///
    /// # Complexity
    /// As [`Model::set_positions`]; O(1) if the BVH fits.
    pub fn fit(&mut self) {
        self.fit_by(&ONE_THREAD);
    }

    /// [`Model::fit`] in the rayon pool of whoever asks.
    #[cfg(feature = "threads")]
    pub fn fit_with_threads(&mut self) {
        self.fit_by(&THREADS);
    }

    fn deform(&mut self, positions: &[[f32; 3]], passes: &Passes) -> Result<(), Error> {
        if self.store(positions)? {
            self.fit_by(passes);
        }
        Ok(())
    }

    /// Takes other positions, after which nothing fits any more; returns whether they are others.
    fn store(&mut self, positions: &[[f32; 3]]) -> Result<bool, Error> {
        self.mesh().with_positions(positions)?;
        if same_bits(positions, &self.positions) {
            return Ok(false);
        }
        if let Some(tree) = self.tree.fresh() {
            if tree.is_worn() {
                self.stamp.rebuilt();
            }
            self.moves.clear();
            if self.fans.fresh().is_none()
                && let Some(fans) = self.fans.outdate()
            {
                fans.fall_behind();
            }
        }
        self.moves.add(&self.positions, positions);
        self.positions.copy_from_slice(positions);
        self.stamp.moved();
        self.tree.outdate();
        self.fans.outdate();
        self.sphere.take();
        Ok(true)
    }

    fn fit_by(&mut self, passes: &Passes) {
        let mesh = Mesh::trusted(&self.positions, &self.triangles);
        let (moves, options) = (&self.moves, &self.options);
        let due = (self.tree.fresh().is_none(), self.fans.fresh().is_none());
        let (Some(tree), fans) = (self.tree.outdate(), self.fans.outdate()) else { return };
        let fans = fans.filter(|_| due.1);
        let mut fit = || {
            if due.0 {
                tree.fit(mesh, options, moves, passes);
            }
        };
        match fans {
            Some(fans) if moves.few().is_none() => {
                (passes.both)(&mut fit, &mut || fans.certify(mesh));
            }
            Some(fans) => {
                fit();
                fans.certify_moved(mesh, tree, moves);
            }
            None => fit(),
        }
        if tree.is_worn() {
            tree.rebuild(mesh, options, passes);
            self.stamp.rebuilt();
        }
        self.tree.renewed();
        self.fans.renewed();
    }
}
