//! A clash check: which parts of an assembly run into each other, where, and in how many pairs of triangles.
//!
//! `cargo run --example clash`. Touching counts; parts that are meant to touch or to overlap are left out by name.

use pfront::{Error, Model, Pose, SceneQuery};
use std::collections::HashMap;
use std::sync::Arc;

fn main() -> Result<(), Error> {
    // Lengths are in millimetres. A model may be used more than once: both bolts are one.
    let bolt = Arc::new(prism(24, 4.0, 30.0)?);
    let parts = [
        ("base", Arc::new(prism(4, 60.0, 10.0)?), Pose::from_translation([0.0; 3])),
        ("shaft", Arc::new(prism(48, 8.0, 80.0)?), lying([0.0, 0.0, 20.0])),
        ("bracket", Arc::new(prism(6, 10.0, 25.0)?), Pose::from_translation([-35.0, 0.0, 17.6])),
        ("left bolt", bolt.clone(), Pose::from_translation([-25.0, 20.0, 0.0])),
        ("right bolt", bolt, Pose::from_translation([25.0, 3.0, 8.0])),
    ];
    let meant = [("base", "left bolt"), ("base", "right bolt"), ("bracket", "shaft")];

    // Names stay with the caller; a scene knows bodies by their ids, which ascend in the order of adding.
    let mut scene = SceneQuery::new();
    let (mut ids, mut names) = (HashMap::new(), HashMap::new());
    for (name, model, pose) in parts {
        let id = scene.add(model, pose)?;
        ids.insert(name, id);
        names.insert(id, name);
    }
    for (a, b) in meant {
        scene.ignore(ids[a], ids[b], true)?;
    }

    // A hit is a pair of triangles of two bodies; its contact is the segment in which they meet, in the world.
    let contacts = scene.contacts()?;
    let mut clashes = Vec::new();
    for of_two in contacts.chunk_by(|(x, _), (y, _)| x.bodies == y.bodies) {
        let [a, b] = of_two[0].0.bodies.map(|id| names[&id]);
        println!("{a} meets {b} in {} pairs of triangles:", of_two.len());
        let segments = of_two.iter().map(|(_, contact)| contact.segment);
        let length: f32 = segments.clone().map(|[p, q]| distance(p, q)).sum();
        let ends = segments.flatten();
        let low = ends.clone().fold([f32::INFINITY; 3], |m, p| [0, 1, 2].map(|k| m[k].min(p[k])));
        let high = ends.fold([f32::NEG_INFINITY; 3], |m, p| [0, 1, 2].map(|k| m[k].max(p[k])));
        println!("  a line of {length:.1} mm, from {low:.1?} to {high:.1?}");
        clashes.push([a, b]);
    }
    assert_eq!(clashes, [["shaft", "right bolt"]]);
    Ok(())
}

/// With its axis along x: a quarter turn about y, as a quaternion.
fn lying(position: [f32; 3]) -> Pose {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    Pose::from_rotation_translation([0.0, half, 0.0, half], position)
}

fn distance(p: [f32; 3], q: [f32; 3]) -> f32 {
    [0, 1, 2].map(|k| (p[k] - q[k]).powi(2)).iter().sum::<f32>().sqrt()
}

/// A closed prism about the z axis: vertices 0 and 1 are the middles of its ends, then both ends of each edge.
fn prism(sides: u32, radius: f32, height: f32) -> Result<Model, Error> {
    let turn = std::f32::consts::TAU / sides as f32;
    let ends = |x: f32, y: f32| [[x, y, -0.5 * height], [x, y, 0.5 * height]];
    let edge = |i| (turn * i as f32).sin_cos();
    let rim = (0..sides).map(edge).flat_map(|(sin, cos)| ends(radius * cos, radius * sin));
    let side = |i| {
        let (a, b) = (2 + 2 * i, 2 + 2 * ((i + 1) % sides));
        [[0, b, a], [1, a + 1, b + 1], [a, b, b + 1], [a, b + 1, a + 1]]
    };
    Model::new(ends(0.0, 0.0).into_iter().chain(rim).collect(), (0..sides).flat_map(side).collect())
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
