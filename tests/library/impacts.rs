//! Whether any triangles meet while two models move or one deforms, and how many: as the list of them has it, on any number of threads.

use super::scene_impacts::executors;
use pfront::{Error, Impact, Model, Motion, PairQuery, Pose, SelfQuery, TrianglePair};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{RngExt, seeded};
use pfront_testkit::shapes::{pose_rows, sheet, sphere, tangle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

type Timed = Vec<(TrianglePair, Impact)>;

fn model(soup: MeshData) -> Model {
    Model::new(soup.positions, soup.triangles).unwrap()
}

/// Compares `any` and both counts with the list. Returns how many pairs of it are proven, and how many open.
fn check(all: &Timed, any: Option<(TrianglePair, Impact)>, counts: [u64; 2]) -> [usize; 2] {
    let proven = all.iter().filter(|(_, impact)| impact.is_proven()).count();
    assert_eq!(counts, [proven as u64, all.len() as u64]);
    assert!(any.map_or(all.is_empty(), |hit| all.contains(&hit)));
    assert_eq!(any.is_some_and(|(_, impact)| impact.is_proven()), proven > 0);
    [proven, all.len() - proven]
}

#[test]
fn whether_any_and_how_many_are_those_of_the_list() {
    let mut rng = seeded(473);
    let models =
        [sphere(6), sheet(8, |u, v| 0.3 * (5.0 * u).sin() * v), tangle(20, 15, 2, &mut rng)];
    let models = models.map(model);
    // By how many pairs are proven and how many open: none, some.
    let mut kinds = [[0; 2]; 2];
    for round in 0..60 {
        let [a, b] = [0; 2].map(|_| &models[rng.random_range(0..3)]);
        let [start, end] = [0; 2].map(|_| Pose::new(pose_rows(2.0, &mut rng)));
        let (rest, moving) = (Motion::at_rest(a), Motion::new(b, start, end).unwrap());
        let positions: Vec<_> = a.mesh().shadow().iter().map(|&p| end.apply(p)).collect();
        let mut after = a.clone();
        after.set_positions(&positions).unwrap();
        let deforming = Motion::between(a, &after).unwrap();
        let within = [0.0, 0.1][round % 2];
        let all = PairQuery::new().within(within).unwrap().impacts(&rest, &moving).unwrap();
        let own = SelfQuery::new().within(within).unwrap().impacts(&deforming).unwrap();
        for executor in executors() {
            let mut query = PairQuery::new().on(&executor).within(within).unwrap();
            assert_eq!(query.impacts(&rest, &moving).unwrap(), all, "{round}");
            let any = query.any_impact(&rest, &moving).unwrap();
            let of_two = check(&all, any, query.count_impacts(&rest, &moving).unwrap());
            let mut query = SelfQuery::new().on(&executor).within(within).unwrap();
            assert_eq!(query.impacts(&deforming).unwrap(), own, "{round}");
            let any = query.any_impact(&deforming).unwrap();
            check(&own, any, query.count_impacts(&deforming).unwrap());
            assert!(query.plan().is_some(), "{round}");
            kinds[usize::from(of_two[0] > 0)][usize::from(of_two[1] > 0)] += 1;
        }
    }
    assert!(kinds[0][0] > 0 && kinds[1][0] > 0, "{kinds:?}");
}

/// Tiles that slide over each other in one plane: that they meet is open. One certain hit among them is found, wherever it is.
#[test]
fn a_certain_pair_comes_before_open_ones() {
    let tile = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    let tiles =
        |n: usize, by: f32| -> Vec<_> { (0..n).map(|i| tile(3.0 * i as f32 + by)).collect() };
    let soup = |tiles: Vec<[[f32; 3]; 3]>| {
        let triangles = (0..tiles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Model::new(tiles.concat(), triangles).unwrap()
    };
    let floor = soup(tiles(12, 0.0));
    let (start, end) = (tiles(12, -1.5), tiles(12, 1.5));
    let rest = Motion::at_rest(&floor);
    for certain in [None, Some(0), Some(5), Some(11)] {
        let (mut start, mut end) = (start.clone(), end.clone());
        if let Some(tile) = certain {
            start[tile] = start[tile].map(|[x, y, _]| [x + 1.5, y, 1.0]);
            end[tile] = end[tile].map(|[x, y, _]| [x - 1.5, y, -1.0]);
        }
        let [start, end] = [soup(start), soup(end)];
        let moving = Motion::between(&start, &end).unwrap();
        let all = PairQuery::new().impacts(&rest, &moving).unwrap();
        assert!(all.len() >= 12, "{}", all.len());
        for executor in executors() {
            let mut query = PairQuery::new().on(&executor);
            let any = query.any_impact(&rest, &moving).unwrap();
            let [proven, open] = check(&all, any, query.count_impacts(&rest, &moving).unwrap());
            assert!((proven > 0) == certain.is_some() && open > 0, "{proven} {open}");
        }
    }
}

#[test]
fn what_is_cancelled_has_no_answer() {
    let ball = model(sphere(6));
    let at = |x: f32| Pose::from_translation([x, 0.0, 0.0]);
    let (rest, moving) = (Motion::at_rest(&ball), Motion::new(&ball, at(5.0), at(-5.0)).unwrap());
    for executor in executors() {
        let flag = Arc::new(AtomicBool::new(true));
        let mut query = PairQuery::new().on(&executor.with_cancel(flag.clone()));
        assert_eq!(query.any_impact(&rest, &moving), Err(Error::Cancelled));
        assert_eq!(query.count_impacts(&rest, &moving), Err(Error::Cancelled));
        flag.store(false, Relaxed);
        assert!(query.any_impact(&rest, &moving).unwrap().is_some());
    }
}
