//! Several threads that ask a model which does not fit yet.

use super::{SIDE, bumpy, certified, model, shifted};
#[cfg(feature = "threads")]
use pfront::{Executor, SelfQuery};
use std::sync::Barrier;

#[test]
fn many_threads_ask_at_once() {
    let soup = bumpy(SIDE);
    let mut model = model(&soup);
    assert!(certified(&model).contains(&true));
    for round in 0..200 {
        let few = round % 3 == 0;
        let moved = shifted(&soup, 0.001 * round as f32, |i| !few || i % SIDE as usize > 20);
        model.set_positions_unfitted(&moved).unwrap();
        let mut expected = model.clone();
        expected.fit();
        let start = Barrier::new(4);
        std::thread::scope(|scope| {
            for thread in 0..4 {
                let (model, expected, start) = (&model, &expected, &start);
                scope.spawn(move || {
                    start.wait();
                    let copy = (thread == 0).then(|| model.clone());
                    let model = copy.as_ref().unwrap_or(model);
                    if thread == 1 {
                        assert_eq!(certified(model), certified(expected));
                    }
                    assert_eq!(model.bvh().nodes(), expected.bvh().nodes());
                    assert_eq!(certified(model), certified(expected));
                    assert_eq!(model.sphere(), expected.sphere());
                    assert!(model.bytes() > 0 && model.stamp() == expected.stamp());
                });
            }
        });
    }
}

/// A worker that waits must not be waited for: in a pool of few, many ask, each from within other work.
#[cfg(feature = "threads")]
#[test]
fn workers_of_a_pool_ask_at_once() {
    let soup = bumpy(SIDE);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let mut model = model(&soup);
    for round in 0..100 {
        let moved = shifted(&soup, 0.001 * round as f32, |_| true);
        model.set_positions_unfitted(&moved).unwrap();
        let expected = SelfQuery::new().count(&model.clone()).unwrap();
        let model = &model;
        pool.scope(|scope| {
            for _ in 0..12 {
                scope.spawn(move |_| {
                    let mut query = SelfQuery::new().on(&Executor::threads(3));
                    assert_eq!(query.count(model).unwrap(), expected);
                });
            }
        });
    }
}
