//! The top-down build by the surface area heuristic.
//!
//! Binned SAH after Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007), on items that carry
//! their box, so that every pass runs over memory in sequence.
//!
//! Where we depart: depth is bounded, and no finite input can mislead the build. A split that could exceed
//! [`MAX_DEPTH`](crate::bvh::MAX_DEPTH), or that the heuristic cannot find (equal centres, areas that are 0), becomes a
//! median split.

use super::bins::best_split;
use super::divide::{centres, halve};
use super::item::{bounds, item, triangle};
use super::tree::{Divide, build};
use super::{BuildOptions, BvhStorage};
use crate::aabb::Bounds;
use crate::parallel::{Join, halves};
use crate::{Aabb, Bvh, CapacityError, Mesh, Node};

/// Builds a BVH by binned SAH.
///
/// `scratch` has one node a triangle.
///
/// # Errors
/// [`CapacityError`] if `storage` has fewer order entries than there are triangles or fewer nodes than the tree,
/// or `scratch` is too short.
///
/// # Complexity
/// O(n log n) for usual meshes, O(n · [`MAX_DEPTH`](crate::bvh::MAX_DEPTH)) for any.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, sah};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = sah(mesh, &BuildOptions::default(), storage, &mut [Node::EMPTY])?;
/// assert_eq!(bvh.aabb().map(|root| root.max), Some([1.0, 1.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sah<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions<'_>,
    storage: BvhStorage<'a>,
    scratch: &mut [Node],
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    CapacityError::check("order", count, storage.order.len())?;
    CapacityError::check("scratch", count, scratch.len())?;
    let (items, order) = (&mut scratch[..count], &mut storage.order[..count]);
    for (entry, triangle) in order.iter_mut().zip(0..) {
        *entry = triangle;
    }
    let load = |items: &mut [Node], order: &mut [u32]| {
        for (slot, &mut triangle) in items.iter_mut().zip(order) {
            *slot = item(triangle, &mesh.bounds(triangle));
        }
        centres(items)
    };
    let centres = halves(options.join, items, order, &load, &|a, b| Bounds::union(&a, &b));
    build(mesh, options, storage, &Sah { join: options.join }, SahRun { items, centres })
}

struct SahRun<'r> {
    items: &'r mut [Node],
    /// The box of the items' centres.
    centres: Bounds,
}

struct Sah<'s> {
    join: Option<&'s Join<'s>>,
}

impl Divide for Sah<'_> {
    type Run<'r> = SahRun<'r>;

    fn leaf(&self, run: &SahRun<'_>, order: &mut [u32]) -> Aabb {
        let mut all = Bounds::EMPTY;
        for (entry, item) in order.iter_mut().zip(&*run.items) {
            *entry = triangle(item);
            all = all.union(&bounds(item));
        }
        all.into()
    }

    // Apart, so that the bins are not on the stack of every level below.
    #[inline(never)]
    fn divide<'r>(
        &self,
        run: &'r mut SahRun<'_>,
        _: usize,
        free: bool,
    ) -> (usize, [SahRun<'r>; 2]) {
        let centres = run.centres;
        let split = if free { best_split(run.items, &centres, self.join) } else { None };
        let divided = match split {
            Some(split) => split.divide(run.items, self.join),
            None => halve(run.items, &centres),
        };
        let (left, right) = run.items.split_at_mut(divided.left);
        let [left_centres, right_centres] = divided.centres;
        let left = SahRun { items: left, centres: left_centres };
        (divided.left, [left, SahRun { items: right, centres: right_centres }])
    }
}
