//! "Does not allocate", counted: nothing in the core, and no frame of a query after the first.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::{
    Adjacency, BuildOptions, Bvh, Mesh, Model, Node, PairQuery, Pose, SceneQuery, SelfQuery,
    TrianglePair,
};
use pfront_core::bvh::{self, BvhStorage, Refit, node_bound};
use pfront_core::bvtt::{self, Query};
use pfront_core::triangle::{contact, intersects};
use pfront_testkit::MeshData;
use pfront_testkit::rng::seeded;
use pfront_testkit::shapes::{pose_rows, sheet, sphere, tangle};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

struct Counting;

thread_local! {
    /// Allocations of this thread: tests run side by side.
    static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes that this thread holds, and the most that it held.
    static HELD: Cell<[isize; 2]> = const { Cell::new([0; 2]) };
}

fn count_one(size: usize) {
    COUNT.set(COUNT.get() + 1);
    hold(size as isize);
}

fn hold(bytes: isize) {
    let [held, most] = HELD.get();
    HELD.set([held + bytes, most.max(held + bytes)]);
}

#[expect(unsafe_code, reason = "an allocator can be counted only by being one")]
// SAFETY: every call goes to the system allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_one(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count_one(layout.size());
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both blocks are there for a while.
        count_one(size);
        hold(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        hold(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn model(soup: &MeshData) -> Model {
    Model::new(soup.positions.clone(), soup.triangles.clone()).unwrap()
}

/// How many allocations a call makes on this thread.
fn allocations(call: impl FnOnce()) -> usize {
    let before = COUNT.get();
    call();
    COUNT.get() - before
}

/// The most bytes that this thread holds during a call, beyond what it held before.
fn most_bytes(call: impl FnOnce()) -> isize {
    let [before, _] = HELD.get();
    HELD.set([before; 2]);
    call();
    HELD.get()[1] - before
}

#[test]
fn the_count_works() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1]))), 1);
    let grow = |list: &mut Vec<u8>| list.reserve_exact(std::hint::black_box(200));
    assert_eq!(most_bytes(|| drop(std::hint::black_box(vec![1_u8; 100]))), 100);
    assert_eq!(most_bytes(|| grow(&mut Vec::with_capacity(100))), 300);
}

/// Parallel triangles whose boxes all overlap, so that each two bodies are asked about each other.
#[cfg(feature = "threads")]
#[test]
fn threads_take_no_memory_for_each_pair_of_bodies() {
    let triangle = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let tile = Arc::new(Model::new(triangle, vec![[0, 1, 2]]).unwrap());
    let frame = |bodies: usize| {
        let mut scene = SceneQuery::new().on(&pfront::Executor::threads(2));
        for i in 0..bodies {
            let shift = Pose::from_translation([0.0, 0.0, 1e-4 * i as f32]);
            scene.add(tile.clone(), shift).unwrap();
        }
        let bytes = most_bytes(|| assert!(scene.all().unwrap().is_empty()));
        assert_eq!(scene.count().unwrap(), 0);
        (bytes, bodies * (bodies - 1) / 2)
    };
    // Three batches of 65,536 pairs, and twenty: each takes the memory of the one before. Whether any is worth a front, of some 64 bytes a
    // pair, is measured, and may differ.
    let ((few_bytes, few), (many_bytes, many)) = (frame(640), frame(1_600));
    // 8 bytes for a pair of the broad phase, in a vector that grows by doubling.
    let per_pair = (many_bytes - few_bytes) as f64 / (many - few) as f64;
    assert!(per_pair < 40.0, "{per_pair:.0} bytes for each pair of bodies more");
}

