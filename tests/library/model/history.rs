//! Any sequence of moves, fits, questions and clones.

use super::{SIDE, assert_fits, bumpy, model};
#[cfg(feature = "threads")]
use pfront::Executor;
use pfront::{Model, SelfQuery};
use proptest::prelude::*;
#[cfg(feature = "threads")]
use std::sync::LazyLock;

#[cfg(feature = "threads")]
static EXECUTOR: LazyLock<Executor> = LazyLock::new(|| Executor::threads(4));

/// A change to a model.
#[derive(Clone, Debug)]
enum Event {
    /// Vertices `first`, `first + step` and so on, `count` of them, go up and aside by so much.
    Move {
        first: usize,
        step: usize,
        count: usize,
        by: f32,
        how: How,
    },
    Fit(How),
    AskTree,
    AskCertificates,
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
        1 => Just(Event::AskCertificates),
        1 => Just(Event::Clone),
    ]
}

fn happen(model: &mut Model, event: &Event) {
    match *event {
        Event::Move { first, step, count, by, how } => {
            let mut positions = model.mesh().positions().unwrap().to_vec();
            positions.iter_mut().skip(first).step_by(step).take(count).for_each(|p| {
                p[0] += by;
                p[2] += by;
            });
            let (before, same) = (model.stamp(), positions == model.mesh().positions().unwrap());
            match how {
                How::Unfitted => model.set_positions_unfitted(&positions),
                #[cfg(feature = "threads")]
                How::Threads => EXECUTOR.refit(model, &positions),
                _ => model.set_positions(&positions),
            }
            .unwrap();
            assert_eq!(model.mesh().positions().unwrap(), positions);
            assert_eq!(model.stamp() == before, same);
            assert_eq!(model.stamp().positions() == before.positions(), same);
            assert_eq!(model.stamp().mesh(), before.mesh());
        }
        Event::Fit(How::Unfitted) => {}
        Event::Fit(_) => model.fit(),
        Event::AskTree => model.bvh().assert_well_formed(),
        Event::AskCertificates => _ = model.certificates(),
        Event::Clone => *model = model.clone(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_history_leaves_what_fits(events in prop::collection::vec(event(), 1..25)) {
        let mut model = model(&bumpy(SIDE));
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
        let own = SelfQuery::new().all(&model).unwrap().to_vec();
        let mesh = model.mesh();
        let fresh = Model::new(mesh.positions().unwrap().to_vec(), mesh.triangles().to_vec()).unwrap();
        assert_eq!(own, SelfQuery::new().all(&fresh).unwrap());
    }
}
