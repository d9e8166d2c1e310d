//! Building and refitting on several threads.

use pfront_core::bvh::{self, BuildOptions, BvhStorage, SahItem};
use pfront_core::{Bvh, CapacityError, Mesh, Node};

/// [`bvh::sah_with`] in the rayon pool of the calling thread.
///
/// # Errors
/// As [`bvh::sah`].
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, SahItem};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let options = BuildOptions::default();
/// let bvh = pfront_cpu::sah(mesh, &options, storage, &mut [SahItem::default()])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sah<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [SahItem],
) -> Result<Bvh<'a>, CapacityError> {
    bvh::sah_with(mesh, options, storage, scratch, &join)
}

/// [`bvh::morton_with`] in the rayon pool of the calling thread.
///
/// # Errors
/// As [`bvh::morton`].
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage};
/// use pfront_core::{Mesh, Node};
/// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; 2], [0; 1]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = pfront_cpu::morton(mesh, &BuildOptions::default(), storage, &mut [0; 2])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn morton<'a>(
    mesh: Mesh<'a>,
    options: &BuildOptions,
    storage: BvhStorage<'a>,
    scratch: &mut [u64],
) -> Result<Bvh<'a>, CapacityError> {
    bvh::morton_with(mesh, options, storage, scratch, &join)
}

/// [`bvh::refit_with`] in the rayon pool of the calling thread.
///
/// # Panics
/// As [`bvh::refit_with`].
///
/// # Examples
/// ```
/// # use pfront_core::{Mesh, Node, bvh::REBUILD_RATIO};
/// # fn rebuild() {}
/// # fn f(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32], when_built: f32) {
/// if pfront_cpu::refit(mesh, nodes, order) > REBUILD_RATIO * when_built {
///     rebuild();
/// }
/// # }
/// ```
pub fn refit(mesh: Mesh<'_>, nodes: &mut [Node], order: &[u32]) -> f32 {
    bvh::refit_with(mesh, nodes, order, &join)
}

/// Does two things at once in the rayon pool of whoever asks. It is what `bvh::refit_with` and its like in
/// `pfront-core` want.
///
/// # Examples
/// ```
/// let (mut a, mut b) = (1, 2);
/// pfront_cpu::join(&mut || a += 1, &mut || b += 1);
/// assert_eq!([a, b], [2, 3]);
/// ```
pub fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::bvh::node_bound;
    use pfront_scenes::icosphere;

    #[test]
    fn parts_give_the_tree_of_the_whole() {
        for triangles in [0, 1, 20, 30_000, 200_000] {
            let mut ball = icosphere(triangles.max(20));
            ball.triangles.truncate(triangles);
            let squeezed: Vec<_> =
                ball.positions.iter().map(|p| [p[0], p[1] * p[0], 0.0]).collect();
            let mesh = Mesh::new(&ball.positions, &ball.triangles).unwrap();
            let n = ball.triangles.len();
            for (by_morton, leaf_size) in [(false, 1), (false, 8), (true, 1), (true, 8)] {
                let options = BuildOptions { leaf_size, ..BuildOptions::default() };
                let (mut items, mut keys) = (vec![SahItem::default(); n], vec![0; 2 * n]);
                let mut built = |with_threads: bool| {
                    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(n)], vec![0; n]);
                    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
                    let bvh = match (by_morton, with_threads) {
                        (false, false) => bvh::sah(mesh, &options, storage, &mut items),
                        (false, true) => sah(mesh, &options, storage, &mut items),
                        (true, false) => bvh::morton(mesh, &options, storage, &mut keys),
                        (true, true) => morton(mesh, &options, storage, &mut keys),
                    };
                    let used = bvh.unwrap().nodes().len();
                    nodes.truncate(used);
                    (nodes, order)
                };
                let (mut whole, order) = built(false);
                let (mut nodes, same_order) = built(true);
                assert!(nodes == whole && order == same_order, "{triangles} {by_morton}");

                let moved = mesh.with_positions(&squeezed).unwrap();
                let quality = bvh::refit(moved, &mut whole, &order);
                let in_parts = refit(moved, &mut nodes, &order);
                assert!((in_parts - quality).abs() <= 1e-5 * quality, "{in_parts} {quality}");
                assert!(nodes == whole);
            }
        }
    }
}
