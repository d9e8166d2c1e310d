//! A scene of the matrix: what moves, how, and what is asked of each frame.

use super::limit::Bound;
use anyhow::Result;
use pfront::{Model, Pose};
use pfront_testkit::MeshData;

/// One frame to come.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The name of what happens in it.
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
    pub(super) actors: Actors,
    pub(super) steps: Vec<Step>,
}

#[derive(Debug)]
pub(super) enum Actors {
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
}
