//! A robot arm that stays 20 mm away from the cell that it works in: before each step the distance of every link is asked for, and
//! how near it is decides how far the step goes.
//!
//! `cargo run --example robot_arm`. A body knows by itself how far away all others are; links next to each other are left out.

use pfront::{BodyId, Error, Model, Pose64, SceneQuery};

/// In millimetres, as all lengths.
const CLEARANCE: f32 = 20.0;
/// The arm slows down from here on.
const CAUTIOUS: f32 = 120.0;
const LINKS: [f64; 3] = [400.0, 300.0, 150.0];
/// Joint angles from where the arm starts to where it should go, through a shelf.
const FROM: [f64; 3] = [1.3, -0.6, -0.4];
const TO: [f64; 3] = [-0.35, 0.2, 0.1];

fn main() -> Result<(), Error> {
    let mut scene = SceneQuery::new();
    // The cell: a table, a wall behind the arm, a shelf that it reaches towards.
    for (from, to) in [
        ([-500.0, -300.0, -250.0], [900.0, 300.0, -200.0]),
        ([-540.0, -300.0, -250.0], [-500.0, 300.0, 1000.0]),
        ([500.0, -250.0, 60.0], [800.0, 250.0, 90.0]),
    ] {
        scene.add(block(from, to)?, Pose64::IDENTITY)?;
    }
    let mut links = Vec::new();
    for length in LINKS {
        // A link begins in its joint and reaches along x.
        links.push(scene.add(block([0.0, -30.0, -30.0], [length, 30.0, 30.0])?, Pose64::IDENTITY)?);
    }
    for two in links.windows(2) {
        scene.ignore(two[0], two[1], true)?;
    }

    // The part of the way that is done, from 0 to 1.
    let (mut way, mut steps, mut nearest) = (0.0, 0, f64::INFINITY);
    let stop = loop {
        place(&mut scene, &links, way)?;
        let gap = clearance(&mut scene, &links)?;
        nearest = nearest.min(gap);
        if steps % 40 == 0 {
            println!("{:3.0} % of the way, {gap:5.1} mm to the nearest", 100.0 * way);
        }
        if way >= 1.0 {
            break false;
        }
        // No point of the arm moves farther than all links are long, times the angles; so this step keeps the clearance.
        let turns: f64 = FROM.iter().zip(TO).map(|(from, to)| (to - from).abs()).sum();
        let room = gap - f64::from(CLEARANCE);
        let step = (room / (turns * LINKS.iter().sum::<f64>())).min(0.01);
        if step < 1e-5 {
            break true;
        }
        (way, steps) = ((way + step).min(1.0), steps + 1);
    };
    println!(
        "stopped after {steps} steps and {:.1} % of the way, {nearest:.2} mm away",
        100.0 * way
    );
    assert!(stop && nearest > f64::from(CLEARANCE) && nearest < f64::from(CLEARANCE) + 1.0);
    Ok(())
}

/// The least that the smallest distance of the arm can be, or what is far enough.
fn clearance(scene: &mut SceneQuery, links: &[BodyId]) -> Result<f64, Error> {
    let mut least = f64::from(CAUTIOUS);
    for &link in links {
        // All that is farther does not matter, and is not looked for.
        if let Some((_, gap)) = scene.distance_below(link, CAUTIOUS)? {
            least = least.min(gap.interval[0]);
        }
    }
    Ok(least)
}

/// Moves every link to where the joints put it.
fn place(scene: &mut SceneQuery, links: &[BodyId], way: f64) -> Result<(), Error> {
    let (mut angle, mut joint) = (0.0_f64, [0.0; 3]);
    for (k, &link) in links.iter().enumerate() {
        angle += FROM[k] + way * (TO[k] - FROM[k]);
        let (sin, cos) = angle.sin_cos();
        let half = -0.5 * angle;
        let turn = [0.0, half.sin(), 0.0, half.cos()];
        scene.set_pose(link, Pose64::from_rotation_translation(turn, joint))?;
        joint = [joint[0] + LINKS[k] * cos, 0.0, joint[2] + LINKS[k] * sin];
    }
    Ok(())
}

/// A box from one corner to the other.
fn block(from: [f64; 3], to: [f64; 3]) -> Result<Model, Error> {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { from[k] } else { to[k] });
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Model::from_f64((0..8).map(corner).collect(), triangles.collect())
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
