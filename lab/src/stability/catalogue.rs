//! The scenes by name.

use super::limit::Bound;
use super::scene::{Scene, Step};
use super::shapes::{chain, grid, needles, wedge};
use anyhow::Result;
use pfront::Pose;
use pfront_testkit::scenes::icosphere;

type Scenes = Result<Vec<Scene>>;

/// Frames of the still and of the swaying scene before they are judged: the depth of the starting front takes
/// some frames to suit the scene, and a swing some to be damped.
pub(super) const SETTLING: usize = 20;
/// Frames in which the swaying scene comes back to where it was.
pub(super) const PERIOD: usize = 16;

/// Two spheres that move by 0.05 % of their radius a frame; the folded sheet.
pub(super) fn coherent() -> Scenes {
    let (sphere, frames) = (icosphere(20_000), 8);
    let along = (0..frames).map(|i| {
        let x = i as f32;
        let here = pose(0.001 * x, [0.3 + 0.0005 * x, 0.1, 0.0]);
        Step { what: "motion", bound: after_first(i, Bound::Coherent), a_from_b: here }
    });
    let spheres = Scene::two("spheres", &sphere, &sphere, along)?;
    let sheet =
        Scene::sheet("sheet", 8_000, 60, alike("motion", Bound::Coherent, Pose::IDENTITY, frames))?;
    Ok(vec![spheres, sheet])
}

/// Boxes without volume.
pub(super) fn flat() -> Scenes {
    let (flat, other) = (grid(60, |_, _| 0.0), grid(47, |_, _| 0.0));
    let steps = grid(40, |x, _| (8.0 * x).floor() / 8.0);
    let at = |what, x| {
        let here = Pose::from_translation([x, 0.0, 0.0]);
        anew(what, Bound::Even, (0..4).map(move |_| here))
    };
    Ok(vec![
        Scene::two("coplanar", &flat, &other, at("coplanar", 0.3))?,
        Scene::two("touching", &flat, &other, at("along a line", 1.0))?,
        Scene::two("stairs", &flat, &steps, at("flat on steps", 0.0))?,
    ])
}

/// Jumps between places where the same spheres overlap otherwise.
pub(super) fn teleport() -> Scenes {
    let places = [("start", [0.8, 0.0]), ("teleport", [-0.5, 0.9]), ("and back", [0.8, 0.0])];
    let course = places.into_iter().take(2);
    let steps = course.flat_map(|(what, at)| anew(what, Bound::Even, moving(at)));
    let sphere = icosphere(20_000);
    Ok(vec![Scene::two("teleport", &sphere, &sphere, steps)?])
}

/// Contact that ends from one frame to the next, and begins.
pub(super) fn onset_and_loss() -> Scenes {
    let start = anew("start", Bound::Even, moving([-0.5, 0.9]));
    // With nothing to do there is nothing to be estimated.
    let loss = moving([-3.0, 0.0]);
    let loss = loss.map(|here| Step { what: "loss", bound: Bound::Even, a_from_b: here });
    let onset = anew("onset", Bound::Even, moving([0.0, 1.1]));
    let sphere = icosphere(20_000);
    Ok(vec![Scene::two("onset-and-loss", &sphere, &sphere, start.chain(loss).chain(onset))?])
}

/// A tree that is a chain, with itself.
pub(super) fn skewed() -> Scenes {
    Ok(vec![Scene::two("chain", &chain(), &chain(), scarce("chain"))?])
}

/// One triangle against 20,000, and the other way round.
pub(super) fn one_against_many() -> Scenes {
    let (sphere, wedge) = (icosphere(20_000), wedge());
    let one = Scene::two("one-of-b", &sphere, &wedge, scarce("one of B"))?;
    Ok(vec![one, Scene::two("one-of-a", &wedge, &sphere, scarce("one of A"))?])
}

