//! An answer or a model that does not fit into memory is an error: nothing aborts, and the same question is answered once there is
//! memory again. The allocator of these tests refuses large lists, from each of them on in turn; tasks of a pool and the
//! like, which do not grow with an answer, are not refused.

#![expect(unsafe_code, reason = "an allocator")]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use pfront::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Debug;
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

/// Smaller allocations are not refused.
const LARGE: usize = 8 << 10;

/// The number of large allocations that are still granted.
static GRANTED: AtomicI64 = AtomicI64::new(i64::MAX);

struct Refusing;

#[global_allocator]
static ALLOCATOR: Refusing = Refusing;

fn is_refused(bytes: usize) -> bool {
    bytes >= LARGE && GRANTED.fetch_sub(1, Relaxed) <= 0
}

// SAFETY: each method passes its arguments on to the system's allocator, or returns null, which says that there is no memory.
unsafe impl GlobalAlloc for Refusing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_refused(layout.size()) {
            return std::ptr::null_mut();
        }
        // SAFETY: as the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller's.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, bytes: usize) -> *mut u8 {
        if bytes > layout.size() && is_refused(bytes) {
            return std::ptr::null_mut();
        }
        // SAFETY: as the caller's.
        unsafe { System.realloc(pointer, layout, bytes) }
    }
}

/// Runs `ask` on new subjects with every number of large allocations granted, from none to as many as it needs; each time it
/// returns the error or the answer, and the answer once there is memory. Returns how often it was refused.
fn with_each_failure<S, T: PartialEq + Debug>(
    name: &str,
    subject: impl Fn() -> S,
    ask: impl Fn(&mut S) -> Result<T, Error>,
) -> usize {
    let expected = ask(&mut subject()).unwrap();
    let mut refused = 0;
    for granted in 0.. {
        let mut subject = subject();
        GRANTED.store(granted, Relaxed);
        let answer = ask(&mut subject);
        let left = GRANTED.swap(i64::MAX, Relaxed);
        match answer {
            Ok(answer) => assert!(answer == expected, "{name}, {granted} granted"),
            Err(Error::Memory { needed }) => {
                assert!(needed >= LARGE / 4 && left < granted, "{name}: {needed} bytes");
                refused += 1;
            }
            Err(error) => panic!("{name}: {error}"),
        }
        assert!(ask(&mut subject).unwrap() == expected, "{name}, asked again after {granted}");
        if left >= 0 {
            break;
        }
    }
    refused
}

