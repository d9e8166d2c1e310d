//! parry3d: its `TriMesh`es and their BVHs, refitted to posed positions, and walked by its own
//! traversals.
//!
//! parry has no query for all pairs of two meshes, so this is what a user would write: candidates from
//! `Bvh::leaf_pairs` and `Bvh::traverse_bvtt_single_tree`, and a test for each. Either the second mesh is
//! posed and its BVH refitted, or boxes are posed during the traversal, as in parry's own mesh
//! intersection; which is faster depends on how much is touched.

use super::work::{Finder, Hit, Work};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::{Mat3, Pose, Rotation, Vec3};
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNode, BvhWorkspace};
use parry3d::query::details::intersection_test_support_map_support_map as gjk;
use parry3d::query::intersection_test;
use parry3d::shape::{TriMesh, Triangle};
use pfront::TrianglePair;
use pfront_testkit::inexact;

/// parry's own test of two triangles, which is GJK, as for all its convex shapes.
pub(crate) fn own(a: &Triangle, b: &Triangle) -> bool {
    gjk(&Pose::IDENTITY, a, b)
}

/// A plain test in f32.
pub(crate) fn fast(a: &Triangle, b: &Triangle) -> bool {
    let corners = |t: &Triangle| [t.a, t.b, t.c].map(|p| p.to_array());
    inexact::fast(&corners(a), &corners(b))
}

/// All hits by a test of two triangles. Triangles that share a vertex of one mesh are left out: a
/// test that knows nothing of this would report every one.
pub(crate) fn all<'w>(
    work: &'w Work,
    meets: impl Fn(&Triangle, &Triangle) -> bool + 'w,
) -> Box<dyn Finder + 'w> {
    let meshes: Vec<_> = work.meshes.iter().map(mesh).collect();
    let boxes: Vec<Aabb> = meshes.iter().map(TriMesh::local_aabb).collect();
    let broad = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    Box::new(Refitted { work, meets, meshes, broad, workspace: BvhWorkspace::default() })
}

struct Refitted<'w, F> {
    work: &'w Work,
    meets: F,
    meshes: Vec<TriMesh>,
    broad: Bvh,
    workspace: BvhWorkspace,
}

impl<F: Fn(&Triangle, &Triangle) -> bool> Finder for Refitted<'_, F> {
    fn place(&mut self, frame: usize) {
        let work = self.work;
        for (i, mesh) in self.meshes.iter_mut().enumerate().filter(|(i, _)| !work.rests(*i)) {
            mesh.update_vertices(|vertices| {
                let posed = work.positions(frame, i).map(Vec3::from_array);
                vertices.iter_mut().zip(posed).for_each(|(vertex, p)| *vertex = p);
            });
            self.broad.insert_or_update_partially(mesh.local_aabb(), i as u32, 0.0);
        }
        self.broad.refit_without_opt();
    }

    fn find(&mut self, _: usize, found: &mut Vec<Hit>) {
        let Self { meets, meshes, broad, workspace, .. } = self;
        if let [mesh] = &meshes[..] {
            mesh.bvh().traverse_bvtt_single_tree::<false>(workspace, &mut |i, j| {
                let (i, j) = (i.min(j), i.max(j));
                if !neighbours(mesh, i, j) && meets(&mesh.triangle(i), &mesh.triangle(j)) {
                    found.push(([0; 2], TrianglePair { a: i, b: j }));
                }
            });
            return;
        }
        broad.traverse_bvtt_single_tree::<false>(workspace, &mut |i, j| {
            let bodies = [i.min(j), i.max(j)];
            let [a, b] = bodies.map(|i| &meshes[i as usize]);
            let candidates = a.bvh().leaf_pairs(b.bvh(), BvhNode::intersects);
            let hits = candidates.filter(|&(i, j)| meets(&a.triangle(i), &b.triangle(j)));
            found.extend(hits.map(|(a, b)| (bodies, TrianglePair { a, b })));
        });
    }
}

fn neighbours(mesh: &TriMesh, i: u32, j: u32) -> bool {
    let [a, b] = [i, j].map(|t| mesh.indices()[t as usize]);
    a.iter().any(|vertex| b.contains(vertex))
}

/// All hits of two bodies by a test of two triangles, where no mesh is updated: boxes and triangles of the
/// second are posed as they are met. The pose is parry's, a quaternion, and rounds as such.
pub(crate) fn posed<'w>(
    work: &'w Work,
    meets: impl Fn(&Triangle, &Triangle) -> bool + 'w,
) -> Box<dyn Finder + 'w> {
    let (meshes, poses) = two(work);
    Box::new(move |frame: usize, found: &mut Vec<Hit>| {
        found.extend(posed_hits(&meshes, &poses[frame], &meets));
    })
}

/// The first hit of [`posed`].
pub(crate) fn first_posed<'w>(
    work: &'w Work,
    meets: impl Fn(&Triangle, &Triangle) -> bool + 'w,
) -> Box<dyn Finder + 'w> {
    let (meshes, poses) = two(work);
    Box::new(move |frame: usize, found: &mut Vec<Hit>| {
        found.extend(posed_hits(&meshes, &poses[frame], &meets).next());
    })
}

/// The hit of two bodies at which parry's own query stops.
pub(crate) fn first(work: &Work) -> Box<dyn Finder + '_> {
    let ([a, b], poses) = two(work);
    Box::new(move |frame: usize, found: &mut Vec<Hit>| {
        let hit = intersection_test(&Pose::IDENTITY, &a, &poses[frame], &b).unwrap();
        let pair = TrianglePair { a: hit.subshape1, b: hit.subshape2 };
        found.extend(hit.intersecting.then_some(([0, 1], pair)));
    })
}

fn posed_hits<'m>(
    [a, b]: &'m [TriMesh; 2],
    a_from_b: &'m Pose,
    meets: impl Fn(&Triangle, &Triangle) -> bool + 'm,
) -> impl Iterator<Item = Hit> + 'm {
    let overlap = |a: &BvhNode, b: &BvhNode| a.aabb().intersects(&b.aabb().transform_by(a_from_b));
    let met =
        move |&(i, j): &(u32, u32)| meets(&a.triangle(i), &b.triangle(j).transformed(a_from_b));
    let candidates = a.bvh().leaf_pairs(b.bvh(), overlap);
    candidates.filter(met).map(|(a, b)| ([0, 1], TrianglePair { a, b }))
}

/// Two bodies, and the poses of the second.
fn two(work: &Work) -> ([TriMesh; 2], Vec<Pose>) {
    let pose = |frame| {
        let [x, y, z] = work.pose(frame, 1).rows;
        let translation = Vec3::new(x[3], y[3], z[3]);
        let rows = [x, y, z].map(|[x, y, z, _]| Vec3::new(x, y, z));
        let rotation = Mat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        Pose::from_parts(translation, Rotation::from_mat3(&rotation))
    };
    let meshes = [0, 1].map(|i| mesh(&work.meshes[i]));
    (meshes, (0..work.frames()).map(pose).collect())
}

fn mesh(mesh: &pfront_testkit::MeshData) -> TriMesh {
    let vertices = mesh.positions.iter().copied().map(Vec3::from_array).collect();
    TriMesh::new(vertices, mesh.triangles.clone()).unwrap()
}
