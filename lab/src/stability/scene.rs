//! A scene of the matrix: what moves, how, and what is asked of each frame.

use super::limit::Bound;
use super::play::Player;
use anyhow::Result;
use pfront::pfront_core::bvtt::{PairBvtt, SelfBvtt};
use pfront::{Model, Pose, TrianglePair};
use pfront_testkit::MeshData;

/// One frame to come.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// What happens in it.
    pub what: &'static str,
    /// How far it may be out of balance.
    pub bound: Bound,
    /// Where the second mesh stands; of no account where there is one.
    pub a_from_b: Pose,
}

/// One or two meshes over some frames.
#[derive(Debug)]
pub struct Scene {
    /// The name, without spaces.
    pub name: &'static str,
    actors: Actors,
    steps: Vec<Step>,
}

#[derive(Debug)]
enum Actors {
    Two(Box<[Model; 2]>),
    /// A sheet against itself, from some frame of its own on.
    Sheet(Box<Model>, pfront_testkit::scenes::Scene, usize),
}

impl Scene {
    /// Two meshes.
    pub(super) fn two(
        name: &'static str,
        a: &MeshData,
        b: &MeshData,
        steps: impl IntoIterator<Item = Step>,
    ) -> Result<Self> {
        let [a, b] = [a, b].map(|mesh| Model::new(mesh.positions.clone(), mesh.triangles.clone()));
        let actors = Actors::Two(Box::new([a?, b?]));
        Ok(Self { name, actors, steps: steps.into_iter().collect() })
    }

    /// The folded sheet of [`pfront_testkit::scenes`] in about so many triangles, from frame `first` on.
    pub(super) fn sheet(
        name: &'static str,
        triangles: usize,
        first: usize,
        steps: impl IntoIterator<Item = Step>,
    ) -> Result<Self> {
        let sheet = pfront_testkit::scenes::Scene::by_name("sheet", Some(triangles))?;
        let MeshData { positions, triangles } = sheet.meshes[0].clone();
        let model = Model::new(positions, triangles)?;
        let actors = Actors::Sheet(Box::new(model), sheet, first);
        Ok(Self { name, actors, steps: steps.into_iter().collect() })
    }

    /// Its frames.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Shows every frame to a player.
    ///
    /// # Errors
    /// If a pose or a shape is refused, which those of the matrix are not.
    pub(super) fn play(&mut self, player: &mut Player<'_>) -> Result<()> {
        for (index, step) in self.steps.iter().enumerate() {
            match &mut self.actors {
                Actors::Two(models) => {
                    let [a, b] = &**models;
                    let query = PairBvtt::new(a.bvh(), b.bvh(), step.a_from_b)?;
                    player.frame(step, &query, || pairs(a, b, &step.a_from_b));
                }
                Actors::Sheet(model, sheet, first) => {
                    let mut positions = Vec::new();
                    sheet.positions(*first + index, &mut positions);
                    model.set_positions(&positions)?;
                    player.frame(step, &SelfBvtt::new(model.bvh()), || self_pairs(model));
                }
            }
        }
        Ok(())
    }
}

fn pairs(a: &Model, b: &Model, a_from_b: &Pose) -> Vec<TrianglePair> {
    let (a, b) = (a.mesh(), b.mesh());
    let posed: Vec<_> = b.shadow().iter().map(|&p| a_from_b.apply(p)).collect();
    sorted(pfront_testkit::oracle::pairs(a.shadow(), a.triangles(), &posed, b.triangles()))
}

fn self_pairs(model: &Model) -> Vec<TrianglePair> {
    let mesh = model.mesh();
    sorted(pfront_testkit::oracle::self_pairs(mesh.shadow(), mesh.triangles()))
}

fn sorted(pairs: Vec<(u32, u32)>) -> Vec<TrianglePair> {
    pairs.into_iter().map(|(a, b)| TrianglePair { a, b }).collect()
}
