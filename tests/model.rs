//! A model that deforms: whatever is refitted, when and by whom, is what a whole refit would give, and a
//! stamp says what the model holds.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::core::build;
use pfront::{BuildOptions, Model, SelfQuery};
use pfront_oracle::generate::soup::{Soup, sheet};
use proptest::prelude::*;
use std::sync::Barrier;

const SIDE: u32 = 24;

fn shape() -> Soup {
    sheet(SIDE, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos())
}

fn model(soup: &Soup) -> Model {
    let options = BuildOptions { leaf_size: 3 };
    Model::with_options(soup.positions.clone(), soup.triangles.clone(), options).unwrap()
}

/// That all the model knows of itself is what one finds who looks at everything.
fn assert_fits(model: &Model) {
    let bvh = model.bvh();
    let mut nodes = bvh.nodes().to_vec();
    build::refit(bvh.mesh(), &mut nodes, bvh.order());
    assert_eq!(nodes, bvh.nodes());
    let (positions, triangles) = (model.mesh().positions(), model.mesh().triangles());
    let fresh = Model::new(positions.to_vec(), triangles.to_vec()).unwrap();
    assert_eq!(model.fans(), fresh.fans());
    assert!(model.sphere().is_some_and(|sphere| {
        let reach = |p: &[f32; 3]| (0..3).map(|k| (p[k] - sphere.centre[k]).powi(2)).sum::<f32>();
        positions.iter().all(|p| reach(p).sqrt() <= sphere.radius * 1.00001)
    }));
}

/// What happens to a model.
#[derive(Clone, Debug)]
enum Event {
    /// Vertices `first`, `first + step` and so on, `count` of them, go up by so much.
    Move {
        first: usize,
        step: usize,
        count: usize,
        by: f32,
        how: How,
    },
    Fit(How),
    AskTree,
    AskFans,
    Clone,
}

#[derive(Clone, Copy, Debug)]
enum How {
    Unfitted,
    OneThread,
    Threads,
}

fn how() -> impl Strategy<Value = How> {
    prop_oneof![Just(How::Unfitted), Just(How::OneThread), Just(How::Threads)]
}

fn event() -> impl Strategy<Value = Event> {
    let few = (0..SIDE as usize * 20, 1..40_usize, 0..12_usize, -0.3_f32..0.3, how());
    let any = (0..SIDE as usize * 20, 1..9_usize, 0..700_usize, -0.3_f32..0.3, how());
    let moved = |(first, step, count, by, how)| Event::Move { first, step, count, by, how };
    prop_oneof![
        4 => few.prop_map(moved),
        1 => any.prop_map(moved),
        1 => how().prop_map(Event::Fit),
        2 => Just(Event::AskTree),
        1 => Just(Event::AskFans),
        1 => Just(Event::Clone),
    ]
}

