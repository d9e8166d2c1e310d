//! A game's loop: entities move, a scene follows, and each frame tells who touches whom.
//!
//! `cargo run --example game_loop --features glam033`. The types are those of bevy_math 0.20, which gives out glam 0.33.

use glam033::{Affine3A, Quat, Vec3};
use pfront::{BodyId, BodyOptions, Error, Groups, Model, Pose, SceneQuery};

/// A thing in the game; `pfront` knows its body only.
struct Entity {
    name: &'static str,
    transform: Affine3A,
    /// The way that it takes in a frame.
    velocity: Vec3,
    body: BodyId,
}

/// The groups of this game, a bit each.
const GROUND: u32 = 0b001;
const CARS: u32 = 0b010;
const CAMERA: u32 = 0b100;

fn main() -> Result<(), Error> {
    // Many bodies may share one mesh and its BVH, so the model is made once.
    let cube = std::sync::Arc::new(cube()?);
    let (mut scene, mut entities) = (SceneQuery::new(), Vec::new());
    let mut spawn = |name, size: Vec3, at: Vec3, velocity, groups| {
        let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, at);
        // The way back from a body to its entity: its index, or `Entity::to_bits` of bevy.
        let user_data = entities.len() as u64;
        let options = BodyOptions { groups, user_data, ..BodyOptions::default() };
        let body = scene.add_with(cube.clone(), Pose::from(transform), options)?;
        entities.push(Entity { name, transform, velocity, body });
        Ok::<_, Error>(body)
    };
    // Cars meet everything but the camera, which may fly through all.
    let groups = |memberships, filter| Groups { memberships, filter };
    let (ground, vehicle) = (groups(GROUND, CARS), groups(CARS, GROUND | CARS));
    spawn("road", Vec3::new(50.0, 0.1, 5.0), Vec3::ZERO, Vec3::ZERO, ground)?;
    spawn("wall", Vec3::new(0.2, 2.0, 5.0), Vec3::X * 4.0, Vec3::ZERO, ground)?;
    let car = spawn("car", Vec3::new(2.0, 0.5, 1.0), Vec3::Y * 0.7, Vec3::X, vehicle)?;
    let wheel = spawn("wheel", Vec3::splat(0.3), Vec3::new(0.6, 0.35, 0.4), Vec3::X, vehicle)?;
    spawn("camera", Vec3::splat(0.1), Vec3::Y * 0.7, Vec3::X, groups(CAMERA, 0))?;
    scene.ignore(car, wheel, true)?; // They overlap by design.

    let mut meetings = Vec::new();
    for frame in 0..5 {
        // First the game moves what it wants, and the scene is told.
        for entity in &mut entities {
            entity.transform = Affine3A::from_translation(entity.velocity) * entity.transform;
            scene.set_pose(entity.body, Pose::from(entity.transform))?;
        }
        // Then one call finds all pairs of triangles that meet.
        scene.update()?;
        // The hits of two bodies stand side by side; the scene may be looked into meanwhile.
        for of_two in scene.hits().chunk_by(|x, y| x.bodies == y.bodies) {
            let entity =
                |id| Ok::<_, Error>(&entities[scene.body(id)?.options().user_data as usize]);
            let [a, b] = of_two[0].bodies;
            let names = [entity(a)?.name, entity(b)?.name];
            println!("frame {frame}: {names:?} meet in {} pairs", of_two.len());
            meetings.push((frame, names));
        }
    }
    // The front of the car is at x = frame + 2, the face of the wall at 3.9.
    assert_eq!(meetings[0], (2, ["wall", "car"]));
    Ok(())
}

/// A cube of side 1: corner i is at the upper end of x, y and z where bits 0, 1 and 2 of i are set.
fn cube() -> Result<Model, Error> {
    let corners = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 }));
    let quads =
        [[4, 6, 2, 0], [3, 7, 5, 1], [1, 5, 4, 0], [6, 7, 3, 2], [2, 3, 1, 0], [5, 7, 6, 4]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Model::new(corners.collect(), triangles.collect())
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
