//! Cases of rigid bodies: two, or many in a box.

use super::case::Frame;
use super::recipe::{Built, Motion, Recipe, Scale, by_factors};
use crate::player::Objects;
use anyhow::Result;
use glam::{DAffine3, DQuat, DVec3};
use pfront::{BuildOptions, Model, Pose};
use pfront_testkit::rng::{ChaCha8Rng, RngExt};
use pfront_testkit::scenes::{Kind, Scene, TriMesh, icosphere, torus_knot};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Mean number of bodies whose bounding spheres overlap that of one: from, to.
const NEIGHBOURS: [f64; 2] = [0.1, 8.0];
/// Different models of a scene, of which the largest is four times the smallest.
const MODELS: usize = 3;
/// Triangles of the train of gears, which it does not go below by much.
const GEARS: usize = 149_000;

fn bodies(recipe: &Recipe, scale: &Scale) -> usize {
    by_factors(2, scale.bodies, recipe.bodies)
}

/// Triangles of two bodies together, or of the body in the middle of a scene.
fn triangles(recipe: &Recipe, scale: &Scale) -> usize {
    match recipe.kind {
        Kind::Pair => by_factors(2, scale.triangles, recipe.size),
        _ => {
            by_factors(1, (scale.triangles / bodies(recipe, scale)).clamp(1, 100_000), recipe.size)
        }
    }
}

fn neighbours(recipe: &Recipe) -> f64 {
    let [least, most] = NEIGHBOURS;
    least * (most / least).powf(recipe.density)
}

/// Seconds that a frame takes one thread, at a guess that is seldom too low.
pub(super) fn seconds(recipe: &Recipe, scale: &Scale) -> f64 {
    let triangles = triangles(recipe, scale) as f64;
    match (recipe.kind, recipe.motion) {
        (Kind::Pair, Motion::Apart) => 1e-7,
        (Kind::Pair, _) => 40e-9 * triangles,
        (_, Motion::Gears) => 20e-9 * scale.triangles.min(GEARS) as f64,
        (_, motion) => {
            let bodies = bodies(recipe, scale) as f64;
            let pairs = 0.5 * bodies * neighbours(recipe);
            let moving = if matches!(motion, Motion::Still | Motion::Few) { 0.02 } else { 1.0 };
            moving * (0.5e-6 * bodies + pairs * (1e-6 + 10e-9 * triangles))
        }
    }
}

/// Two bodies, of which the second moves.
pub(super) fn pair(
    recipe: &Recipe,
    scale: &Scale,
    frames: usize,
    random: &mut ChaCha8Rng,
) -> Result<Built> {
    let triangles = triangles(recipe, scale);
    if recipe.motion == Motion::Gears {
        return gears("worm-gear", triangles, Kind::Pair, frames, random);
    }
    // Up to one half they are alike, from there on unequal up to a thousand times.
    let share = 0.5 * 1e-3_f64.powf((2.0 * recipe.bodies - 1.0).max(0.0));
    let second = ((triangles as f64 * share).round() as usize).max(1);
    let first = (triangles - second).max(1);
    let models = vec![body(first, 1.0, random)?, body(second, 1.0, random)?];
    let (toward, turned, axis) = (direction(random), turn(random), direction(random));
    let period = random.random_range(3..12);
    let place = |frame: usize| {
        let time = frame as f64;
        let turning = |rate: f64| DQuat::from_axis_angle(axis, rate * time) * turned;
        let (rate, distance) = match recipe.motion {
            Motion::Apart => (0.02, 2.4),
            Motion::Slow => (1e-4, 1.0 - 1e-4 * time),
            Motion::Passing => (0.02, 4.0 * (time + 0.5) / frames as f64 - 2.0),
            Motion::Meeting => (0.01, if frame / period % 2 == 1 { 0.3 } else { 2.2 }),
            Motion::Teleporting => {
                let to = direction(random) * random.random_range(0.3..1.7);
                return pose(turn(random), to);
            }
            Motion::Still | Motion::Few | Motion::Gears => (0.0, 1.0),
        };
        pose(turning(rate), toward * distance + toward.any_orthonormal_vector() * 0.1)
    };
    Ok(Built {
        class: format!("two bodies, {}", recipe.motion.name()),
        frames: (0..frames).map(place).map(|pose| Frame::Poses(vec![(1, pose)])).collect(),
        objects: Objects { kind: Kind::Pair, models },
    })
}

