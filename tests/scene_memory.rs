//! Memory of scenes: what is missing is an error after which a scene answers rightly, and bodies that have gone take none.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::{BodyId, Error, Executor, Model, Pose, SceneQuery};
use pfront_testkit::rng::{RngExt, seeded};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ops::ControlFlow;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicIsize, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An allocator that has no blocks of some size or more.
struct Limited;

static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);
static HELD: AtomicIsize = AtomicIsize::new(0);

#[expect(unsafe_code, reason = "an allocator can be limited only by being one")]
// SAFETY: every call goes to the system allocator as it came, or is refused.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() >= LIMIT.load(Relaxed) {
            return null_mut();
        }
        HELD.fetch_add(layout.size() as isize, Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size >= LIMIT.load(Relaxed) {
            return null_mut();
        }
        HELD.fetch_add(size as isize - layout.size() as isize, Relaxed);
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(old, layout, size) }
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as isize, Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Limited = Limited;

/// One test at a time: the limit is that of all threads.
fn alone() -> impl Drop {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The result of a call while no block has so many bytes.
fn limited<R>(bytes: usize, call: impl FnOnce() -> R) -> R {
    LIMIT.store(bytes, Relaxed);
    let result = call();
    LIMIT.store(usize::MAX, Relaxed);
    result
}

fn executors() -> Vec<Executor> {
    #[cfg(feature = "threads")]
    return vec![Executor::sequential(), Executor::threads(2)];
    #[cfg(not(feature = "threads"))]
    vec![Executor::sequential()]
}

/// Triangles of which almost all meet.
fn heap(triangles: u32) -> Arc<Model> {
    let mut rng = seeded(7);
    let mut positions = Vec::new();
    for _ in 0..triangles {
        // The centre of each is near the origin.
        let [p, q] = [0; 2].map(|_| [0; 3].map(|_| rng.random_range(-9.0..9.0_f32)));
        let r = [0, 1, 2].map(|k| rng.random_range(-0.01..0.01) - p[k] - q[k]);
        positions.extend([p, q, r]);
    }
    let triangles = (0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Arc::new(Model::new(positions, triangles).unwrap())
}

/// A triangle whose box every other of a small shift overlaps, though it meets none.
fn tile() -> Arc<Model> {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    Arc::new(Model::new(corners, vec![[0, 1, 2]]).unwrap())
}

#[test]
fn lists_that_do_not_fit_are_errors_and_later_answers_are_right() {
    let _alone = alone();
    let model = heap(200);
    let moved = |x: f32| Pose::from_translation([1e-3 * x, 0.0, 0.0]);
    for executor in executors() {
        let mut errors = 0;
        let mut scene = SceneQuery::new().on(&executor);
        let [_, b, _] = [0.0, 1.0, 2.0].map(|x| scene.add(model.clone(), moved(x)).unwrap());
        for (frame, limit) in (16..=21).map(|bits| 1 << bits).enumerate() {
            let step = |scene: &mut SceneQuery, i: usize| {
                scene.set_pose(b, moved((4 * frame + i) as f32)).unwrap();
            };
            let mut fresh = SceneQuery::new();
            step(&mut scene, 0);
            for body in scene.bodies() {
                fresh.add(body.model().clone(), body.pose()).unwrap();
            }
            type Verb = fn(&mut SceneQuery) -> Result<usize, Error>;
            let verbs: [Verb; 5] = [
                |scene| scene.all().map(<[_]>::len),
                |scene| scene.contacts().map(<[_]>::len),
                |scene| scene.contacts_f64().map(|list| list.len()),
                |scene| scene.intersecting_bodies().map(|list| list.len()),
                |scene| scene.count().map(|count| count as usize),
            ];
            for verb in verbs {
                let expected = verb(&mut fresh).unwrap();
                match limited(limit, || verb(&mut scene)) {
                    Err(Error::Memory { needed }) => {
                        errors += 1;
                        // Lists grow by doubling.
                        assert!(2 * needed >= limit, "{needed} {limit}");
                        if errors % 2 == 0 {
                            assert_eq!(verb(&mut scene), Ok(expected));
                        }
                    }
                    answer => assert_eq!(answer, Ok(expected)),
                }
            }
            assert_eq!(scene.contacts().unwrap(), fresh.contacts().unwrap());
            assert_eq!(scene.hits(), fresh.all().unwrap());
        }
        // How many depends on which thread found how much.
        assert!(errors >= 5, "{errors}");
    }
}

#[test]
fn a_broad_phase_that_does_not_fit_is_an_error() {
    let _alone = alone();
    let tile = tile();
    for executor in executors() {
        let mut scene = SceneQuery::new().on(&executor);
        for i in 0..900 {
            scene.add(tile.clone(), Pose::from_translation([0.0, 0.0, 1e-4 * i as f32])).unwrap();
        }
        // 8 bytes for each of some 400,000 pairs of bodies.
        let count = limited(1 << 20, || scene.count());
        assert!(matches!(count, Err(Error::Memory { .. })), "{count:?}");
        let pairs = limited(1 << 20, || scene.intersecting_bodies());
        assert!(matches!(pairs, Err(Error::Memory { .. })), "{pairs:?}");
        let end = limited(1 << 20, || scene.visit(|_| ControlFlow::Continue(())));
        assert!(matches!(end, Err(Error::Memory { .. })), "{end:?}");
        assert_eq!(scene.count(), Ok(0));
        assert_eq!(scene.intersecting_bodies(), Ok(Vec::new()));
    }
}

#[test]
fn bodies_that_come_and_go_take_no_memory() {
    let _alone = alone();
    let tile = tile();
    for is_asked in [false, true] {
        let mut scene = SceneQuery::new();
        let still = scene.add(tile.clone(), Pose::IDENTITY).unwrap();
        let mut gone = Vec::with_capacity(1 << 17);
        let mut round = |scene: &mut SceneQuery| {
            let guests = [0; 10].map(|_| scene.add(tile.clone(), Pose::IDENTITY).unwrap());
            for guest in guests {
                scene.ignore(guest, still, true).unwrap();
                scene
                    .set_pose(still, Pose::from_translation([0.0, 0.0, gone.len() as f32]))
                    .unwrap();
                if is_asked {
                    scene.count().unwrap();
                }
                scene.remove(guest).unwrap();
                gone.push(guest);
            }
        };
        (0..100).for_each(|_| round(&mut scene));
        let before = HELD.load(Relaxed);
        (0..if is_asked { 1_000 } else { 10_000 }).for_each(|_| round(&mut scene));
        let grown = HELD.load(Relaxed) - before;
        // The runner of the tests takes some, too.
        assert!(grown < 1 << 16, "{grown} bytes");
        assert!(gone.is_sorted_by(|x, y| x < y), "no id comes again");
        for id in gone.into_iter().step_by(997) {
            assert_eq!(scene.body(id).err(), Some(Error::StaleBody { id }));
        }
        assert!(scene.ignored().next().is_none() && scene.len() == 1);
    }
}

/// Removing looks at the ignored pairs of that body only.
#[test]
fn to_remove_takes_no_longer_than_to_ignore() {
    let _alone = alone();
    let tile = tile();
    let mut scene = SceneQuery::new();
    let ids: Vec<BodyId> =
        (0..5_000).map(|_| scene.add(tile.clone(), Pose::IDENTITY).unwrap()).collect();
    let clock = Instant::now();
    for (i, a) in ids.iter().enumerate() {
        for b in ids.iter().skip(i + 1).take(40) {
            scene.ignore(*a, *b, true).unwrap();
        }
    }
    let adding = clock.elapsed();
    let clock = Instant::now();
    for id in ids {
        scene.remove(id).unwrap();
    }
    let removing = clock.elapsed();
    assert!(removing < 12 * adding, "{removing:?} after {adding:?}");
}

/// Contacts, and the pairs of the broad phase, hear the flag as traversals do.
#[test]
fn contacts_and_boxes_are_cancelled_soon() {
    let _alone = alone();
    let heap = heap(900);
    for executor in executors() {
        let flag = Arc::new(AtomicBool::new(false));
        let mut scene = SceneQuery::new().on(&executor.with_cancel(flag.clone()));
        for _ in 0..2 {
            scene.add(heap.clone(), Pose::IDENTITY).unwrap();
        }
        scene.update().unwrap();
        let hits = scene.hits().len();
        flag.store(true, Relaxed);
        assert_eq!(scene.contacts().map(<[_]>::len), Err(Error::Cancelled));
        assert_eq!(scene.contacts_f64().map(|list| list.len()), Err(Error::Cancelled));
        assert_eq!(scene.hits().len(), hits);
        flag.store(false, Relaxed);
        let late = {
            let flag = flag.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(10));
                flag.store(true, Relaxed);
                Instant::now()
            })
        };
        // Segments of 800,000 hits take longer than that.
        let contacts = scene.contacts().map(<[_]>::len);
        let delay = late.join().unwrap().elapsed();
        assert_eq!(contacts, Err(Error::Cancelled));
        assert!(delay < Duration::from_millis(300), "{delay:?}");
        flag.store(false, Relaxed);
        assert_eq!(scene.contacts().map(<[_]>::len), Ok(hits));
    }
}
