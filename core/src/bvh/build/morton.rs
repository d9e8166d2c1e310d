//! The linear-time build along a Morton curve.
//!
//! Linear BVH after Lauterbach et al., "Fast BVH construction on GPUs" (2009): sort the triangles by the interleaved
//! bits of their centres, then split every run at its highest differing bit.
//!
//! Where we depart: a run whose codes are all equal gets new ones, over the box of its own centres. The root is the
//! first such run. So a few triangles far away take no resolution from the others, and codes of 27 bits are enough:
//! they share a word with the triangle's index.

use super::tree::{Divide, build};
use super::{BuildOptions, BvhStorage, radix};
use crate::aabb::Bounds;
use crate::bvh::TO_BITS;
use crate::parallel::{Join, halves};
use crate::{Aabb, Bvh, CapacityError, Mesh};
use glam::Vec3A;

/// Bits of a triangle index: [`MAX_TRIANGLES`](crate::MAX_TRIANGLES) fits.
const INDEX_BITS: u32 = 31;
const INDEX: u64 = (1 << INDEX_BITS) - 1;

/// Bits of a cell's number along one axis.
const AXIS_BITS: u32 = 9;
const LAST_CELL: u32 = (1 << AXIS_BITS) - 1;

const _: () = assert!(radix::BITS == 3 * AXIS_BITS && INDEX_BITS + 3 * AXIS_BITS <= u64::BITS);

/// Builds a BVH in linear time: several times faster than [`sah()`](super::sah()), and slower to traverse.
///
/// `scratch` has two words a triangle.
///
/// # Errors
/// [`CapacityError`] if `storage` has fewer order entries than there are triangles or fewer nodes than the tree,
/// or `scratch` is too short.
///
/// # Complexity
/// O(n) for usual meshes, O(n · [`MAX_DEPTH`](crate::bvh::MAX_DEPTH)) for any.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, morton};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 2])?;
/// assert_eq!(bvh.order(), [0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn morton<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions<'_>,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
) -> Result<Bvh<'a>, CapacityError> {
    let count = mesh.triangles().len();
    CapacityError::check("order", count, storage.order.len())?;
    CapacityError::check("scratch", 2 * count, scratch.len())?;
    let (keys, spare) = scratch[..2 * count].split_at_mut(count);
    for (key, triangle) in keys.iter_mut().zip(0..) {
        *key = triangle;
    }
    let run = MortonRun { keys, spare, coincide: false };
    build(mesh, options, storage, &Curve { mesh, join: options.join }, run)
}

/// Triangles by their keys: a Morton code above the index. Every run but that of all triangles is sorted.
struct MortonRun<'r> {
    keys: &'r mut [u64],
    spare: &'r mut [u64],
    /// Whether no code can tell the centres apart.
    coincide: bool,
}

impl MortonRun<'_> {
    /// The highest bit of the code in which keys differ, or 0.
    fn highest_bit(&self) -> u64 {
        let differing = match *self.keys {
            [first, .., last] => (first ^ last) & !INDEX,
            _ => 0,
        };
        if differing == 0 { 0 } else { 1 << differing.ilog2() }
    }
}

struct Curve<'c> {
    mesh: Mesh<'c>,
    join: Option<&'c Join<'c>>,
}

impl Divide for Curve<'_> {
    type Run<'r> = MortonRun<'r>;

    fn leaf(&self, run: &MortonRun<'_>, order: &mut [u32]) -> Aabb {
        let mut all = Bounds::EMPTY;
        for (entry, &key) in order.iter_mut().zip(&*run.keys) {
            *entry = (key & INDEX) as u32;
            all = all.union(&self.mesh.bounds(*entry));
        }
        all.into()
    }

    fn divide<'r>(
        &self,
        run: &'r mut MortonRun<'_>,
        count: usize,
        free: bool,
    ) -> (usize, [MortonRun<'r>; 2]) {
        if free && !run.coincide && run.highest_bit() == 0 {
            self.encode(run);
            run.coincide = run.highest_bit() == 0;
        }
        let middle = match run.highest_bit() {
            bit if free && bit != 0 => run.keys.partition_point(|key| key & bit == 0),
            _ => count / 2,
        };
        let ((left, right), (left_spare, right_spare)) =
            (run.keys.split_at_mut(middle), run.spare.split_at_mut(middle));
        let half = |keys, spare| MortonRun { keys, spare, coincide: run.coincide };
        (middle, [half(left, left_spare), half(right, right_spare)])
    }
}

impl Curve<'_> {
    /// Replaces the codes of a run by those within the box of its centres, and sorts.
    #[inline(never)]
    fn encode(&self, run: &mut MortonRun<'_>) {
        // At half scale neither a centre nor the difference of two can overflow. In between, x and y are in the
        // key, z and the index in the other word.
        let centre = |keys: &mut [u64], spare: &mut [u64]| {
            let mut all = Bounds::EMPTY;
            for (key, spare) in keys.iter_mut().zip(spare) {
                let triangle = *key & INDEX;
                let centre = self.mesh.bounds(triangle as u32).half_centre();
                all = all.union(&Bounds::of(centre));
                let [x, y, z] = centre.to_array().map(|x| u64::from(x.to_bits()));
                (*key, *spare) = (x | y << 32, z | triangle << 32);
            }
            all
        };
        let union = |a: Bounds, b: Bounds| a.union(&b);
        let Bounds { min: origin, max } = halves(self.join, run.keys, run.spare, &centre, &union);
        let per_unit = Vec3A::splat(LAST_CELL as f32) / (max - origin);
        let usable = per_unit.cmple(Vec3A::splat(f32::MAX));
        let cells_per_unit = Vec3A::select(usable, per_unit, Vec3A::ZERO);
        let encode = |keys: &mut [u64], spare: &mut [u64]| {
            for (&mut key, spare) in keys.iter_mut().zip(spare) {
                let centre = [key, key >> 32, *spare].map(|x| f32::from_bits(x as u32));
                let cell = (Vec3A::from_array(centre) - origin) * cells_per_unit;
                let [x, y, z] = (cell + TO_BITS).to_array().map(|cell| cell.to_bits() & LAST_CELL);
                let code = spread(x, y) << 1 | spread(0, z);
                *spare = code << INDEX_BITS | *spare >> 32;
            }
        };
        halves(self.join, run.keys, run.spare, &encode, &|(), ()| ());
        radix::sort(run.spare, run.keys, INDEX_BITS, self.join);
    }
}

/// Moves bit i of two 9-bit numbers to bit 3i + 1 and 3i: both at once, in the halves of a word.
fn spread(upper: u32, lower: u32) -> u64 {
    let both = |mask: u64| mask << 32 | mask;
    let x = u64::from(upper) << 32 | u64::from(lower);
    let x = (x | x << 16) & both(0x0100_00ff);
    let x = (x | x << 8) & both(0x0100_f00f);
    let x = (x | x << 4) & both(0x010c_30c3);
    let x = (x | x << 2) & both(0x0124_9249);
    x >> 31 | x & 0xffff_ffff
}
