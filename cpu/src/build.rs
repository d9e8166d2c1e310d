//! Building and refitting on several threads.

use pfront_core::bvh::{self, BuildOptions, BvhStorage, SahItem};
use pfront_core::one_ring::{self, Fan, Span};
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

/// [`one_ring::certify_with`] in the rayon pool of the calling thread.
///
/// # Errors
/// As [`one_ring::certify_with`].
///
/// # Examples
/// ```
/// # use pfront_core::{CapacityError, Mesh, one_ring::{Fan, Span}};
/// # fn f(moved: Mesh<'_>, spans: &[Span], fans: &mut [Fan]) -> Result<(), CapacityError> {
/// pfront_cpu::certify(moved, spans, fans)?;
/// # Ok(())
/// # }
/// ```
pub fn certify(mesh: Mesh<'_>, spans: &[Span], fans: &mut [Fan]) -> Result<(), CapacityError> {
    one_ring::certify_with(mesh, spans, fans, &join)
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
    use pfront_scenes::{Scene, icosphere};
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    /// So that each span of triangles reaches everywhere.
    fn shuffle(triangles: &mut [[u32; 3]]) {
        let n = triangles.len();
        (0..n).for_each(|i| triangles.swap(i, i * 7919 % n));
    }

    /// The fans of a mesh, linked, and its spans.
    fn linked(mesh: Mesh<'_>) -> (Vec<Fan>, Vec<Span>) {
        let (vertices, n) = (mesh.positions().len(), mesh.triangles().len());
        let (mut fans, mut spans) =
            (vec![Fan::default(); vertices], vec![Span::default(); one_ring::span_bound(n)]);
        let mut scratch = vec![0; one_ring::link_scratch_bound(vertices, n)];
        one_ring::link(mesh, &mut scratch, &mut fans).unwrap();
        one_ring::find_spans(mesh, &mut spans).unwrap();
        (fans, spans)
    }

    #[test]
    fn parts_certify_what_the_whole_does() {
        let scene = Scene::by_name("sheet", Some(150_000)).unwrap();
        let (mut triangles, mut positions) = (scene.meshes[0].triangles.clone(), Vec::new());
        // Crumpled, so that some fans are certified and some are not.
        scene.positions(70, &mut positions);
        for (p, i) in positions.iter_mut().zip(0_u32..) {
            let jitter = 0.004 * (i.wrapping_mul(2_654_435_761) >> 20 & 7) as f32;
            (p[0], p[1]) = (p[0] + jitter, p[1] - jitter);
        }
        let vertices = positions.len();
        for shuffled in [false, true] {
            if shuffled {
                shuffle(&mut triangles);
            }
            let mesh = Mesh::new(&positions, &triangles).unwrap();
            let (mut whole, spans) = linked(mesh);
            let mut in_parts = whole.clone();
            one_ring::certify(mesh, &mut whole).unwrap();
            certify(mesh, &spans, &mut in_parts).unwrap();
            assert!(whole == in_parts, "shuffled: {shuffled}");
            let good = whole.iter().filter(|fan| fan.is_certified()).count();
            assert!((vertices / 10..vertices * 9 / 10).contains(&good), "{good} of {vertices}");
            assert!(certify(mesh, &spans[1..], &mut in_parts).is_err());
            assert!(certify(mesh, &spans, &mut in_parts[1..]).is_err());
        }
    }

    /// At sizes about those of parts, with vertices that no triangle uses at the end.
    #[test]
    fn a_mesh_is_divided_where_its_triangles_are_in_order() {
        for vertices in [0_usize, 3, 8192, 8193, 16_384, 16_385, 40_000] {
            let positions: Vec<_> =
                (0..vertices).map(|i| [i as f32, (i % 2) as f32, (i % 5) as f32]).collect();
            let used = vertices - vertices / 10;
            let strip: Vec<_> = (2..used as u32).map(|i| [i - 2, i - 1, i]).collect();
            let parts = vertices.div_ceil(8192).max(1);
            for shuffled in [false, true] {
                let mut triangles = strip.clone();
                if shuffled {
                    shuffle(&mut triangles);
                }
                let mesh = Mesh::new(&positions, &triangles).unwrap();
                let (mut whole, spans) = linked(mesh);
                let (mut in_parts, joins) = (whole.clone(), AtomicUsize::new(0));
                one_ring::certify_with(mesh, &spans, &mut in_parts, &|a, b| {
                    joins.fetch_add(1, Relaxed);
                    a();
                    b();
                })
                .unwrap();
                one_ring::certify(mesh, &mut whole).unwrap();
                assert!(whole == in_parts, "{vertices}, shuffled: {shuffled}");
                let wanted = if shuffled && vertices > 20_000 { 0 } else { parts - 1 };
                assert_eq!(joins.into_inner(), wanted, "{vertices}, shuffled: {shuffled}");
            }
        }
    }

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
