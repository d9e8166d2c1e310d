//! Trees on a GPU that wear out are replaced: after a few frames a question takes about as many box tests as with a tree made for
//! the shape.

use crate::crosses;
use pfront::gpu::Gpu;
use pfront::{Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery};

const PARTS: u64 = 1_500;

fn parts(stride: u64, shift: f32) -> Vec<[f32; 3]> {
    crosses(PARTS, stride, shift)
}

fn model(stride: u64) -> Model {
    let triangles = (0..2 * PARTS as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Model::new(parts(stride, 0.0), triangles).unwrap()
}

/// A strip along all parts.
fn strip() -> Model {
    let length = PARTS as f32;
    let corners = vec![[0.0, -0.2, 0.15], [length, -0.2, 0.15], [length, 0.8, 0.15]];
    Model::new(corners, vec![[0, 1, 2]]).unwrap()
}

/// The box tests of the last of eight frames in which parts are where they were not when `ask` was first called; and of a
/// first frame about a model that was made so.
fn tests(mut ask: impl FnMut(&Gpu, &Executor, u64) -> Box<dyn FnMut(&[[f32; 3]])>) -> [u64; 2] {
    let gpu = Gpu::new().unwrap();
    let executor = Executor::gpu(&gpu, gpu.settings());
    [1, 701].map(|stride| {
        let mut frame = ask(&gpu, &executor, stride);
        let mut tests = 0;
        for i in 0..8 {
            let before = gpu.totals().box_tests;
            frame(&parts(701, 0.01 * i as f32));
            tests = gpu.totals().box_tests - before;
        }
        assert!(tests > 0);
        tests
    })
}

fn assert_alike([worn, new]: [u64; 2]) {
    assert!(worn <= 2 * new, "{worn} box tests, and {new} with a new tree");
}

#[test]
fn a_mesh_that_is_asked_about_itself() {
    assert_alike(tests(|_, executor, stride| {
        let (mut own, mut query) = (model(stride), SelfQuery::new().on(executor));
        assert_eq!(query.count(&own).unwrap(), PARTS);
        Box::new(move |positions| {
            query.set_positions(&mut own, positions).unwrap();
            assert_eq!(query.count(&own).unwrap(), PARTS);
        })
    }));
}

#[test]
fn a_mesh_that_is_asked_about_another() {
    assert_alike(tests(|_, executor, stride| {
        let (mut own, strip) = (model(stride), strip());
        let mut query = PairQuery::new().on(executor);
        query.count(&strip, &own, Pose::IDENTITY).unwrap();
        Box::new(move |positions| {
            own.set_positions(positions).unwrap();
            query.count(&strip, &own, Pose::IDENTITY).unwrap();
        })
    }));
}

#[test]
fn a_body_of_a_scene() {
    assert_alike(tests(|_, executor, stride| {
        let mut scene = SceneQuery::new().on(executor);
        scene.add(strip(), Pose::IDENTITY).unwrap();
        let own = scene.add(model(stride), Pose::IDENTITY).unwrap();
        scene.count().unwrap();
        Box::new(move |positions| {
            scene.set_positions(own, positions).unwrap();
            scene.count().unwrap();
        })
    }));
}

/// A mesh that keeps its shape keeps its tree.
#[test]
fn a_tree_that_does_not_wear_is_not_replaced() {
    let gpu = Gpu::new().unwrap();
    let (mut own, mut query) =
        (model(1), SelfQuery::new().on(&Executor::gpu(&gpu, gpu.settings())));
    for i in 0..30 {
        query.set_positions(&mut own, &parts(1, 0.01 * i as f32)).unwrap();
        assert_eq!(query.count(&own).unwrap(), PARTS);
    }
    assert_eq!(gpu.totals().builds, 1);
}
