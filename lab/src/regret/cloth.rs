//! Cases of a mesh that deforms and is asked about itself: the folded sheet of [`pfront_testkit::scenes`].

use super::case::{Built, Moved};
use super::scale::{Scale, by_factors};
use super::shapes::model;
use crate::player::Objects;
use anyhow::Result;
use glam::Vec3;
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::{Kind, Scene};

/// How it moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// Open, without contact.
    Open,
    /// As the scene does: pleats meet and wander.
    Folding,
    /// A fiftieth as fast.
    Slow,
    /// Set to where it is already.
    Still,
    /// Only its first fiftieth, as far as vertices are numbered, follows the scene.
    Corner,
    /// Some frames open, some folded, and so on.
    Meeting,
    /// At any moment of the scene, each frame another.
    Anywhere,
}

impl Motion {
    pub(super) const ALL: [Self; 7] = {
        use Motion::*;
        [Open, Folding, Slow, Still, Corner, Meeting, Anywhere]
    };
}

/// The parameters of a case, drawn at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cloth {
    pub(super) motion: Motion,
    /// How large: 0 to 1, by factors.
    pub(super) size: f64,
}

/// Frames of the scene that lie folded.
const FOLDED: std::ops::Range<usize> = 45..110;

impl Cloth {
    fn triangles(&self, scale: &Scale) -> usize {
        by_factors(8, scale.triangles, self.size)
    }

    /// Seconds that a frame takes one thread, at a guess that is seldom too low.
    pub(super) fn seconds(&self, scale: &Scale) -> f64 {
        200e-9 * self.triangles(scale) as f64
    }

    pub(super) fn build(
        &self,
        scale: &Scale,
        frames: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<Built> {
        let mut scene = Scene::by_name("sheet", Some(self.triangles(scale)))?;
        let first = random.random_range(FOLDED);
        let period = random.random_range(3..12);
        let at = |moment: usize| {
            let mut positions = Vec::new();
            scene.positions(moment, &mut positions);
            positions
        };
        // Motions that do not go through the scene stay at the first of these or go from it towards the second.
        let ends = [at(first), at(first + 1)];
        let positions = |frame: usize, random: &mut ChaCha8Rng| match self.motion {
            Motion::Open => at(frame % 4),
            Motion::Folding => at(first + frame),
            Motion::Slow => between(&ends, frame as f32 / 50.0),
            Motion::Still => ends[0].clone(),
            Motion::Corner => {
                let mut positions = ends[0].clone();
                let moving = positions.len().div_ceil(50);
                positions[..moving].copy_from_slice(&at(first + frame)[..moving]);
                positions
            }
            Motion::Meeting if (frame / period).is_multiple_of(2) => at(frame % 4),
            Motion::Meeting => at(first + frame),
            Motion::Anywhere => at(random.random_range(0..scene.frames())),
        };
        let frames = (0..frames).map(|frame| Moved::Positions(positions(frame, random))).collect();
        Ok(Built {
            class: format!("{:?}: sheet", self.motion),
            objects: Objects {
                kind: Kind::SelfMesh,
                models: vec![model(scene.meshes.swap_remove(0))?],
            },
            frames,
        })
    }
}

/// Part of the way, or beyond.
fn between([from, to]: &[Vec<[f32; 3]>; 2], share: f32) -> Vec<[f32; 3]> {
    let moved =
        |(p, q): (&[f32; 3], &[f32; 3])| Vec3::from(*p).lerp(Vec3::from(*q), share).to_array();
    from.iter().zip(to).map(moved).collect()
}
