//! pfront: exact, on one thread.

use super::work::{Finder, Hit, Work, model};
use pfront::{BodyId, Model, PairQuery, SceneQuery, SelfQuery};

/// All hits. Hits within one mesh include triangles that share a vertex.
pub(crate) fn all(work: &Work) -> Box<dyn Finder + '_> {
    match work.meshes.len() {
        1 => Box::new(SelfFinder { work, model: model(&work.meshes[0]), query: SelfQuery::new() }),
        2 => pair(work),
        _ => Box::new(SceneFinder::new(work)),
    }
}

/// The first hit of two bodies.
pub(crate) fn first(work: &Work) -> Box<dyn Finder + '_> {
    let [a, b] = [0, 1].map(|i| model(&work.meshes[i]));
    let mut query = PairQuery::new();
    Box::new(move |frame: usize, found: &mut Vec<Hit>| {
        let hit = query.any(&a, &b, work.pose(frame, 1)).unwrap();
        found.extend(hit.map(|pair| ([0, 1], pair)));
    })
}

fn pair(work: &Work) -> Box<dyn Finder + '_> {
    let [a, b] = [0, 1].map(|i| model(&work.meshes[i]));
    let mut query = PairQuery::new();
    Box::new(move |frame: usize, found: &mut Vec<Hit>| {
        let pairs = query.all(&a, &b, work.pose(frame, 1)).unwrap();
        found.extend(pairs.iter().map(|&pair| ([0, 1], pair)));
    })
}

struct SelfFinder<'w> {
    work: &'w Work,
    model: Model,
    query: SelfQuery,
}

impl Finder for SelfFinder<'_> {
    fn place(&mut self, frame: usize) {
        self.model.set_positions(self.work.shape(frame, 0)).unwrap();
    }

    fn find(&mut self, _: usize, found: &mut Vec<Hit>) {
        found.extend(self.query.all(&self.model).unwrap().iter().map(|&pair| ([0; 2], pair)));
    }
}

struct SceneFinder<'w> {
    work: &'w Work,
    query: SceneQuery,
    ids: Vec<BodyId>,
}

impl<'w> SceneFinder<'w> {
    fn new(work: &'w Work) -> Self {
        let mut query = SceneQuery::new();
        let bodies = work.meshes.iter().enumerate();
        let ids =
            bodies.map(|(i, mesh)| query.add(model(mesh), work.pose(0, i)).unwrap()).collect();
        Self { work, query, ids }
    }
}

impl Finder for SceneFinder<'_> {
    fn place(&mut self, frame: usize) {
        for (i, &id) in self.ids.iter().enumerate() {
            self.query.set_pose(id, self.work.pose(frame, i)).unwrap();
        }
    }

    fn find(&mut self, _: usize, found: &mut Vec<Hit>) {
        for of_two in self.query.all().unwrap().chunk_by(|x, y| x.bodies == y.bodies) {
            let bodies = of_two[0].bodies.map(|id| self.ids.binary_search(&id).unwrap() as u32);
            found.extend(of_two.iter().map(|hit| (bodies, hit.pair)));
        }
    }
}
