//! A whole use by pointers, small enough for miri, which sees what no sanitizer does: whether Rust's views of the
//! caller's arrays ever get into each other's way, and whether what was never written is read.

#![expect(unsafe_code, reason = "it is C's part that is played here")]

use crate::pfront_status_t::*;
use crate::*;
use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};
use core::slice;
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use pfront_core::{Bvh, Mesh, Node, Pose};

const TRIANGLES: usize = 8;

/// Two tetrahedra, one with a corner inside the other.
const POINTS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.1, 0.1, 0.1],
    [2.0, 0.0, 0.5],
    [0.0, 2.0, 0.5],
    [0.5, 0.5, 2.0],
];
const CORNERS: [[u32; 3]; TRIANGLES] =
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [4, 6, 5], [4, 5, 7], [4, 7, 6], [5, 6, 7]];

/// Calls a function that fills in its last but one argument and must succeed.
macro_rules! made {
    ($call:ident($($argument:expr),*)) => {{
        let mut made = MaybeUninit::uninit();
        // SAFETY: every pointer is null or leads to a live array of the length that goes with it.
        let status = unsafe { $call($($argument,)* made.as_mut_ptr(), null_mut()) };
        assert_eq!(status, PFRONT_OK);
        // SAFETY: it was filled in.
        unsafe { made.assume_init() }
    }};
}

/// Arrays for one build, which nobody has written yet.
struct Arrays {
    nodes: [MaybeUninit<pfront_node_t>; 2 * TRIANGLES],
    order: [MaybeUninit<u32>; TRIANGLES],
    scratch: [MaybeUninit<u8>; 1024],
}

impl Arrays {
    fn new() -> Self {
        let scratch = [MaybeUninit::uninit(); 1024];
        Self {
            nodes: [MaybeUninit::uninit(); 2 * TRIANGLES],
            order: [MaybeUninit::uninit(); TRIANGLES],
            scratch,
        }
    }

    fn memory(&mut self) -> pfront_bvh_memory_t {
        pfront_bvh_memory_t {
            nodes: self.nodes.as_mut_ptr().cast(),
            node_capacity: self.nodes.len(),
            order: self.order.as_mut_ptr().cast(),
            order_capacity: self.order.len(),
            scratch: self.scratch.as_mut_ptr().cast(),
            scratch_bytes: self.scratch.len(),
        }
    }
}

/// The two tetrahedra with indices of 32 bits.
fn packed() -> pfront_buffers_t {
    pfront_buffers_t {
        positions: POINTS.as_ptr().cast(),
        vertex_count: POINTS.len(),
        stride: 0,
        triangles: CORNERS.as_ptr().cast(),
        triangle_count: TRIANGLES,
        index_type: pfront_index_type_t::PFRONT_INDEX_U32 as u32,
    }
}

/// All pairs, in pages of two and in order.
fn pages(query: &pfront_query_t, mut cursor: pfront_cursor_t) -> Vec<(u32, u32)> {
    let (mut all, mut page) = (Vec::new(), [pfront_pair_t { a: 0, b: 0 }; 2]);
    while cursor.done == 0 {
        let count: usize = made!(pfront_query_page(query, &mut cursor, page.as_mut_ptr(), 2));
        all.extend(page[..count].iter().map(|pair| (pair.a, pair.b)));
    }
    all.sort_unstable();
    all
}

fn truth(query: &impl Query) -> Vec<(u32, u32)> {
    let mut all = Vec::new();
    let _ = query.visit(&mut query.start(), |pair| {
        all.push((pair.a, pair.b));
        core::ops::ControlFlow::Continue(())
    });
    all.sort_unstable();
    all
}

/// The BVH of Rust over the arrays of one that C holds, checked.
fn checked(bvh: &pfront_bvh_t) -> Bvh<'_> {
    let pfront_bvh_t { mesh, nodes, node_count, order, .. } = *bvh;
    // SAFETY: the arrays are there, of these lengths, and nobody writes them as long as the view is in use.
    let (positions, nodes, order) = unsafe {
        (
            slice::from_raw_parts(mesh.positions.cast(), mesh.vertex_count),
            slice::from_raw_parts(nodes.cast_const().cast::<Node>(), node_count),
            slice::from_raw_parts(order, TRIANGLES),
        )
    };
    Bvh::new(Mesh::new(positions, &CORNERS).unwrap(), nodes, order, &mut [0]).unwrap()
}