fn happen(model: &mut Model, event: &Event) {
    match *event {
        Event::Move { first, step, count, by, how } => {
            let mut positions = model.mesh().positions().to_vec();
            positions.iter_mut().skip(first).step_by(step).take(count).for_each(|p| p[2] += by);
            let (before, same) = (model.stamp(), positions == model.mesh().positions());
            match how {
                How::Unfitted => model.set_positions_unfitted(&positions),
                #[cfg(feature = "threads")]
                How::Threads => model.set_positions_with_threads(&positions),
                _ => model.set_positions(&positions),
            }
            .unwrap();
            assert_eq!(model.mesh().positions(), positions);
            assert_eq!(model.stamp() == before, same);
            assert_eq!(model.stamp().positions() == before.positions(), same);
            assert_eq!(model.stamp().mesh(), before.mesh());
        }
        Event::Fit(How::Unfitted) => {}
        #[cfg(feature = "threads")]
        Event::Fit(How::Threads) => model.fit_with_threads(),
        Event::Fit(_) => model.fit(),
        Event::AskTree => model.bvh().assert_well_formed(),
        Event::AskFans => assert_eq!(model.fans().len(), model.mesh().positions().len()),
        Event::Clone => *model = model.clone(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_history_leaves_what_fits(events in prop::collection::vec(event(), 1..25)) {
        let mut model = model(&shape());
        for event in &events {
            // By the stamp, what is asked of one can be answered from the other.
            let twin = model.clone();
            assert_eq!(twin.stamp(), model.stamp());
            let order = matches!(event, Event::AskTree).then(|| twin.bvh().order().to_vec());
            happen(&mut model, event);
            if let Some(order) = order {
                assert_eq!(twin.stamp(), model.stamp());
                assert_eq!(model.bvh().order(), order);
                assert_eq!(model.bvh().nodes(), twin.bvh().nodes());
            }
            assert_fits(&model.clone());
        }
        assert_fits(&model);
        let own = SelfQuery::new().all(&model).to_vec();
        let mesh = model.mesh();
        let fresh = Model::new(mesh.positions().to_vec(), mesh.triangles().to_vec()).unwrap();
        assert_eq!(own, SelfQuery::new().all(&fresh));
    }
}

/// The sheet after some of its vertices have gone up.
fn lifted(soup: &Soup, by: f32, which: impl Fn(usize) -> bool) -> Vec<[f32; 3]> {
    let up = |(i, p): (usize, &[f32; 3])| [p[0], p[1], if which(i) { p[2] + by } else { p[2] }];
    soup.positions.iter().enumerate().map(up).collect()
}

#[test]
fn few_moves_are_refitted_by_a_table_and_many_without() {
    let soup = shape();
    let mut model = model(&soup);
    let bytes = model.bytes();
    model.set_positions(&lifted(&soup, 0.1, |_| true)).unwrap();
    assert_eq!(model.bytes(), bytes);
    model.set_positions(&lifted(&soup, 0.1, |i| i > 20)).unwrap();
    assert!(model.bytes() > bytes + model.bvh().nodes().len() * 8);
    assert_fits(&model);
}

#[test]
fn a_stamp_says_what_is_the_same() {
    let soup = shape();
    let mut model = model(&soup);
    let (first, copy) = (model.stamp(), model.clone());
    let parts = |model: &Model| {
        let stamp = model.stamp();
        (stamp.mesh() == first.mesh(), stamp.tree() == first.tree())
    };
    assert_ne!(self::model(&soup).stamp(), first, "of a mesh built twice");
    assert!(model.set_positions(&[[f32::NAN; 3]; 1]).is_err());
    assert!(model.set_positions_unfitted(&lifted(&soup, f32::NAN, |i| i > 99)).is_err());
    model.set_positions(&soup.positions).unwrap();
    model.set_positions_unfitted(&soup.positions).unwrap();
    model.fit();
    assert_eq!(model.stamp(), first, "nothing has changed");
    let moved = lifted(&soup, 0.1, |_| true);
    model.set_positions_unfitted(&moved).unwrap();
    let second = model.stamp();
    assert!(second != first && parts(&model) == (true, true));
    let later = model.clone();
    assert!(later.bvh().nodes() != copy.bvh().nodes() && later.stamp() == second);
    model.fit();
    assert_eq!(model.stamp(), second, "a refit changes nothing that a stamp tells");
    assert_eq!(model.bvh().nodes(), later.bvh().nodes());
    model.set_positions(&soup.positions).unwrap();
    assert!(![first, second].contains(&model.stamp()), "nobody knows that it is back");
    assert_eq!(copy.stamp(), first);
    let zeros = lifted(&soup, 0.0, |_| true).iter().map(|p| p.map(|x| x - x)).collect::<Vec<_>>();
    model.set_positions(&zeros).unwrap();
    let third = model.stamp();
    model.set_positions(&zeros.iter().map(|p| p.map(|x| -x)).collect::<Vec<_>>()).unwrap();
    assert_ne!(model.stamp(), third, "zeros with their signs");
}

/// The sheet torn into triangles that lie about at random, far apart or not.
fn torn() -> (Model, Vec<[f32; 3]>) {
    let soup = shape();
    let vertices = soup.triangles.as_flattened();
    let corners: Vec<_> = vertices.iter().map(|&v| soup.positions[v as usize]).collect();
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let thrown = |i: usize| [1, 7, 13].map(|by| ((i / 3 * by * 37) % 101) as f32 * 0.05);
    let scattered = corners.iter().enumerate().map(|(i, p)| {
        let to = thrown(i);
        [0, 1, 2].map(|k| p[k] + to[k])
    });
    let scattered = scattered.collect();
    (Model::new(corners, triangles).unwrap(), scattered)
}

#[test]
fn a_worn_tree_is_rebuilt_and_the_stamp_says_so() {
    let (model, scattered) = torn();
    let fresh = Model::new(scattered.clone(), model.mesh().triangles().to_vec()).unwrap();
    let (mut eager, mut lazy, mut fitted) = (model.clone(), model.clone(), model.clone());
    eager.set_positions(&scattered).unwrap();
    assert_eq!(eager.bvh().nodes(), fresh.bvh().nodes());
    assert_ne!(eager.stamp().tree(), model.stamp().tree());

    fitted.set_positions_unfitted(&scattered).unwrap();
    assert_eq!(fitted.stamp().tree(), model.stamp().tree());
    fitted.fit();
    assert_eq!(fitted.bvh().nodes(), fresh.bvh().nodes());
    assert_ne!(fitted.stamp().tree(), model.stamp().tree());

    lazy.set_positions_unfitted(&scattered).unwrap();
    assert_eq!(lazy.bvh().order(), model.bvh().order());
    assert_eq!(lazy.stamp().tree(), model.stamp().tree());
    let mut again = scattered;
    again[0][0] += 1.0;
    let fresh = Model::new(again.clone(), model.mesh().triangles().to_vec()).unwrap();
    lazy.set_positions_unfitted(&again).unwrap();
    let announced = lazy.stamp();
    assert_ne!(announced.tree(), model.stamp().tree());
    assert_eq!(lazy.clone().bvh().nodes(), fresh.bvh().nodes());
    assert_eq!(lazy.bvh().nodes(), fresh.bvh().nodes());
    lazy.fit();
    assert_eq!(lazy.stamp(), announced);
    assert_fits(&lazy);
}

#[test]
fn many_threads_ask_at_once() {
    let soup = shape();
    let mut model = model(&soup);
    assert!(!model.fans().is_empty());
    for round in 0..200 {
        let few = round % 3 == 0;
        let moved = lifted(&soup, 0.001 * round as f32, |i| !few || i % SIDE as usize > 20);
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
                        assert_eq!(model.fans(), expected.fans());
                    }
                    assert_eq!(model.bvh().nodes(), expected.bvh().nodes());
                    assert_eq!(model.fans(), expected.fans());
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
    let soup = shape();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let mut model = model(&soup);
    for round in 0..100 {
        let moved = lifted(&soup, 0.001 * round as f32, |_| true);
        model.set_positions_unfitted(&moved).unwrap();
        let expected = SelfQuery::new().count(&model.clone());
        let model = &model;
        pool.scope(|scope| {
            for _ in 0..12 {
                scope.spawn(move |_| {
                    assert_eq!(SelfQuery::new().with_threads(3).count(model), expected);
                });
            }
        });
    }
}
