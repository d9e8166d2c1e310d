//! A BVH that moves: one side of a query about motions.

use crate::bvtt::PosedBvh;

/// A BVH at the start of a motion and at its end. Copying is free.
///
/// Both have the same triangles and nodes: a rigid body is one BVH in two poses, and a body that deforms one whose nodes were refitted to
/// the positions at the end, in an array of their own.
///
/// # Examples
/// ```
/// use pfront_core::{bvtt::*, motion::*, *};
/// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
/// # let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.0], count: 1 }];
/// # let bvh = Bvh::new_unchecked(mesh, &root, &[0]);
/// let at = |z| PosedBvh::new(bvh, &Pose::from_translation([0.0, 0.0, z]));
/// let (rest, falling) = (MovingBvh::new(at(0.0)?, at(0.0)?)?, MovingBvh::new(at(1.0)?, at(-3.0)?)?);
/// let query = PairBvtt::moving(rest, falling);
/// let (pair, impact) = query.first_impact().expect("it falls through");
/// assert_eq!(pair, TrianglePair { a: 0, b: 0 });
/// assert!(impact.from <= 0.25 && 0.25 <= impact.to);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct MovingBvh<'a> {
    pub(super) start: PosedBvh<'a>,
    pub(super) end: PosedBvh<'a>,
}

/// Two BVHs that are not the start and the end of one motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// The triangles differ, or how many there are.
    #[error("triangle {triangle} at the start of the motion is not the same at the end")]
    Triangle {
        /// The first triangle that differs.
        triangle: usize,
    },
    /// The nodes are not the same but for their boxes, or how many there are, or the order of triangles in their leaves.
    #[error(
        "node or order entry {entry} at the start of the motion differs at the end: refit, do not build"
    )]
    Tree {
        /// The first node, or entry of the order, that differs.
        entry: usize,
    },
}

impl<'a> MovingBvh<'a> {
    /// A motion from one pose of a BVH, or from one set of positions, to another.
    ///
    /// # Errors
    /// [`MotionError`] names the first triangle, node or entry of the order that differs.
    ///
    /// # Complexity
    /// O(1) if both share their arrays, else O(triangles).
    pub fn new(start: PosedBvh<'a>, end: PosedBvh<'a>) -> Result<Self, MotionError> {
        let (from, to) = (start.bvh, end.bvh);
        let triangles = [from, to].map(|bvh| bvh.mesh().triangles());
        let order = [from.order(), to.order()];
        let nodes = [from.nodes(), to.nodes()];
        if let Some(triangle) = first_difference(triangles, |p, q| p == q) {
            return Err(MotionError::Triangle { triangle });
        }
        let is_same = |p: &crate::Node, q: &crate::Node| (p.first, p.count) == (q.first, q.count);
        let differs = first_difference(order, |p, q| p == q).or(first_difference(nodes, is_same));
        differs.map_or(Ok(Self { start, end }), |entry| Err(MotionError::Tree { entry }))
    }

    /// The same without comparing anything.
    ///
    /// # Panics and wrong answers
    /// With trees that differ, queries may answer wrongly or panic.
    #[must_use]
    pub fn new_unchecked(start: PosedBvh<'a>, end: PosedBvh<'a>) -> Self {
        Self { start, end }
    }
}

/// Where two slices differ first, if they are not the same.
fn first_difference<T>([p, q]: [&[T]; 2], is_same: impl Fn(&T, &T) -> bool) -> Option<usize> {
    if core::ptr::eq(p, q) {
        return None;
    }
    let difference = p.iter().zip(q).position(|(p, q)| !is_same(p, q));
    difference.or((p.len() != q.len()).then_some(p.len().min(q.len())))
}
