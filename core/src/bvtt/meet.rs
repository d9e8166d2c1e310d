//! How two triangles of a query meet.

use super::{PairBvtt, TrianglePair};
use crate::triangle::{Meet, meet_of};

impl PairBvtt<'_> {
    /// The corners of two triangles as the query poses them. Corners in f32 are the same in f64.
    ///
    /// # Panics
    /// If an index is out of range.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let [_, b] = query.corners(TrianglePair { a: 0, b: 0 });
    /// assert_eq!(b[1], [1.5, 0.0, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn corners(&self, pair: TrianglePair) -> [[[f64; 3]; 3]; 2] {
        match self.error() {
            None => [self.a.triangle(pair.a), self.b.triangle(pair.b)]
                .map(|t| t.map(|p| p.map(f64::from))),
            Some(_) => [self.a.triangle_f64(pair.a), self.b.triangle_f64(pair.b)],
        }
    }

    /// How two triangles meet, exactly, or `None` if they do not: [`meet`](crate::triangle::meet) as the query poses them.
    ///
    /// # Panics
    /// If an index is out of range.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{bvtt::*, *};
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
    /// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
    /// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
    /// let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.5, 0.0, 0.0]))?;
    /// let found = query.meet(TrianglePair { a: 0, b: 0 }).expect("they meet");
    /// assert_eq!(found.dimension(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn meet(&self, pair: TrianglePair) -> Option<Meet> {
        let [a, b] = self.corners(pair);
        meet_of(&a, &b)
    }
}