/// The pairs of each query, node by node of a front.
fn parts(queries: &[pfront_query_t; 2], front: &pfront_front_t) -> [Vec<(u32, u32)>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    // SAFETY: so many nodes are in use.
    for node in unsafe { slice::from_raw_parts_mut(front.nodes, front.node_count) } {
        let (number, pair) = (node.query as usize, node.pair);
        let mut cursor: pfront_cursor_t = made!(pfront_cursor_start(&queries[number]));
        // SAFETY: all of these are references.
        let status = unsafe { pfront_cursor_at(&queries[number], pair, &mut cursor, null_mut()) };
        assert_eq!(status, PFRONT_OK);
        parts[number].extend(pages(&queries[number], cursor));
    }
    parts.iter_mut().for_each(|part| part.sort_unstable());
    parts
}

#[test]
fn a_frame_and_the_next() {
    let mut positions = POINTS;
    let (points, vertices) = (positions.as_mut_ptr().cast::<f32>(), POINTS.len());
    let mut arrays = Arrays::new();
    let memory = arrays.memory();
    let mut history = [MaybeUninit::<u32>::uninit(); 64];
    let (history, words): (*mut u32, _) = (history.as_mut_ptr().cast(), history.len());
    let mut part = [MaybeUninit::<pfront_front_node_t>::uninit(); 16];
    let mut last = [MaybeUninit::<pfront_front_node_t>::uninit(); 16];
    let mut costs = [MaybeUninit::<pfront_part_t>::uninit(); 2];
    let mut front = MaybeUninit::uninit();
    let a_from_b = pfront_pose_t { rows: Pose::from_translation([0.25, 0.0, 0.125]).rows };

    let mesh: pfront_mesh_t =
        made!(pfront_mesh_check(points, vertices, CORNERS.as_ptr().cast(), TRIANGLES));
    let _: pfront_bvh_t = made!(pfront_bvh_build_morton(&mesh, 3, &memory));
    let mut bvh: pfront_bvh_t = made!(pfront_bvh_build_sah(&mesh, 3, &memory));
    let all = [PFRONT_OK; 2];
    // SAFETY: every pointer leads to a live array of the length that goes with it.
    let statuses = unsafe {
        let (part, last) = (part.as_mut_ptr().cast(), last.as_mut_ptr().cast());
        let bytes = memory.scratch_bytes;
        [
            pfront_one_rings_link(&mesh, history, words, memory.scratch, bytes, null_mut()),
            pfront_front_init(front.as_mut_ptr(), part, 16, last, 16, null_mut()),
        ]
    };
    assert_eq!(statuses, all);
    // SAFETY: it was filled in.
    let mut front = unsafe { front.assume_init() };

    for frame in 0..2 {
        // SAFETY: as above; and nobody else holds on to the positions.
        let status = unsafe {
            *points = -0.5 * frame as f32;
            pfront_bvh_refit(&mut bvh, points, vertices, null_mut(), null_mut())
        };
        assert_eq!(status, PFRONT_OK);
        let within: pfront_query_t = made!(pfront_query_self(&bvh, history, 0));
        let pair: pfront_query_t = made!(pfront_query_pair(&bvh, &bvh, &a_from_b));
        let own = checked(&bvh);
        let other = PairBvtt::new(own, own, Pose::new(a_from_b.rows)).unwrap();
        let expected = [truth(&SelfBvtt::new(own)), truth(&other)];
        assert!(expected.iter().all(|pairs| !pairs.is_empty()));

        let queries = [within, pair];
        for (query, expected) in queries.iter().zip(&expected) {
            assert_eq!(&pages(query, made!(pfront_cursor_start(query))), expected);
            let count: u64 = made!(pfront_query_count(query));
            assert_eq!(count, expected.len() as u64);
        }
        let (asked, workers) = (queries.as_ptr(), costs.as_mut_ptr().cast());
        // SAFETY: as above.
        let divided = unsafe { pfront_front_divide(&mut front, asked, 2, workers, 2, null_mut()) };
        assert_eq!((divided, front.coherent), (PFRONT_OK, frame));
        assert_eq!(parts(&queries, &front), expected);
        // SAFETY: as above.
        assert_eq!(unsafe { pfront_front_remember(&mut front, null_mut()) }, PFRONT_OK);
    }
}

