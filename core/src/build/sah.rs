//! The top-down build by the surface area heuristic.
//!
//! Binned SAH after Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007),
//! on items that carry their box, so that every pass runs over memory in sequence. What differs:
//! depth is bounded, and no finite input can mislead it. A split that could exceed [`MAX_DEPTH`], or
//! that the heuristic cannot find (equal centres, areas that are 0), becomes a median split, which
//! always halves.

use super::bins::{AreaScale, Bins, Split};
use super::{BuildOptions, BvhStorage, Slots};
use crate::aabb::Bounds;
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

    /// Half the centre of the box, so that neither it nor the difference of two can overflow.
    pub(super) fn centre(&self) -> Vec3A {
        let Bounds { min, max } = self.bounds();
        min * 0.25 + max * 0.25
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
    let whole = load(mesh, items);
    let mut builder = Builder {
        max_leaf: options.max_leaf(),
        scale: AreaScale::new(&whole.bounds),
        nodes: &mut *storage.nodes,
        order: &mut *storage.order,
        bins: Bins::new(),
        slots: Slots::new(),
    };
    builder.build(items, whole);
    let nodes = builder.slots.nodes();
    Ok(storage.into_bvh(mesh, nodes))
}

fn load(mesh: Mesh<'_>, items: &mut [SahItem]) -> Part {
    for (triangle, item) in (0..).zip(items.iter_mut()) {
        let Aabb { min, max } = Aabb::of(&mesh.triangle(triangle));
        *item = SahItem { min, triangle, max, unused: 0 };
    }
    Part::of(items)
}

/// A run of the items.
#[derive(Clone, Copy)]
struct Part {
    count: usize,
    bounds: Bounds,
    /// The box of the items' centres.
    centres: Bounds,
}

impl Part {
    fn of(items: &[SahItem]) -> Self {
        let (mut bounds, mut centres) = (Bounds::EMPTY, Bounds::EMPTY);
        for item in items {
            bounds = bounds.union(&item.bounds());
            centres = centres.with(item.centre());
        }
        Self { count: items.len(), bounds, centres }
    }
}

/// A node to be built.
#[derive(Clone, Copy)]
struct Task {
    node: usize,
    depth: usize,
    first: usize,
    part: Part,
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
    fn build(&mut self, items: &mut [SahItem], whole: Part) {
        let mut task = Task { node: 0, depth: 0, first: 0, part: whole };
        // One right sibling waits for each level above the current node, and `split` lets no node
        // get deeper than MAX_DEPTH.
        let mut waiting = [task; MAX_DEPTH];
        let mut len = 0;
        self.nodes[1] = Node::EMPTY;
        loop {
            let Task { node, depth, first, part } = task;
            let run = &mut items[first..first + part.count];
            if part.count <= self.max_leaf {
                self.write(node, &part.bounds, first, part.count);
                for (entry, item) in self.order[first..].iter_mut().zip(run) {
                    *entry = item.triangle;
                }
                if len == 0 {
                    return;
                }
                len -= 1;
                task = waiting[len];
            } else {
                let [left, right] = self.split(run, &part, depth);
                let child = self.slots.pair();
                self.write(node, &part.bounds, child, 0);
                let depth = depth + 1;
                waiting[len] =
                    Task { node: child + 1, depth, first: first + left.count, part: right };
                len += 1;
                task = Task { node: child, depth, first, part: left };
            }
        }
    }

    fn write(&mut self, node: usize, bounds: &Bounds, first: usize, count: usize) {
        self.nodes[node] = Node {
            min: bounds.min.to_array(),
            first: first as u32,
            max: bounds.max.to_array(),
            count: count as u32,
        };
    }

    /// Reorders the run into two parts.
    fn split(&mut self, run: &mut [SahItem], part: &Part, depth: usize) -> [Part; 2] {
        // Halving the run down to single triangles takes `levels` more levels. SAH may not use a
        // level up unless they still fit below it; a median split needs them to fit below this
        // node, which holds at the root (31 ≤ MAX_DEPTH) and is handed down by either split.
        let levels = usize::BITS - (run.len() - 1).leading_zeros();
        if (levels as usize) < MAX_DEPTH - depth
            && let Some(split) = self.bins.best_split(run, &part.centres, self.scale)
        {
            partition(run, &split)
        } else {
            median_split(run, &part.centres)
        }
    }
}

/// Moves the items left of the split plane to the front.
///
/// Every step swaps, whichever side the item is on: which one is a coin toss to a branch predictor.
fn partition(run: &mut [SahItem], split: &Split) -> [Part; 2] {
    let mut middle = 0;
    let mut centres = [Bounds::EMPTY; 2];
    for i in 0..run.len() {
        let item = run[i];
        let is_left = split.is_left(&item);
        let side = usize::from(!is_left);
        centres[side] = centres[side].with(item.centre());
        run[i] = run[middle];
        run[middle] = item;
        middle += usize::from(is_left);
    }
    [
        Part { count: middle, bounds: split.left, centres: centres[0] },
        Part { count: run.len() - middle, bounds: split.right, centres: centres[1] },
    ]
}

/// Halves the run by centre along the longest axis, or as it stands if the centres coincide.
fn median_split(run: &mut [SahItem], centres: &Bounds) -> [Part; 2] {
    let middle = run.len() / 2;
    let extent = (centres.max - centres.min).to_array();
    let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
    if extent[axis] > 0.0 {
        let centre = |item: &SahItem| item.centre().to_array()[axis];
        run.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
    }
    let (left, right) = run.split_at(middle);
    [Part::of(left), Part::of(right)]
}
