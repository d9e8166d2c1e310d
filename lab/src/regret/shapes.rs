//! Meshes of any size, from a single triangle on.

use super::case::{Built, Moved};
use crate::player::Objects;
use anyhow::Result;
use glam::{DAffine3, DQuat, DVec3};
use pfront::threads::Pool;
use pfront::{BuildOptions, Executor, Model, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::{Scene, icosphere, round, torus_knot};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The shape of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Triangles in a ball, each where it likes.
    Shards,
    /// An icosphere.
    Ball,
    /// A bumpy torus knot.
    Knot,
    /// The worm of a worm drive.
    Worm,
    /// Its wheel.
    Wheel,
    /// A folded sheet, stiff.
    Sheet,
}

impl Shape {
    /// A random shape among those that can have so many triangles.
    pub(super) fn for_size(triangles: usize, random: &mut ChaCha8Rng) -> Self {
        // The fewest each takes, and the most that make sense of it.
        let all = [
            (Self::Shards, 1, 2_000),
            (Self::Ball, 20, usize::MAX),
            (Self::Sheet, 32, usize::MAX),
            (Self::Knot, 400, usize::MAX),
            (Self::Worm, 8_000, usize::MAX),
            (Self::Wheel, 8_000, usize::MAX),
        ];
        let fitting: Vec<Self> = all
            .into_iter()
            .filter(|(_, least, most)| (*least..=*most).contains(&triangles))
            .map(|(shape, ..)| shape)
            .collect();
        fitting[random.random_range(0..fitting.len())]
    }

    /// About so many triangles, about the origin, none of which reaches farther than `radius`.
    pub(super) fn mesh(
        self,
        triangles: usize,
        radius: f64,
        random: &mut ChaCha8Rng,
    ) -> Result<MeshData> {
        // The worm takes six tenths of its drive.
        let drive = |share: f64| {
            Scene::by_name("worm-gear", Some((triangles as f64 / share).round() as usize))
        };
        let mesh = match self {
            Self::Shards => shards(triangles, random),
            Self::Ball => icosphere(triangles),
            Self::Knot => torus_knot(triangles),
            Self::Worm => drive(0.6)?.meshes.swap_remove(0),
            Self::Wheel => drive(0.4)?.meshes.swap_remove(1),
            Self::Sheet => {
                let scene = Scene::by_name("sheet", Some(triangles))?;
                let mut positions = Vec::new();
                scene.positions(60, &mut positions);
                MeshData { positions, triangles: scene.meshes[0].triangles.clone() }
            }
        };
        Ok(fitted(mesh, radius))
    }
}

/// Builds a mesh's BVH on all threads.
pub(super) fn model(mesh: MeshData) -> Result<Arc<Model>> {
    let model = Executor::from(Pool::default()).build(
        mesh.positions,
        mesh.triangles,
        BuildOptions::default(),
    )?;
    // Found at the first question otherwise, by whichever plan comes first.
    let _ = model.sphere();
    Ok(Arc::new(model))
}

/// A built-in scene of gears in about so many triangles, from any frame on.
pub(super) fn gears(
    name: &str,
    triangles: usize,
    frames: usize,
    random: &mut ChaCha8Rng,
) -> Result<Built> {
    let scene = Scene::by_name(name, Some(triangles))?;
    let start = random.random_range(0..scene.frames());
    let mut rows = Vec::new();
    let placed = (start..start + frames).map(|frame| {
        scene.poses(frame, &mut rows);
        Moved::Poses(rows.iter().map(|&rows| Pose::new(rows)).enumerate().collect())
    });
    let frames = placed.collect();
    let models: Vec<_> = scene.meshes.iter().cloned().map(model).collect::<Result<_>>()?;
    let models = scene.objects.iter().map(|&mesh| models[mesh].clone()).collect();
    Ok(Built { class: name.to_owned(), objects: Objects { kind: scene.kind(), models }, frames })
}

/// Small triangles in the unit ball.
fn shards(count: usize, random: &mut ChaCha8Rng) -> MeshData {
    let size = (count as f64).powf(-1.0 / 3.0);
    MeshData::of((0..count).map(|_| {
        let middle = direction(random) * random.random::<f64>().cbrt();
        [(); 3].map(|()| (middle + size * direction(random)).as_vec3().to_array())
    }))
}

/// Moved about the origin and scaled to a bounding radius.
fn fitted(mesh: MeshData, radius: f64) -> MeshData {
    let (middle, reach) = mesh.bounding_sphere();
    let scale = if reach > 0.0 { radius / reach } else { 1.0 };
    mesh.map(|p| ((DVec3::from(p.map(f64::from)) - middle) * scale).as_vec3().to_array())
}

/// A direction, uniform on the sphere.
pub(super) fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    let z: f64 = random.random_range(-1.0..1.0);
    let (sin, cos) = random.random_range(-PI..PI).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// A turn about a random axis by any angle.
pub(super) fn turn(random: &mut ChaCha8Rng) -> DQuat {
    DQuat::from_axis_angle(direction(random), random.random_range(0.0..TAU))
}

/// Rounded once.
pub(super) fn pose(turn: DQuat, translation: DVec3) -> Pose {
    Pose::new(round(DAffine3::from_rotation_translation(turn, translation)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::rng::seeded;

    #[test]
    fn shapes_fit_and_have_about_the_size_asked_for() {
        let random = &mut seeded(1);
        for triangles in [1, 19, 32, 500, 20_000] {
            for _ in 0..8 {
                let shape = Shape::for_size(triangles, random);
                let mesh = shape.mesh(triangles, 2.0, random).unwrap();
                let ratio = mesh.triangles.len() as f64 / triangles as f64;
                assert!((0.6..1.7).contains(&ratio), "{shape:?} of {triangles}: {ratio}");
                let reach = mesh.positions.iter().map(|p| glam::Vec3::from(*p).length());
                let reach = reach.fold(0.0, f32::max);
                assert!((reach - 2.0).abs() < 1e-5, "{shape:?}: {reach}");
                model(mesh).unwrap();
            }
        }
    }
}
