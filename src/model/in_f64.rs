//! Models with positions in f64.

use super::Model;
use super::passes::ONE_THREAD;
use super::tree::Tree;
use crate::Error;
use crate::environment::with_default;
use crate::memory::{copy, filled};
use pfront_core::bvh::BuildOptions;
use pfront_core::{Aabb, Mesh};

/// The positions that decide, where f32 does not hold them all.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    /// Empty if those of the shadow are the same.
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) origin: [f64; 3],
}

/// Positions in f64, their shadow, see [`Mesh::from_f64`], and where its origin is.
pub(crate) struct Shadow {
    exact: Vec<[f64; 3]>,
    positions: Vec<[f32; 3]>,
    origin: [f64; 3],
}

impl Shadow {
    /// The box of the positions that it is of, each coordinate rounded to f32 twice.
    pub(crate) fn bounds(&self) -> Aabb {
        let Aabb { min, max } = Aabb::of(&self.positions);
        let place = |p: [f32; 3]| [0, 1, 2].map(|k| (f64::from(p[k]) + self.origin[k]) as f32);
        Aabb { min: place(min), max: place(max) }
    }
}

impl Exact {
    /// The mesh with these positions in f32, or of which they are the shadow.
    pub(super) fn mesh<'m>(
        exact: Option<&'m Self>,
        positions: &'m [[f32; 3]],
        triangles: &'m [[u32; 3]],
    ) -> Mesh<'m> {
        match exact {
            None => Mesh::new_unchecked(positions, triangles),
            Some(Self { positions: exact, .. }) if exact.is_empty() => {
                Mesh::new_unchecked(positions, triangles).widened()
            }
            Some(Self { positions: exact, origin }) => {
                Mesh::from_f64_unchecked(exact, positions, *origin, triangles)
            }
        }
    }

    pub(super) fn try_clone(&self) -> Result<Self, Error> {
        Ok(Self { positions: copy(&self.positions)?, origin: self.origin })
    }

    pub(super) fn bytes(&self) -> usize {
        self.positions.capacity() * size_of::<[f64; 3]>()
    }
}

impl Model {
    /// [`Model::new`] with positions in f64: queries pose and decide them there, exactly, whatever the other model and the
    /// pose.
    ///
    /// Takes 24 bytes a vertex more, unless f32 holds every coordinate. A GPU answers about two such models by their shadows,
    /// and leaves to the CPU what these do not tell; everything else about them only a CPU answers.
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first vertex or triangle at fault; coordinates are at most 2^125.
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
        Self::from_f64_with_options(positions, triangles, BuildOptions::default())
    }

    /// [`Model::from_f64`] with other build options.
    pub(crate) fn from_f64_with_options(
        positions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
    ) -> Result<Self, Error> {
        with_default(|| Self::built_from_f64(positions, triangles, options))
    }

    fn built_from_f64(
        positions: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
        options: BuildOptions<'static>,
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
        let tree = Tree::build(mesh, options, ONE_THREAD)?;
        Ok(Self { exact: Some(exact), ..Self::of(shadow, triangles, options, tree) })
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

    /// Whether positions are in f64: the model is one of [`Model::from_f64`].
    #[must_use]
    pub fn is_f64(&self) -> bool {
        self.exact.is_some()
    }
}