#[test]
fn a_blob_is_borrowed() {
    let mut arrays = Arrays::new();
    let memory = arrays.memory();
    let (points, corners) = (POINTS.as_ptr().cast(), CORNERS.as_ptr().cast());
    let mesh: pfront_mesh_t = made!(pfront_mesh_check(points, POINTS.len(), corners, TRIANGLES));
    let built: pfront_bvh_t = made!(pfront_bvh_build_sah(&mesh, 1, &memory));
    let (mut words, bytes) = ([MaybeUninit::<u32>::uninit(); 256], made!(pfront_blob_size(&built)));
    // SAFETY: there is room for more.
    let written =
        unsafe { pfront_blob_write(&built, words.as_mut_ptr().cast(), bytes, null_mut()) };
    assert_eq!(written, PFRONT_OK);
    let (blob, free) = (words.as_ptr().cast(), memory.scratch);
    let least: usize = made!(pfront_blob_scratch_bytes(blob, bytes));
    let borrowed: pfront_bvh_t = made!(pfront_bvh_from_blob(blob, bytes, free, least));
    assert_eq!(checked(&borrowed).nodes(), checked(&built).nodes());
    let [own, other] = [built, borrowed].map(|bvh| {
        let query = made!(pfront_query_self(&bvh, null_mut(), 0));
        pages(&query, made!(pfront_cursor_start(&query)))
    });
    assert!(own == other && !own.is_empty());
}

#[test]
fn buffers_that_are_not_packed_and_a_list() {
    let vertices = POINTS.map(|[x, y, z]| [f32::NAN, x, y, z]);
    let indices = CORNERS.map(|corners| corners.map(|index| index as u16));
    let buffers = pfront_buffers_t {
        positions: vertices.as_ptr().cast::<f32>().wrapping_add(1).cast(),
        stride: 16,
        triangles: indices.as_ptr().cast(),
        index_type: pfront_index_type_t::PFRONT_INDEX_U16 as u32,
        ..packed()
    };
    let bytes: usize = made!(pfront_mesh_bytes(&buffers));
    let mut memory = [MaybeUninit::<u8>::uninit(); 256];
    let at = memory.as_mut_ptr().cast();
    let mesh: pfront_mesh_t = made!(pfront_mesh_from_buffers(&buffers, at, bytes));
    // SAFETY: so many are there, and nobody writes them.
    let (positions, triangles) = unsafe {
        (
            slice::from_raw_parts(mesh.positions.cast::<[f32; 3]>(), mesh.vertex_count),
            slice::from_raw_parts(mesh.triangles.cast::<[u32; 3]>(), mesh.triangle_count),
        )
    };
    assert_eq!((positions, triangles), (&POINTS[..], &CORNERS[..]));

    let still = pfront_pose_t::IDENTITY;
    let mut list: pfront_pair_list_t = made!(pfront_all(&buffers, &packed(), &still, null()));
    // SAFETY: so many are there, and nobody writes them.
    let pairs = unsafe { slice::from_raw_parts(list.pairs, list.count) };
    assert!(pairs.iter().all(|pair| pair.a < 8 && pair.b < 8) && pairs.len() > TRIANGLES);
    // SAFETY: it was made just now.
    assert_eq!(unsafe { pfront_pair_list_free(&mut list, null_mut()) }, PFRONT_OK);
}

#[test]
fn bodies_of_a_scene() {
    // Few, since miri is slow.
    let buffers = pfront_buffers_t { triangle_count: 2, ..packed() };
    let scene: *mut pfront_scene_t = made!(pfront_scene_create(null()));
    let model: *mut pfront_model_t = made!(pfront_model_create(&buffers));
    let still = pfront_pose_t::IDENTITY;
    let bodies: [u64; 2] = [0; 2].map(|_| made!(pfront_scene_add(scene, model, &still)));
    let (mut hits, mut contacts) = (null(), null());
    let mut counts = [0; 2];
    // SAFETY: the scene is there, and so are all results.
    let statuses = unsafe {
        [
            pfront_scene_update(scene, &mut hits, &mut counts[0], null_mut()),
            pfront_scene_set_user_data(scene, bodies[1], 7, null_mut()),
            pfront_scene_contacts(scene, &mut contacts, &mut counts[1], null_mut()),
        ]
    };
    assert_eq!(statuses, [PFRONT_OK; 3]);
    assert!(counts[0] > 0 && counts[1] == counts[0]);
    assert_eq!(made!(pfront_scene_user_data(scene, bodies[1])), 7_u64);
    // SAFETY: the scene has found as many and keeps them.
    let (hits, contacts) = unsafe {
        (slice::from_raw_parts(hits, counts[0]), slice::from_raw_parts(contacts, counts[1]))
    };
    for (hit, contact) in hits.iter().zip(contacts) {
        assert_eq!((hit.bodies, contact.hit.bodies), (bodies, bodies));
        assert!(contact.contact.kind != 0);
    }
    // SAFETY: both were made above, and are not used any more.
    let freed =
        unsafe { [pfront_scene_free(scene, null_mut()), pfront_model_free(model, null_mut())] };
    assert_eq!(freed, [PFRONT_OK; 2]);
}