/// Many bodies, which sway about their places.
pub(super) fn scene(
    recipe: &Recipe,
    scale: &Scale,
    frames: usize,
    random: &mut ChaCha8Rng,
) -> Result<Built> {
    if recipe.motion == Motion::Gears {
        return gears("epicyclic", scale.triangles.min(GEARS), Kind::Many, frames, random);
    }
    let (bodies, triangles) = (bodies(recipe, scale), triangles(recipe, scale));
    let mut kinds = Vec::new();
    for k in 0..MODELS {
        let share = 2_f64.powi(k as i32 - 1);
        let triangles = (share * triangles as f64).round().max(1.0) as usize;
        kinds.push(body(triangles, share.powf(0.3), random)?);
    }
    let models = (0..bodies).map(|_| kinds[random.random_range(0..MODELS)].clone()).collect();
    let side = (bodies as f64 * 8.0 * 4.0 / 3.0 * PI / neighbours(recipe)).cbrt();
    let mut places: Vec<_> = (0..bodies).map(|_| Place::new(side, random)).collect();
    let period = random.random_range(3..12);
    let moving = match recipe.motion {
        Motion::Still => 0,
        Motion::Few => bodies.div_ceil(100),
        _ => bodies,
    };
    let moves = |frame: usize| {
        let is_apart = recipe.motion == Motion::Meeting && frame / period % 2 == 1;
        let spread = if is_apart { 3.0 } else { 1.0 };
        // In the first frame all bodies are placed.
        let moving = if frame == 0 { bodies } else { moving };
        let place = |body: usize| {
            if recipe.motion == Motion::Teleporting {
                places[body] = Place::new(side, random);
            }
            (body, places[body].pose(frame, spread))
        };
        Frame::Poses((0..moving).map(place).collect())
    };
    Ok(Built {
        frames: (0..frames).map(moves).collect(),
        class: format!("{bodies} bodies, {}", recipe.motion.name()),
        objects: Objects { kind: Kind::Many, models },
    })
}

/// A built-in scene of gears, from any frame on.
fn gears(
    name: &str,
    triangles: usize,
    kind: Kind,
    frames: usize,
    random: &mut ChaCha8Rng,
) -> Result<Built> {
    let scene = Scene::by_name(name, Some(triangles))?;
    let start = random.random_range(0..scene.frames());
    let mut rows = Vec::new();
    let placed = (start..start + frames).map(|frame| {
        scene.poses(frame, &mut rows);
        Frame::Poses(rows.iter().map(|&rows| Pose::new(rows)).enumerate().collect())
    });
    let frames = placed.collect();
    let models: Vec<_> = scene.meshes.iter().cloned().map(model).collect::<Result<_>>()?;
    let models = scene.objects.iter().map(|&mesh| models[mesh].clone()).collect();
    Ok(Built { class: name.to_owned(), objects: Objects { kind, models }, frames })
}

struct Place {
    middle: DVec3,
    sway: DVec3,
    phase: f64,
    turned: DQuat,
    axis: DVec3,
}

impl Place {
    fn new(side: f64, random: &mut ChaCha8Rng) -> Self {
        let mut along = || side * random.random_range(-0.5..0.5);
        let middle = DVec3::new(along(), along(), along());
        Self {
            middle,
            sway: 0.3 * direction(random),
            phase: random.random_range(-PI..PI),
            turned: turn(random),
            axis: direction(random),
        }
    }

    fn pose(&self, frame: usize, spread: f64) -> Pose {
        let time = frame as f64;
        let turn = DQuat::from_axis_angle(self.axis, 0.01 * time) * self.turned;
        pose(turn, spread * self.middle + self.sway * (self.phase + 0.05 * time).sin())
    }
}

/// A body of about so many triangles within `radius`: loose triangles, a ball, or a bumpy torus knot.
fn body(triangles: usize, radius: f64, random: &mut ChaCha8Rng) -> Result<Arc<Model>> {
    let (mut mesh, reach) = match triangles {
        ..20 => (loose(triangles, random), 2.0),
        20..400 => (icosphere(triangles), 1.0),
        _ if random.random() => (icosphere(triangles), 1.0),
        _ => (torus_knot(triangles), 1.4),
    };
    let scale = (radius / reach) as f32;
    mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
    model(mesh)
}

fn loose(triangles: usize, random: &mut ChaCha8Rng) -> TriMesh {
    let mut corners =
        |middle: DVec3| [(); 3].map(|()| (middle + direction(random)).as_vec3().into());
    let middles: Vec<_> =
        (0..triangles).map(|i| DVec3::X * (i as f64 / triangles as f64)).collect();
    TriMesh {
        positions: middles.into_iter().flat_map(&mut corners).collect(),
        triangles: (0..triangles as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    }
}

/// Builds a mesh's BVH on all threads.
pub(super) fn model(mesh: TriMesh) -> Result<Arc<Model>> {
    let model = Model::new_with_threads(mesh.positions, mesh.triangles, BuildOptions::default())?;
    // Found at the first question otherwise, by whichever plan comes first.
    let _ = model.sphere();
    Ok(Arc::new(model))
}

/// A direction, uniform on the sphere.
fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    let z: f64 = random.random_range(-1.0..1.0);
    let (sin, cos) = random.random_range(-PI..PI).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// A turn about a random axis by any angle.
fn turn(random: &mut ChaCha8Rng) -> DQuat {
    DQuat::from_axis_angle(direction(random), random.random_range(0.0..TAU))
}

/// Rounded once.
fn pose(turn: DQuat, translation: DVec3) -> Pose {
    let affine = DAffine3::from_rotation_translation(turn, translation);
    let (rows, t) = (affine.matrix3.transpose(), translation);
    let row = |r: DVec3, t: f64| [r.x as f32, r.y as f32, r.z as f32, t as f32];
    Pose::new([row(rows.x_axis, t.x), row(rows.y_axis, t.y), row(rows.z_axis, t.z)])
}
