//! Cases of a mesh that deforms and is asked about itself: the folded sheet of the built-in scenes.

use super::bodies::model;
use super::case::Frame;
use super::recipe::{Built, Motion, Recipe, Scale, by_factors};
use crate::player::Objects;
use anyhow::Result;
use glam::Vec3;
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::{Kind, Scene};

/// Frames of the scene that lie folded.
const FOLDED: std::ops::Range<usize> = 45..110;

fn triangles(recipe: &Recipe, scale: &Scale) -> usize {
    by_factors(8, scale.triangles, recipe.size)
}

/// Seconds that a frame takes one thread, at a guess that is seldom too low.
pub(super) fn seconds(recipe: &Recipe, scale: &Scale) -> f64 {
    200e-9 * triangles(recipe, scale) as f64
}

pub(super) fn build(
    recipe: &Recipe,
    scale: &Scale,
    frames: usize,
    random: &mut ChaCha8Rng,
) -> Result<Built> {
    let mut scene = Scene::by_name("sheet", Some(triangles(recipe, scale)))?;
    let first = random.random_range(FOLDED);
    let period = random.random_range(3..12);
    let at = |moment: usize| {
        let mut positions = Vec::new();
        scene.positions(moment, &mut positions);
        positions
    };
    // Slow motion goes a fiftieth of the way from one of these to the other.
    let ends = [at(first), at(first + 1)];
    let positions = |frame: usize, random: &mut ChaCha8Rng| match recipe.motion {
        Motion::Apart => at(frame % 4),
        Motion::Still => ends[0].clone(),
        Motion::Slow => between(&ends, frame as f32 / 50.0),
        Motion::Few => {
            let mut positions = ends[0].clone();
            let moving = positions.len().div_ceil(50);
            positions[..moving].copy_from_slice(&at(first + frame)[..moving]);
            positions
        }
        Motion::Meeting if (frame / period).is_multiple_of(2) => at(frame % 4),
        Motion::Teleporting => at(random.random_range(0..scene.frames())),
        Motion::Passing | Motion::Meeting | Motion::Gears => at(first + frame),
    };
    let frames = (0..frames).map(|frame| Frame::Positions(positions(frame, random))).collect();
    let models = vec![model(scene.meshes.swap_remove(0))?];
    Ok(Built {
        class: format!("sheet, {}", recipe.motion.name()),
        objects: Objects { kind: Kind::SelfMesh, models },
        frames,
    })
}

/// Part of the way, or beyond.
fn between([from, to]: &[Vec<[f32; 3]>; 2], share: f32) -> Vec<[f32; 3]> {
    let moved =
        |(p, q): (&[f32; 3], &[f32; 3])| Vec3::from(*p).lerp(Vec3::from(*q), share).to_array();
    from.iter().zip(to).map(moved).collect()
}
