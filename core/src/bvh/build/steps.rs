//! The build by the surface area heuristic in steps: for a mesh that deforms, so that no frame waits for all of it.

use super::bins::{Split, best_split};
use super::divide::halve;
use super::item::{bounds, item, triangle};
use super::{BuildOptions, BvhStorage};
use crate::Node;
use crate::aabb::Bounds;
use crate::bvh::{MAX_DEPTH, MAX_LEAF_SIZE};
use crate::{Aabb, CapacityError, Mesh};

/// A build by the surface area heuristic under way. It makes the tree that [`sah`](super::sah()) makes, but for the boxes,
/// which a [`refit`](crate::bvh::refit) has to fit.
///
/// Positions may change between steps. The tree then is one for the positions from which triangles were loaded.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, Refit, SahSteps, refit};
/// use pfront_core::{Bvh, Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]; 9])?;
/// let (mut nodes, mut order, mut items) = ([Node::EMPTY; 18], [0; 9], [Node::EMPTY; 9]);
/// let (mut steps, options) = (SahSteps::new(), BuildOptions::default());
/// while !steps.is_done(mesh) {
///     let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
///     steps.step(mesh, &options, storage, &mut items)?;
/// }
/// let nodes = &mut nodes[..steps.nodes()];
/// refit(mesh, nodes, &order, Refit::default())?;
/// Bvh::new_unchecked(mesh, nodes, &order).assert_well_formed();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SahSteps {
    /// Runs of items that are to become nodes, the next one last. Each level leaves at most one right sibling waiting.
    pending: [Pending; MAX_DEPTH + 1],
    len: usize,
    next: Next,
    /// How many triangles have been loaded, and the box of their centres.
    loaded: usize,
    centres: Bounds,
    /// The number of nodes in use.
    used: usize,
}

/// A run of items that is to become a node.
#[derive(Clone, Copy, Debug)]
struct Pending {
    node: usize,
    first: usize,
    count: usize,
    depth: usize,
    centres: Bounds,
}

/// The next step for the last pending run.
#[derive(Clone, Copy, Debug)]
enum Next {
    Find,
    /// At a plane, or in the middle.
    Divide(Option<Split>),
}

impl SahSteps {
    /// A build of which nothing is done.
    #[must_use]
    pub fn new() -> Self {
        let none = Pending { node: 0, first: 0, count: 0, depth: 0, centres: Bounds::EMPTY };
        Self {
            pending: [none; MAX_DEPTH + 1],
            len: 0,
            next: Next::Find,
            loaded: 0,
            centres: Bounds::EMPTY,
            used: 0,
        }
    }

    /// Whether the nodes and the order are complete.
    #[must_use]
    pub fn is_done(&self, mesh: Mesh<'_>) -> bool {
        self.loaded == mesh.triangles().len() && self.len == 0
    }

    /// The number of nodes that are in use so far.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.used
    }

    /// Does the next step: loads triangles into `items`, as many as there is room for, or finds where to divide a run of
    /// them, or divides it, or makes a leaf. Returns the number of triangles that it went through.
    ///
    /// `mesh`, `options`, `storage` and `items` are those of the last step, but for positions and for more room: each step
    /// takes two more nodes at most, and `items` must hold one more than are loaded until they hold all.
    ///
    /// # Errors
    /// [`CapacityError`] if `storage` or `items` have no room for the step, which then is not done.
    ///
    /// # Complexity
    /// O(triangles) at most; all steps together as [`sah`](super::sah()).
    pub fn step(
        &mut self,
        mesh: Mesh<'_>,
        options: &BuildOptions<'_>,
        storage: BvhStorage<'_>,
        items: &mut [Node],
    ) -> Result<usize, CapacityError> {
        let BvhStorage { nodes, order } = storage;
        let all = mesh.triangles().len();
        if self.is_done(mesh) {
            return Ok(0);
        }
        CapacityError::check("order", all, order.len())?;
        CapacityError::check("nodes", self.used + 2, nodes.len())?;
        CapacityError::check("items", (self.loaded + 1).min(all), items.len())?;
        if self.loaded < all {
            return Ok(self.load(mesh, all, items));
        }
        let run = self.pending[self.len - 1];
        let own = &mut items[run.first..run.first + run.count];
        if run.count <= options.leaf_size.clamp(1, MAX_LEAF_SIZE) as usize {
            let mut aabb = Bounds::EMPTY;
            for (entry, item) in order[run.first..].iter_mut().zip(&*own) {
                *entry = triangle(item);
                aabb = aabb.union(&bounds(item));
            }
            let Aabb { min, max } = aabb.into();
            let (first, count) = (run.first as u32, run.count as u32);
            nodes[run.node] = Node { min, first, max, count };
            if run.node == 0 {
                self.used = 1;
            }
            self.len -= 1;
            return Ok(run.count);
        }
        match self.next {
            Next::Find => {
                // As in the build at once: halving down to single triangles takes so many more levels.
                let levels = (usize::BITS - (run.count - 1).leading_zeros()) as usize;
                let free = levels < MAX_DEPTH - run.depth;
                let split = if free { best_split(own, &run.centres, options.join) } else { None };
                self.next = Next::Divide(split);
            }
            Next::Divide(split) => {
                let divided = match split {
                    Some(split) => split.divide(own, options.join),
                    None => halve(own, &run.centres),
                };
                let children = self.used;
                nodes[run.node] = Node { first: children as u32, ..Node::EMPTY };
                self.used += 2;
                self.len -= 1;
                let ([left, right], middle) = (divided.centres, divided.left);
                let depth = run.depth + 1;
                let first = run.first + middle;
                let count = run.count - middle;
                self.push(Pending { node: children + 1, first, count, depth, centres: right });
                let first = run.first;
                self.push(Pending { node: children, first, count: middle, depth, centres: left });
                self.next = Next::Find;
            }
        }
        Ok(run.count)
    }

    /// Loads triangles; the root is pending when all are there.
    fn load(&mut self, mesh: Mesh<'_>, all: usize, items: &mut [Node]) -> usize {
        let before = self.loaded;
        for slot in items[before..].iter_mut().take(all - before) {
            let index = self.loaded as u32;
            *slot = item(index, &mesh.bounds(index));
            self.centres = self.centres.union(&Bounds::of(bounds(slot).half_centre()));
            self.loaded += 1;
        }
        if self.loaded == all {
            // Slot 1 stays empty so that siblings start at even indices.
            self.used = 2;
            let centres = self.centres;
            self.push(Pending { node: 0, first: 0, count: all, depth: 0, centres });
        }
        self.loaded - before
    }

    fn push(&mut self, run: Pending) {
        self.pending[self.len] = run;
        self.len += 1;
    }
}

impl Default for SahSteps {
    fn default() -> Self {
        Self::new()
    }
}
