//! Models on the threads of an executor.

use super::Executor;
use crate::environment::with_default;
use crate::model::{ONE_THREAD, Parallel, THREADS};
use crate::{BuildOptions, Error, Model, Scalar};

/// A refit of fewer triangles takes less, at some 10 ns each, than to call another thread or a GPU.
pub(super) const SMALL: usize = 1 << 11;

impl Executor {
    /// [`Model::new`] with options, in f32 or f64, on the threads of the executor. Options change speed and memory, never an
    /// answer, and threads not even the BVH.
    ///
    /// # Errors
    /// As [`Model::new`], or [`Model::from_f64`].
    ///
    /// # Examples
    /// ```
    /// use pfront::{BuildOptions, Executor};
    /// let options = BuildOptions { leaf_size: 4, ..BuildOptions::default() };
    /// let model = Executor::threads(8).build(vec![[0.0_f32; 3]; 3], vec![[0, 1, 2]], options)?;
    /// assert!(!model.is_f64());
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn build<S: Scalar>(
        &self,
        positions: Vec<[S; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
    ) -> Result<Model, Error> {
        let count = triangles.len();
        self.passes(count, |parallel| Model::build(positions, triangles, options, parallel))
    }

    /// [`Model::set_positions`] on the threads of the executor. If a GPU answers everything, which refits by itself, the BVH
    /// is left alone, as by [`Model::set_positions_unfitted`]. A rebuild may come a frame earlier or later than on one thread.
    ///
    /// # Errors
    /// As [`Model::set_positions`].
    ///
    /// # Examples
    /// ```
    /// # use pfront::{Executor, Model};
    /// let executor = Executor::threads(8);
    /// let mut cloth = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]])?;
    /// executor.refit(&mut cloth, &[[0.1_f32; 3]; 3])?;
    /// assert_eq!(cloth.bvh().nodes()[0].min, [0.1; 3]);
    /// # Ok::<(), pfront::Error>(())
    /// ```
    pub fn refit<S: Scalar>(&self, model: &mut Model, positions: &[[S; 3]]) -> Result<(), Error> {
        if self.only_device().is_some() {
            return model.set_positions_unfitted(positions);
        }
        let count = model.mesh().triangles().len();
        self.passes(count, |parallel| model.deform(positions, parallel))
    }

    /// [`Executor::refit`] where the box is needed at once, to positions that are checked.
    pub(crate) fn refit_checked<S: Scalar>(
        &self,
        model: &mut Model,
        positions: &[[S; 3]],
        checked: S::Checked,
    ) {
        let count = model.mesh().triangles().len();
        self.passes(count, |parallel| {
            with_default(|| model.deform_checked(positions, checked, parallel));
        });
    }

    /// Runs passes over a model of so many triangles, on threads if that pays.
    fn passes<R: Send>(&self, triangles: usize, run: impl FnOnce(Parallel) -> R + Send) -> R {
        match self.pool.as_ref().filter(|_| triangles >= SMALL) {
            Some(pool) => pool.install(|| run(THREADS)),
            None => run(ONE_THREAD),
        }
    }
}
