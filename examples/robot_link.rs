//! A robot arm that is asked about between its poses: it jumps over a sheet of metal, and grazes another that only its turn reaches. Both are found,
//! with the link and the time.
//!
//! `cargo run --example robot_link`
//!
//! `SceneQuery::first_impact` asks about the way from pose to pose, on which corners go in straight lines. Corners of a link turn: one at the
//! distance r from an axis, which turns by θ, is up to r θ²/8 away from its line, and each joint on the way to it adds as much. So
//! it is asked what comes within that distance, and no contact is missed. Half a step has a quarter of it, so that the
//! time of a contact is found by halves.

use pfront::{BodyId, Error, Model, Pose64, SceneQuery};

/// In millimetres, as all lengths.
const LINKS: [f64; 2] = [400.0, 300.0];
const HALF_WIDTH: f64 = 10.0;
/// Joint angles at the start and at the end; each joint turns at constant speed.
const FROM: [f64; 2] = [0.9, -0.5];
const TO: [f64; 2] = [-0.55, 0.45];
/// Steps of the trajectory, of a fiftieth of a second.
const STEPS: usize = 15;
const SECONDS: f64 = STEPS as f64 / 50.0;
/// A contact is told when the link is at most twice as near.
const NEAR: f64 = 0.01;

fn main() -> Result<(), Error> {
    let mut scene = SceneQuery::new();
    let mut sheet = |from, to| scene.add(block(from, to)?, Pose64::IDENTITY);
    // Both are a millimetre thick.
    let shelf = sheet([640.0, -100.0, 155.0], [720.0, 100.0, 156.0])?;
    let wall = sheet([699.6, -100.0, -100.0], [700.6, 100.0, 100.0])?;
    let mut links = Vec::new();
    for length in LINKS {
        // A link begins in its joint and reaches along x.
        let link = block([0.0, -HALF_WIDTH, -HALF_WIDTH], [length, HALF_WIDTH, HALF_WIDTH])?;
        links.push(scene.add(link, Pose64::IDENTITY)?);
    }
    scene.ignore(links[0], links[1], true)?;

    let mut met = Vec::new();
    for step in 0..STEPS {
        let [start, end] = [step, step + 1].map(|step| step as f64 / STEPS as f64);
        assert!(!touches(&mut scene, &links, end)?, "no pose shows a contact");
        // Straight lines alone miss what only the turn reaches.
        place(&mut scene, &links, start)?;
        let straight = scene.first_impact(&poses(&links, end))?;
        let Some((bodies, way)) = contact(&mut scene, &links, [start, end])? else {
            assert!(straight.is_none());
            continue;
        };
        let link = links.iter().position(|&link| link == bodies[1]).unwrap_or_default() + 1;
        let sheet = if bodies[0] == shelf { "shelf" } else { "wall" };
        let millis = 1e3 * SECONDS * way;
        println!(
            "link {link} meets the {sheet} after {millis:.1} ms, between poses {step} and {}",
            step + 1
        );
        // Not yet then, but soon.
        assert!(!touches(&mut scene, &links, way)?);
        assert!(touches(&mut scene, &links, way + 0.05 / STEPS as f64)?);
        met.push((bodies, straight.is_some()));
    }
    assert_eq!(met, [([shelf, links[1]], true), ([wall, links[1]], false)]);
    Ok(())
}

/// Whether the arm touches anything after a part of the way, from 0 to 1.
fn touches(scene: &mut SceneQuery, links: &[BodyId], way: f64) -> Result<bool, Error> {
    scene.within(0.0)?;
    place(scene, links, way)?;
    Ok(scene.any()?.is_some())
}

/// The first contact between two parts of the way: the bodies, and a part of the way before it.
fn contact(
    scene: &mut SceneQuery,
    links: &[BodyId],
    [start, end]: [f64; 2],
) -> Result<Option<([BodyId; 2], f64)>, Error> {
    let deviation = deviation(end - start);
    // The sheets do not turn.
    scene.within((deviation + NEAR) as f32)?;
    place(scene, links, start)?;
    let Some((hit, impact)) = scene.first_impact(&poses(links, end))? else { return Ok(None) };
    if deviation < NEAR {
        return Ok(Some((hit.bodies, start + impact.from * (end - start))));
    }
    let middle = start.midpoint(end);
    match contact(scene, links, [start, middle])? {
        None => contact(scene, links, [middle, end]),
        first => Ok(first),
    }
}

/// The farthest that a corner of the arm can be from its straight line in a part of the way.
fn deviation(part: f64) -> f64 {
    let (mut angle, mut sum) = (0.0, 0.0);
    for (k, length) in LINKS.iter().enumerate() {
        angle += part * (TO[k] - FROM[k]);
        sum += length.hypot(HALF_WIDTH) * angle * angle / 8.0;
    }
    sum
}

/// Moves every link to where the joints put it.
fn place(scene: &mut SceneQuery, links: &[BodyId], way: f64) -> Result<(), Error> {
    poses(links, way).into_iter().try_for_each(|(link, pose)| scene.set_pose(link, pose))
}

/// The links, each with where the joints put it.
fn poses(links: &[BodyId], way: f64) -> Vec<(BodyId, Pose64)> {
    let (mut angle, mut joint) = (0.0_f64, [0.0; 3]);
    let pose = |(k, &link): (usize, &BodyId)| {
        angle += FROM[k] + way * (TO[k] - FROM[k]);
        let (sin, cos) = (-0.5 * angle).sin_cos();
        let pose = Pose64::from_rotation_translation([0.0, sin, 0.0, cos], joint);
        joint = [joint[0] + LINKS[k] * angle.cos(), 0.0, joint[2] + LINKS[k] * angle.sin()];
        (link, pose)
    };
    links.iter().enumerate().map(pose).collect()
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
