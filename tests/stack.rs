//! The documented bound on the stack of a walk, with what a thread itself takes.

use pfront::{Model, Pose};
use pfront_core::bvtt::{self, Query};
use pfront_testkit::scenes::icosphere;
use std::thread;

/// 29 KiB for the walk, the rest for the thread.
const STACK: usize = 32 << 10;

#[test]
fn a_walk_fits_a_small_stack() {
    let ball = icosphere(1280);
    // Twice the ball in one place: coplanar, touching, and left open by all but integers.
    let mut triangles = ball.triangles.clone();
    let n = ball.positions.len() as u32;
    triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + n)));
    let positions = [&ball.positions[..], &ball.positions].concat();
    let model = Model::new(positions, triangles).unwrap();
    let turned = Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 0.8, -0.6, 0.0], [0.0, 0.6, 0.8, 0.0]]);
    let counts = thread::scope(|scope| {
        let walk = || {
            let own = bvtt::SelfBvtt::new(model.bvh()).count();
            let placed = bvtt::PosedBvh::new(model.bvh(), &turned).unwrap();
            [own, bvtt::PairBvtt::in_world(placed, placed).count()]
        };
        thread::Builder::new().stack_size(STACK).spawn_scoped(scope, walk).unwrap().join().unwrap()
    });
    assert!(counts.iter().all(|&count| count > 1280), "{counts:?}");
}