/// Triangles close to each other, of which many intersect.
fn soup(seed: u32, triangles: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut state = u64::from(seed) << 32 | 0x9e37_79b9;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let origin = [0; 3].map(|_| 3.0 * random());
        positions.extend([0; 3].map(|_| origin.map(|x| x + random())));
    }
    (positions, (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn model(seed: u32) -> Model {
    let (positions, triangles) = soup(seed, 1_500);
    Model::new(positions, triangles).unwrap()
}

fn executors() -> Vec<(&'static str, Executor)> {
    #[cfg(not(feature = "threads"))]
    let threads = [];
    #[cfg(feature = "threads")]
    let threads = {
        use pfront::threads::{Pool, Schedule, Settings, rayon};
        let schedules = [("static", Schedule::Static), ("hybrid", Schedule::Hybrid)];
        schedules.map(|(name, schedule)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
            let mut pool = Pool::from(std::sync::Arc::new(pool));
            let settings = Settings { schedule, ..Settings::default() };
            // Many workers, so that parts and fronts are large lists.
            pool.workers = 300;
            (name, pool.with_settings(settings).into())
        })
    };
    [("one thread", Executor::sequential())].into_iter().chain(threads).collect()
}

/// One test, since the allocator would refuse what the program that runs tests needs for another that ends meanwhile.
#[test]
fn what_does_not_fit_into_memory_is_refused() {
    pairs_that_do_not_fit_into_memory_are_refused();
    pairs_within_a_model_that_do_not_fit_into_memory_are_refused();
    models_that_do_not_fit_into_memory_are_refused();
    models_move_with_the_memory_that_there_is();
}

fn pairs_that_do_not_fit_into_memory_are_refused() {
    let (a, b) = (model(1), model(2));
    let pose = AnyPose::F32(Pose::IDENTITY);
    for (name, executor) in executors() {
        let query = || PairQuery::new().on(&executor);
        let named = |verb: &str| format!("PairQuery::{verb} on {name}");
        assert!(
            with_each_failure(&named("all"), query, |query| {
                query.all(&a, &b, pose).map(|pairs| (pairs.len(), pairs.is_sorted()))
            }) > 3
        );
        with_each_failure(&named("count"), query, |query| query.count(&a, &b, pose));
        with_each_failure(&named("any"), query, |query| {
            query.any(&a, &b, pose).map(|pair| pair.is_some())
        });
        let contacts = |query: &mut PairQuery| query.contacts(&a, &b, pose).map(<[_]>::len);
        assert!(with_each_failure(&named("contacts"), query, contacts) > 3);
        let contacts =
            |query: &mut PairQuery| query.contacts_f64(&a, &b, pose).map(|own| own.len());
        assert!(with_each_failure(&named("contacts_f64"), query, contacts) > 3);
        let patches = |query: &mut PairQuery| query.patches(&a, &b, pose);
        assert!(with_each_failure(&named("patches"), query, patches) > 10);
        // With a history of another question.
        let asked = || {
            let mut query = query();
            query.all(&b, &b, Pose::from_translation([0.3, 0.0, 0.0])).unwrap();
            query
        };
        with_each_failure(&named("all after another"), asked, |query| {
            query.all(&a, &b, pose).map(<[_]>::len)
        });
    }
}

fn pairs_within_a_model_that_do_not_fit_into_memory_are_refused() {
    // Certificates that are not made yet.
    let subject = |executor: &Executor| (SelfQuery::new().on(executor), model(3));
    for (name, executor) in executors() {
        let subject = || subject(&executor);
        let named = |verb: &str| format!("SelfQuery::{verb} on {name}");
        type Subject = (SelfQuery, Model);
        let all = |(query, model): &mut Subject| query.all(model).map(<[_]>::len);
        assert!(with_each_failure(&named("all"), subject, all) > 3);
        let count = |(query, model): &mut Subject| query.count(model);
        with_each_failure(&named("count"), subject, count);
        let any = |(query, model): &mut Subject| query.any(model).map(|pair| pair.is_some());
        with_each_failure(&named("any"), subject, any);
        let contacts = |(query, model): &mut Subject| query.contacts(model).map(<[_]>::len);
        assert!(with_each_failure(&named("contacts"), subject, contacts) > 3);
        let contacts =
            |(query, model): &mut Subject| query.contacts_f64(model).map(|own| own.len());
        assert!(with_each_failure(&named("contacts_f64"), subject, contacts) > 3);
    }
}

/// The numbers of nodes, vertices and triangles of a model.
fn shape(model: &Model) -> (usize, [usize; 2]) {
    (model.bvh().nodes().len(), [model.mesh().vertex_count(), model.mesh().triangles().len()])
}

fn models_that_do_not_fit_into_memory_are_refused() {
    let (positions, triangles) = soup(4, 2_000);
    let wide = |p: &[f32; 3]| p.map(|x| f64::from(x) + 1e-9);
    let positions_f64: Vec<[f64; 3]> = positions.iter().map(wide).collect();
    let blob = Model::new(positions.clone(), triangles.clone()).unwrap().to_blob().unwrap();
    let given = || Some((positions.clone(), triangles.clone()));
    // The second time there is nothing left to take, so the arrays are made again where there is memory.
    let new = |arrays: &mut Option<_>| {
        let (positions, triangles) = arrays.take().or_else(given).unwrap();
        Model::new(positions, triangles).map(|model| shape(&model))
    };
    assert!(with_each_failure("new", given, new) > 1);
    let given_f64 = || Some((positions_f64.clone(), triangles.clone()));
    let from_f64 = |arrays: &mut Option<_>| {
        let (positions, triangles) = arrays.take().or_else(given_f64).unwrap();
        Model::from_f64(positions, triangles).map(|model| shape(&model))
    };
    assert!(with_each_failure("from_f64", given_f64, from_f64) > 1);
    let from_blob = |(): &mut ()| Model::from_blob(&blob).map(|model| shape(&model));
    assert!(with_each_failure("from_blob", || (), from_blob) > 1);
    let model = || Model::from_blob(&blob).unwrap();
    let to_blob = |model: &mut Model| model.to_blob().map(|bytes| bytes.len());
    assert_eq!(with_each_failure("to_blob", model, to_blob), 1);
}

fn models_move_with_the_memory_that_there_is() {
    let (positions, triangles) = soup(5, 2_000);
    let scattered: Vec<[f32; 3]> = soup(6, 2_000).0;
    let few = |positions: &[[f32; 3]]| {
        let mut moved = positions.to_vec();
        moved.iter_mut().take(30).for_each(|p| p[0] += 0.1);
        moved
    };
    let (moved, nudged) = (few(&positions), few(&scattered));
    let model = || {
        let model = Model::new(positions.clone(), triangles.clone()).unwrap();
        let _ = model.certificates();
        model
    };
    let count = SelfQuery::new();
    // Partial refits, whole ones, and a rebuild, without memory for tables and marks.
    let deform = |model: &mut Model| {
        for positions in [&moved, &positions, &scattered, &nudged, &positions].repeat(3) {
            model.set_positions(positions)?;
            model.fit();
        }
        let _ = (model.certificates(), model.sphere());
        count.clone().count(model)
    };
    with_each_failure("set_positions", model, deform);
    let wide = |positions: &[[f32; 3]]| -> Vec<[f64; 3]> {
        positions.iter().map(|p| p.map(|x| f64::from(x) + 1e-9)).collect()
    };
    let (start, end) = (wide(&positions), wide(&scattered));
    let in_f64 = || Model::from_f64(start.clone(), triangles.clone()).unwrap();
    let deform = |model: &mut Model| {
        model.set_positions(&end)?;
        count.clone().count(model)
    };
    assert!(with_each_failure("set_positions", in_f64, deform) > 1);
}
