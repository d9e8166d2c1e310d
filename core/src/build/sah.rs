//! The top-down build by the surface area heuristic.
//!
//! Binned SAH after Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007),
//! on items that carry their box, so that every pass runs over memory in sequence. What differs:
//! depth is bounded, and no finite input can mislead it. A split that could exceed [`MAX_DEPTH`], or
//! that the heuristic cannot find (equal centres, areas that are 0), becomes a median split, which
//! always halves.

use super::bins::{AreaScale, Bins, Bounds, Split};
use super::{BuildOptions, BvhStorage, Slots};
use crate::bvh::{MAX_DEPTH, Node};
use crate::{Aabb, Bvh, CapacityError, Mesh};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3A, Vec4, Vec4Swizzles};

/// How many items of scratch [`sah()`] needs for so many triangles.
#[must_use]
pub const fn sah_scratch_bound(triangles: usize) -> usize {
    triangles
}

/// Scratch of [`sah()`]: a triangle and its box.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SahItem {
    min: [f32; 3],
    triangle: u32,
    max: [f32; 3],
    unused: u32,
}

impl SahItem {
    pub(super) fn bounds(&self) -> Bounds {
        let [min, max]: [Vec4; 2] = bytemuck::cast(*self);
        // The fourth lane takes part in all arithmetic, where an index would be a subnormal number
        // and slow everything down tenfold.
        Bounds { min: Vec3A::from_vec4(min.xyzz()), max: Vec3A::from_vec4(max.xyzz()) }
    }
}

/// Builds a BVH by binned SAH.
///
/// # Errors
/// [`CapacityError`] if `storage` is below [`node_bound`](crate::bvh::node_bound) nodes and one
/// order entry per triangle, or `scratch` below [`sah_scratch_bound`].
///
/// # Complexity
/// O(n log n) for usual meshes, O(n · [`MAX_DEPTH`]) for any.
///
/// # Examples
/// ```
/// use pfront_core::build::{BuildOptions, BvhStorage, SahItem, sah};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = sah(mesh, &BuildOptions::default(), storage, &mut [SahItem::default()])?;
/// assert_eq!(bvh.root().map(|root| root.max), Some([1.0, 1.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sah<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [SahItem],
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    storage.check(count)?;
    CapacityError::check("scratch", sah_scratch_bound(count), scratch.len())?;
    let items = &mut scratch[..count];
    if items.is_empty() {
        return Ok(storage.into_bvh(mesh, 0));
    }
    let bounds = load(mesh, items);
    let mut builder = Builder {
        max_leaf: options.max_leaf(),
        scale: AreaScale::new(&bounds),
        nodes: &mut *storage.nodes,
        order: &mut *storage.order,
        bins: Bins::new(),
        slots: Slots::new(),
    };
    builder.build(items, bounds);
    let nodes = builder.slots.nodes();
    Ok(storage.into_bvh(mesh, nodes))
}

fn load(mesh: Mesh<'_>, items: &mut [SahItem]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for (triangle, item) in (0..).zip(items) {
        let Aabb { min, max } = Aabb::of(&mesh.triangle(triangle));
        *item = SahItem { min, triangle, max, unused: 0 };
        bounds = bounds.union(&item.bounds());
    }
    bounds
}

/// A node to be built from a run of the items.
#[derive(Clone, Copy)]
struct Task {
    node: usize,
    depth: usize,
    first: usize,
    count: usize,
    bounds: Bounds,
}

struct Builder<'a> {
    max_leaf: usize,
    scale: AreaScale,
    nodes: &'a mut [Node],
    order: &'a mut [u32],
    bins: Bins,
    slots: Slots,
}

impl Builder<'_> {
    fn build(&mut self, items: &mut [SahItem], bounds: Bounds) {
        let mut task = Task { node: 0, depth: 0, first: 0, count: items.len(), bounds };
        // One right sibling waits for each level above the current node, and `split` lets no node
        // get deeper than MAX_DEPTH.
        let mut waiting = [task; MAX_DEPTH];
        let mut len = 0;
        self.nodes[1] = Node::EMPTY;
        loop {
            let run = &mut items[task.first..task.first + task.count];
            if let Some((middle, left_bounds, right_bounds)) = self.split(&task, run) {
                let node = self.slots.pair();
                self.write(&task, node, 0);
                let depth = task.depth + 1;
                waiting[len] = Task {
                    node: node + 1,
                    depth,
                    first: task.first + middle,
                    count: task.count - middle,
                    bounds: right_bounds,
                };
                len += 1;
                task = Task { node, depth, count: middle, bounds: left_bounds, ..task };
            } else {
                self.write(&task, task.first, task.count);
                for (entry, item) in self.order[task.first..].iter_mut().zip(run) {
                    *entry = item.triangle;
                }
                if len == 0 {
                    return;
                }
                len -= 1;
                task = waiting[len];
            }
        }
    }

    fn write(&mut self, task: &Task, first: usize, count: usize) {
        let Bounds { min, max } = task.bounds;
        self.nodes[task.node] = Node {
            min: min.to_array(),
            first: first as u32,
            max: max.to_array(),
            count: count as u32,
        };
    }

    /// Parts the run in two, or returns `None` to make it a leaf.
    fn split(&mut self, task: &Task, run: &mut [SahItem]) -> Option<(usize, Bounds, Bounds)> {
        if run.len() == 1 {
            return None;
        }
        let fits_leaf = run.len() <= self.max_leaf;
        // Halving the run down to single triangles takes `levels` more levels. SAH may not use a
        // level up unless they still fit below it; a median split needs them to fit below this
        // node, which holds at the root (31 ≤ MAX_DEPTH) and is handed down by either split.
        let levels = usize::BITS - (run.len() - 1).leading_zeros();
        let centres = Bounds::of_centres(run);
        if (levels as usize) < MAX_DEPTH - task.depth
            && let Some(split) = self.bins.best_split(run, &centres, self.scale)
        {
            if fits_leaf && !split.beats_leaf(&task.bounds, run.len(), self.scale) {
                return None;
            }
            let middle = partition(run, &split);
            return Some((middle, split.left, split.right));
        }
        if fits_leaf { None } else { Some(median_split(run, &centres)) }
    }
}

/// Moves the items left of the split plane to the front, and returns how many there are.
///
/// Every step swaps, whichever side the item is on: which one is a coin toss to a branch predictor.
fn partition(run: &mut [SahItem], split: &Split) -> usize {
    let mut middle = 0;
    for i in 0..run.len() {
        let item = run[i];
        run[i] = run[middle];
        run[middle] = item;
        middle += usize::from(split.is_left(&item));
    }
    middle
}

/// Halves the run by centre along the longest axis, or as it stands if the centres coincide.
fn median_split(run: &mut [SahItem], centres: &Bounds) -> (usize, Bounds, Bounds) {
    let middle = run.len() / 2;
    let extent = (centres.max - centres.min).to_array();
    let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
    if extent[axis] > 0.0 {
        let centre = |item: &SahItem| item.bounds().centre().to_array()[axis];
        run.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
    }
    let (left, right) = run.split_at(middle);
    (middle, Bounds::of(left), Bounds::of(right))
}
