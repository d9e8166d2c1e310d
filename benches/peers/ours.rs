//! pfront: exact, on one thread.

use super::work::{Finder, Work, model};
use pfront::{PairQuery, SceneQuery, SelfQuery};

/// All hits. Those within one mesh include triangles that share a vertex.
pub(crate) fn all(work: &Work) -> Finder<'_> {
    match work.meshes.len() {
        1 => within(work),
        2 => between(work),
        _ => among(work),
    }
}

/// The first hit of two bodies.
pub(crate) fn first(work: &Work) -> Finder<'_> {
    let [a, b] = [0, 1].map(|i| model(&work.meshes[i]));
    let mut query = PairQuery::new();
    Box::new(move |frame, found| {
        let hit = query.any(&a, &b, &work.pose(frame, 1)).unwrap();
        found.extend(hit.map(|pair| ([0, 1], pair)));
    })
}

fn between(work: &Work) -> Finder<'_> {
    let [a, b] = [0, 1].map(|i| model(&work.meshes[i]));
    let mut query = PairQuery::new();
    Box::new(move |frame, found| {
        let pairs = query.all(&a, &b, &work.pose(frame, 1)).unwrap();
        found.extend(pairs.iter().map(|&pair| ([0, 1], pair)));
    })
}

fn within(work: &Work) -> Finder<'_> {
    let mut model = model(&work.meshes[0]);
    let mut query = SelfQuery::new();
    Box::new(move |frame, found| {
        model.set_positions(work.shape(frame, 0)).unwrap();
        found.extend(query.all(&model).unwrap().iter().map(|&pair| ([0; 2], pair)));
    })
}

fn among(work: &Work) -> Finder<'_> {
    let mut query = SceneQuery::new();
    let bodies = work.meshes.iter().enumerate();
    let ids: Vec<_> =
        bodies.map(|(i, mesh)| query.add(model(mesh), work.pose(0, i)).unwrap()).collect();
    Box::new(move |frame, found| {
        for (i, &id) in ids.iter().enumerate() {
            query.set_pose(id, work.pose(frame, i)).unwrap();
        }
        for of_two in query.all().unwrap().chunk_by(|x, y| x.bodies == y.bodies) {
            let bodies = of_two[0].bodies.map(|id| ids.binary_search(&id).unwrap() as u32);
            found.extend(of_two.iter().map(|hit| (bodies, hit.pair)));
        }
    })
}
