//! Positions in f64 and their shadow.

use crate::Error;
use crate::memory::copy;
use pfront_core::{Aabb, Mesh};

/// The positions that decide, where f32 does not hold them all.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    /// Empty if those of the shadow are the same.
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) origin: [f64; 3],
}

/// Positions in f64, their shadow, see [`Mesh::from_f64`], and where its origin is.
pub struct Shadow {
    pub(super) exact: Vec<[f64; 3]>,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) origin: [f64; 3],
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