#[test]
fn the_core_allocates_nothing() {
    let mut rng = seeded(1);
    for soup in [sphere(20), sheet(20, |x, y| x * y), tangle(30, 300, 2, &mut rng)] {
        let n = soup.triangles.len();
        let mut nodes = vec![Node::EMPTY; node_bound(n)];
        let mut order = vec![0; n];
        let mut sah_scratch = vec![Node::EMPTY; n];
        let mut morton_scratch = vec![0; 2 * n];
        let mut check_scratch = vec![0; n.div_ceil(32)];
        let moved: Vec<_> = soup.positions.iter().map(|p| p.map(|x| x * 0.9)).collect();
        let options = BuildOptions::default();
        let here = Pose::new(pose_rows(0.1, &mut rng));

        let count = allocations(|| {
            let mesh = Mesh::new(&soup.positions, &soup.triangles).unwrap();
            let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
            let bvh = bvh::morton(mesh, &options, storage, &mut morton_scratch).unwrap();
            ask_everything(bvh, here);
            let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
            let used = bvh::sah(mesh, &options, storage, &mut sah_scratch).unwrap().nodes().len();
            let mesh = mesh.with_positions(&moved).unwrap();
            bvh::refit(mesh, &mut nodes[..used], &order, Refit::default()).unwrap();
            ask_everything(
                Bvh::new(mesh, &nodes[..used], &order, &mut check_scratch).unwrap(),
                here,
            );
        });
        assert_eq!(count, 0);
    }
}

fn ask_everything(bvh: Bvh<'_>, pose: Pose) {
    bvh.assert_well_formed();
    for pose in [pose, Pose::IDENTITY] {
        assert!(verbs(&bvtt::PairBvtt::new(bvh, bvh, pose).unwrap()) > 0);
    }
    for adjacency in [Adjacency::SharedIndexRule, Adjacency::SkipNeighbours] {
        verbs(&bvtt::SelfBvtt::new(bvh).with_adjacency(adjacency));
    }
    let [a, b] = [0, 1].map(|i| bvh.mesh().shadow_triangle(i));
    assert_eq!(intersects(&a, &b), contact(&a, &b).is_some());
}

fn verbs(query: &impl Query) -> u64 {
    let mut page = [TrianglePair::default(); 7];
    let (mut cursor, mut paged) = (query.start(), 0);
    while !cursor.is_done() {
        paged += query.page(&mut cursor, &mut page) as u64;
    }
    assert_eq!(paged, query.count());
    assert_eq!(query.any().is_some(), paged > 0);
    let _ = query.visit(&mut query.start(), |pair| {
        std::hint::black_box(query.contact(pair));
        ControlFlow::Continue(())
    });
    paged
}

#[test]
fn steady_frames_allocate_nothing() {
    let mut rng = seeded(2);
    let (a, b) = (model(&sphere(20)), model(&sphere(16)));
    let mut query = PairQuery::new();
    let poses: Vec<_> = (0..30).map(|_| Pose::new(pose_rows(1.0, &mut rng))).collect();
    let mut frame = |pose: &Pose| {
        // In this order none is answered by what is kept of the one before.
        query.any(&a, &b, pose).unwrap();
        query.count(&a, &b, pose).unwrap();
        query.all(&a, &b, pose).unwrap();
        query.contacts(&a, &b, pose).unwrap();
        let _ = query.visit(&a, &b, pose, |_| ControlFlow::Continue(())).unwrap();
    };
    // The first round grows the buffers to the largest frame.
    poses.iter().for_each(&mut frame);
    assert_eq!(allocations(|| poses.iter().for_each(&mut frame)), 0);
}

#[test]
fn steady_frames_of_a_deforming_mesh_allocate_nothing() {
    let shapes: Vec<_> = (0..30)
        .map(|frame| {
            let bend = 3.0 + 0.01 * frame as f32;
            let shape = sheet(20, |_, _| 0.0);
            shape.map(|[x, y, _]| [(bend * x).sin(), y, 1.0 - (bend * x).cos()])
        })
        .collect();
    let mut model = model(&shapes[0]);
    let mut query = SelfQuery::new();
    let mut frames = || {
        for shape in &shapes {
            // The motion is so small that the tree is refitted, never rebuilt.
            model.set_positions(&shape.positions).unwrap();
            query.any(&model).unwrap();
            query.count(&model).unwrap();
            query.all(&model).unwrap();
            query.contacts(&model).unwrap();
            let _ = query.visit(&model, |_| ControlFlow::Continue(()));
        }
    };
    frames();
    assert_eq!(allocations(frames), 0);
}