/// Fewer BVTT nodes than workers.
pub(super) fn few_nodes() -> Scenes {
    let small = icosphere(80);
    Ok(vec![Scene::two("few", &small, &small, scarce("few"))?])
}

/// A mesh and its double.
pub(super) fn identical() -> Scenes {
    let sphere = icosphere(8_000);
    let steps = alike("identical", Bound::Coherent, Pose::IDENTITY, 4);
    Ok(vec![Scene::two("identical", &sphere, &sphere, steps)?])
}

/// A small ball within a large one.
pub(super) fn contained() -> Scenes {
    let steps = alike("contained", Bound::Coherent, half(), 4);
    Ok(vec![Scene::two("contained", &icosphere(8_000), &icosphere(2_000), steps)?])
}

/// 200 frames in which nothing moves.
pub(super) fn still() -> Scenes {
    let sphere = icosphere(8_000);
    let steps = alike("still", Bound::Coherent, here(), SETTLING + 200);
    Ok(vec![Scene::two("still", &sphere, &sphere, steps)?])
}

/// A body that sways about a place, 1 % of its radius to either side.
pub(super) fn swaying() -> Scenes {
    let sphere = icosphere(8_000);
    let steps = (0..SETTLING + 3 * PERIOD).map(|i| {
        let phase = std::f32::consts::TAU * (i % PERIOD) as f32 / PERIOD as f32;
        let a_from_b = pose(0.3, [0.6 + 0.01 * phase.sin(), 0.1, 0.0]);
        Step { what: "swaying", bound: after_first(i, Bound::Coherent), a_from_b }
    });
    Ok(vec![Scene::two("swaying", &sphere, &sphere, steps)?])
}

/// Two bundles of 700 needles: all 490,000 pairs of triangle boxes overlap, as in the mesh pair Generic_Twin_7081.
pub(super) fn twin() -> Scenes {
    let steps = (0..2).map(|i| {
        let a_from_b = Pose::from_translation([0.0005 * i as f32, 0.0, 0.0]);
        Step { what: "twin", bound: after_first(i, Bound::Coherent), a_from_b }
    });
    Ok(vec![Scene::two("twin", &needles(700, 0.0), &needles(700, 1.0), steps)?])
}

fn here() -> Pose {
    pose(0.3, [0.6, 0.1, 0.0])
}

/// Half as large.
fn half() -> Pose {
    Pose::new([[0.5, 0.0, 0.0, 0.1], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]])
}

/// Turned about z, then moved.
fn pose(turn: f32, [x, y, z]: [f32; 3]) -> Pose {
    let (sin, cos) = turn.sin_cos();
    Pose::new([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, z]])
}

/// From a place on, along x.
fn moving([x, y]: [f32; 2]) -> impl Iterator<Item = Pose> {
    (0..2).map(move |i| pose(0.3, [x + 0.0005 * i as f32, y, 0.1]))
}

/// Nothing is asked of a first frame.
fn after_first(i: usize, bound: Bound) -> Bound {
    if i == 0 { Bound::None } else { bound }
}

/// The same frame again and again.
fn alike(
    what: &'static str,
    bound: Bound,
    a_from_b: Pose,
    frames: usize,
) -> impl Iterator<Item = Step> {
    (0..frames).map(move |i| Step { what, bound: after_first(i, bound), a_from_b })
}

/// Something new, which has to be estimated, and what follows.
fn anew(
    what: &'static str,
    bound: Bound,
    poses: impl Iterator<Item = Pose>,
) -> impl Iterator<Item = Step> {
    poses.enumerate().map(move |(i, a_from_b)| Step {
        what,
        bound: if i == 0 { Bound::Estimated } else { bound },
        a_from_b,
    })
}

/// Where there is little to divide.
fn scarce(what: &'static str) -> impl Iterator<Item = Step> {
    alike(what, Bound::Scarce, pose(0.2, [0.05, 0.0, 0.0]), 4)
}
