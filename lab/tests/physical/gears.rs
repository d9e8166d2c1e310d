//! Three involute gears in a row, at any distance of their axes.
//!
//! Involutes roll on each other at any distance. At the distance a, the working pressure angle α' has
//! cos α' = a₀/a·cos α, a₀ being the distance at which the gears were cut; and if the tooth of one stands in
//! the middle of a gap of the other, each pair of flanks is apart, along their common normal, by
//!
//! g(a) = a₀·cos α·(inv α' − inv α) − I·cos α,   inv α = tan α − α,
//!
//! in every phase, since base circles have radii of a₀·cos α together, on which the arc between flanks is
//! what the gap along the normal is. I is how much thicker than their gaps the teeth were cut.
//!
//! The meshes are chords of the flanks, which are convex, so that they miss some of each: up to the sagitta
//! c²/8ρ for a chord c where the radius of curvature is ρ.

use pfront::{BodyId, Model, Pose, SceneQuery};
use pfront_testkit::scenes::Scene;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Teeth of the gears in the epicyclic train's meshes 1, 2 and 3: two suns and the planet between them.
const TEETH: [f64; 3] = [24.0, 30.0, 36.0];
/// Pressure angle, in radians, and I, in modules, as `pfront_testkit::scenes` cuts them.
const PRESSURE: f64 = 20.0 * PI / 180.0;
const INTERFERENCE: f64 = 0.03;
/// Phases over a pitch of the first gear.
const PHASES: u32 = 48;
/// What facets may miss of two flanks together: chords of at most 0.45, of flanks that are no more curved
/// than 1/3 where one pair of teeth touches at least.
const FACETS: f64 = 2.0 * 0.45 * 0.45 / (8.0 * 3.0);

/// Cut for axes at these distances, with gears of module 1.
fn cut_for(pair: usize) -> f64 {
    f64::midpoint(TEETH[pair], TEETH[pair + 1])
}

fn inv(angle: f64) -> f64 {
    angle.tan() - angle
}

/// g for a pair of gears whose axes are farther apart than they were cut for.
fn gap(pair: usize, farther: f64) -> f64 {
    let cut = cut_for(pair);
    let working = (cut / (cut + farther) * PRESSURE.cos()).acos();
    cut * PRESSURE.cos() * (inv(working) - inv(PRESSURE)) - INTERFERENCE * PRESSURE.cos()
}

/// g at the distance that gears were cut for.
fn deepest() -> f64 {
    -INTERFERENCE * PRESSURE.cos()
}

/// How much farther apart axes are where g has a value, by bisection.
fn farther_for(pair: usize, wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if gap(pair, middle) < wanted { low = middle } else { high = middle }
    }
    low
}

struct Train {
    scene: SceneQuery,
    gears: [BodyId; 3],
}

impl Train {
    fn new() -> Self {
        let cut = Scene::by_name("epicyclic", Some(600_000)).unwrap();
        let mut scene = SceneQuery::new();
        let gears = [1, 2, 3].map(|mesh| {
            let mesh = &cut.meshes[mesh];
            let model = Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
            scene.add(Arc::new(model), Pose::IDENTITY).unwrap()
        });
        Self { scene, gears }
    }

    /// Which neighbours meet at a phase, from 0 to 1, with gaps of two widths between flanks.
    fn meet(&mut self, phase: f64, gaps: [f64; 2]) -> [bool; 2] {
        // The middle of a gap stands at angle 0 of each gear; that of a tooth has to stand where the next gear
        // looks back.
        let mut angle = TAU * phase / TEETH[0];
        let mut x = 0.0;
        for (k, &gear) in self.gears.iter().enumerate() {
            if k > 0 {
                x += cut_for(k - 1) + farther_for(k - 1, gaps[k - 1]);
                angle = PI - PI / TEETH[k] - angle * TEETH[k - 1] / TEETH[k];
            }
            let (sin, cos) = angle.sin_cos();
            let [s, c] = [sin as f32, cos as f32];
            let rows = [[c, -s, 0.0, x as f32], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            self.scene.set_pose(gear, Pose::new(rows)).unwrap();
        }
        let mut met = [false; 2];
        for hit in self.scene.all().unwrap() {
            // The first and the third are out of each other's reach.
            let first = self.gears.iter().position(|&gear| gear == hit.bodies[0]).unwrap();
            assert_eq!(hit.bodies[1], self.gears[first + 1]);
            met[first] = true;
        }
        met
    }

    /// In how many phases each pair of neighbours meets.
    fn phases(&mut self, gaps: [f64; 2]) -> [u32; 2] {
        let mut count = [0; 2];
        for phase in 0..PHASES {
            let met = self.meet(f64::from(phase) / f64::from(PHASES), gaps);
            count = [0, 1].map(|pair| count[pair] + u32::from(met[pair]));
        }
        count
    }
}

#[test]
fn with_clearance_nothing_meets_at_any_phase() {
    let mut train = Train::new();
    for clear in [1e-4, 1e-3, 0.02] {
        assert_eq!(train.phases([clear; 2]), [0; 2], "{clear}");
    }
    // One of two is enough to tell them apart.
    assert_eq!(train.phases([1e-4, deepest()]), [0, PHASES]);
}

#[test]
fn at_a_known_depth_they_meet_at_every_phase() {
    let mut train = Train::new();
    for deep in [-FACETS, deepest()] {
        assert_eq!(train.phases([deep; 2]), [PHASES; 2], "{deep}");
    }
    // The same by g, and by the axes.
    assert!((gap(0, 0.0) - deepest()).abs() < 1e-12 && farther_for(1, deepest()) < 1e-9);
}

/// The depth at which the first phase meets is none, but for the facets.
#[test]
fn contact_begins_where_the_closed_form_says() {
    let mut train = Train::new();
    for pair in [0, 1] {
        let (mut apart, mut deep) = (1e-4, deepest());
        while apart - deep > 1e-5 {
            let middle = f64::midpoint(apart, deep);
            if train.phases([middle; 2])[pair] > 0 { deep = middle } else { apart = middle }
        }
        println!("gears {pair} and {}: contact from {deep:.5} on", pair + 1);
        assert!(-FACETS < deep && deep < 1e-4, "{deep} between gears {pair} and {}", pair + 1);
    }
}