#[test]
fn steady_frames_of_a_mesh_that_is_fitted_late_or_in_part_allocate_nothing() {
    let flat = sheet(30, |_, _| 0.0);
    let lifted = |rows: std::ops::Range<usize>| {
        let mut positions = flat.positions.clone();
        rows.flat_map(|row| row * 31..row * 31 + 9).for_each(|i| positions[i][2] += 0.001);
        positions
    };
    let shapes: Vec<_> = [0..1, 0..2, 0..31, 4..6, 4..31, 4..5].map(lifted).into();
    let mut model = model(&flat);
    let mut query = SelfQuery::new();
    let mut frames = || {
        for shape in &shapes {
            model.set_positions(shape).unwrap();
            query.all(&model).unwrap();
            model.set_positions_unfitted(&flat.positions).unwrap();
            query.all(&model).unwrap();
            model.set_positions_unfitted(shape).unwrap();
            model.set_positions_unfitted(&flat.positions).unwrap();
            model.fit();
        }
    };
    frames();
    assert_eq!(allocations(frames), 0);
}

#[test]
fn steady_frames_of_a_scene_allocate_nothing() {
    let mut rng = seeded(3);
    let ball = Arc::new(model(&sphere(8)));
    let mut scene = SceneQuery::new();
    let mut place = |reach| Pose::new(pose_rows(reach, &mut rng));
    let ids: Vec<_> = (0..20).map(|_| scene.add(ball.clone(), place(4.0)).unwrap()).collect();
    let frames: Vec<Vec<Pose>> = (0..10)
        .map(|frame| {
            let step = |id: usize| [0.01 * (frame * id) as f32, 0.3 * id as f32, 0.0];
            (0..20).map(|id| Pose::from_translation(step(id))).collect()
        })
        .collect();
    let mut frame = |poses: &Vec<Pose>| {
        ids.iter().zip(poses).for_each(|(&id, &pose)| scene.set_pose(id, pose).unwrap());
        scene.any().unwrap();
        scene.count().unwrap();
        scene.all().unwrap();
        scene.contacts().unwrap();
        let _ = scene.visit(|_| ControlFlow::Continue(())).unwrap();
    };
    // The first round grows the buffers to the largest frame.
    frames.iter().for_each(&mut frame);
    assert_eq!(allocations(|| frames.iter().for_each(&mut frame)), 0);
}

#[test]
fn bodies_that_come_and_go_leave_nothing_behind() {
    let ball = Arc::new(model(&sphere(8)));
    let mut scene = SceneQuery::new();
    for _ in 0..2 {
        scene.add(ball.clone(), Pose::IDENTITY).unwrap();
    }
    // From now on they are known to meet.
    assert!(!scene.all().unwrap().is_empty());
    let mut round = || {
        let ids = [4.0, 8.0]
            .map(|x| scene.add(ball.clone(), Pose::from_translation([x, 0.0, 0.0])).unwrap());
        assert!(scene.any().unwrap().is_some());
        ids.into_iter().for_each(|id| drop(scene.remove(id).unwrap()));
    };
    (0..4).for_each(|_| round());
    assert_eq!(allocations(|| (0..1000).for_each(|_| round())), 0);
}

#[test]
fn the_second_frame_of_a_scene_allocates_nothing() {
    let ball = Arc::new(model(&sphere(8)));
    let mut scene = SceneQuery::new();
    let ids: Vec<_> = (0..20).map(|_| scene.add(ball.clone(), Pose::IDENTITY).unwrap()).collect();
    // Farther apart each time, so that less is found.
    let mut found = [0.3, 0.31].map(|step| {
        let mut hits = 0;
        let count = allocations(|| {
            for (i, &id) in ids.iter().enumerate() {
                scene.set_pose(id, Pose::from_translation([step * i as f32, 0.0, 0.0])).unwrap();
            }
            hits = scene.all().unwrap().len();
            scene.contacts().unwrap();
        });
        (hits, count)
    });
    found.reverse();
    let [(fewer, none), (hits, some)] = found;
    assert!(0 < fewer && fewer <= hits && some > 0 && none == 0, "{found:?}");
}
