//! The worm drive (Fig. 6a of the paper): a two-start worm and the wheel of 40 teeth it turns.
//!
//! The wheel is what a hob of the worm's shape would leave: each plane section of the worm at right
//! angles to the wheel's axis is a rack, so the wheel is conjugate to the worm over its whole width
//! and they touch along lines at every angle, on the three or four teeth in reach of the worm.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::gear::{body, width_steps};
use crate::MeshData;

use super::mesh::{closed_grid, scaled, subdivide};
use super::pose::{about_y, about_z, shift};
use super::scene::{FRAMES, Motion, Scene};
use super::tooth::{INTERFERENCE, RackFlank, Section, Steps, TAN_PRESSURE};

/// Triangles of both at the default size.
pub(crate) const TRIANGLES: usize = 64_000;

/// The worm (object 0) and its wheel, in about `triangles` triangles; the worm makes three turns
/// in [`FRAMES`] frames.
pub(crate) fn scene(triangles: usize) -> Scene {
    let density = (triangles as f64 / TRIANGLES as f64).sqrt();
    let worm = worm(density);
    let wheel = wheel(triangles.saturating_sub(worm.triangles.len()), density);
    let a_from_b = |frame: usize| {
        let worm_angle = 3.0 * TAU * frame as f64 / FRAMES as f64;
        let wheel_angle = -worm_angle * STARTS as f64 / TEETH as f64;
        let worm_from_world = about_y(-worm_angle) * shift(DVec3::X * -CENTER_DISTANCE);
        worm_from_world * about_z(wheel_angle)
    };
    Scene {
        name: "worm-gear",
        meshes: vec![worm, wheel],
        objects: vec![0, 1],
        frames: FRAMES,
        motion: Motion::Pair(Box::new(a_from_b)),
    }
}

// Lengths are in modules. The worm's axis is y, at x = CENTER_DISTANCE; the wheel's is z.
const STARTS: usize = 2;
const TEETH: usize = 40;
const PITCH: f64 = PI;
/// Radii of the worm: of its pitch cylinder, of the thread's foot and of its crest.
const PITCH_RADIUS: f64 = 5.0;
const FOOT: f64 = PITCH_RADIUS - 1.2;
const CREST: f64 = PITCH_RADIUS + 1.0;
/// Gap between the crest of one and the foot of the other.
const CLEARANCE: f64 = 0.2;
const CENTER_DISTANCE: f64 = TEETH as f64 / 2.0 + PITCH_RADIUS;
/// Half of the wheel's face width. Much wider, and the flanks would be undercut.
const HALF_WIDTH: f64 = 2.6;
/// The wheel's teeth embrace the worm, but rise no higher than this above the pitch circle.
const OUTSIDE: f64 = 1.6;
/// Length of the thread in pitches, and over how many of them it rises from the shaft.
const THREAD_PITCHES: usize = 6;
const RUN_OUT: f64 = 0.75;

/// Half of the thread's thickness at distance `rho` from the worm's axis.
fn half_thickness(rho: f64) -> f64 {
    PITCH / 4.0 - (rho - PITCH_RADIUS) * TAN_PRESSURE
}

/// The worm, about y, bored through.
///
/// Row i lies along the axis and column j around it. With STARTS · n columns and n rows a pitch,
/// the thread climbs one row for each column, so the phase i − j fixes the place on the thread's
/// profile, and crests and feet run along the cells' diagonals instead of across them.
fn worm(density: f64) -> MeshData {
    let (crest, flank) = (scaled(3, density, 1), scaled(9, density, 2));
    let foot = scaled(8, density, 2);
    let feet = [half_thickness(FOOT), PITCH - half_thickness(FOOT)];
    let crests = [half_thickness(CREST), PITCH - half_thickness(CREST)];
    let corners = [(0.0, CREST), (crests[0], CREST), (feet[0], FOOT)];
    let mirrored = [(feet[1], FOOT), (crests[1], CREST), (PITCH, CREST)];
    let corners = [corners, mirrored].concat().into_iter().map(DVec2::from).collect::<Vec<_>>();
    let profile = subdivide(&corners, &[crest, flank, foot, flank, crest]);

    let n = profile.len();
    let (columns, threaded) = (STARTS * n, THREAD_PITCHES * n);
    let end = PITCH * THREAD_PITCHES as f64 / 2.0;
    let shaft = shaft_rows(end, scaled(2, density, 1));
    closed_grid(threaded + shaft.len(), columns, |i, j| {
        let at = if i < threaded {
            let place = profile[(i + columns - j) % n];
            let even = PITCH * ((i + columns - j) % n) as f64 / n as f64;
            let pitches = i as f64 / n as f64;
            let rise = smooth_step(pitches.min(THREAD_PITCHES as f64 - pitches) / RUN_OUT);
            let y = PITCH * pitches - end + rise * (place.x - even);
            DVec2::new(FOOT + rise * (place.y - FOOT), y)
        } else {
            shaft[i - threaded]
        };
        let (sin, cos) = libm::sincos(TAU * j as f64 / columns as f64);
        DVec3::new(-at.x * cos, at.y, at.x * sin)
    })
}

/// The rest of the worm's outline as (radius, y): from the end of the thread over the journal,
/// through the bore and back to the thread's beginning.
fn shaft_rows(end: f64, steps: usize) -> Vec<DVec2> {
    let (journal, bore, length) = (0.8 * FOOT, 1.5, end + 4.0);
    let half = [(FOOT, end), (journal, end), (journal, length), (bore, length)].map(DVec2::from);
    let mirrored = half.iter().rev().map(|p| DVec2::new(p.x, -p.y));
    let corners: Vec<DVec2> = half.iter().copied().chain(mirrored).collect();
    subdivide(&corners, &[1, steps, 1, 2 * steps, 1, steps, 1])
}

/// 0 below 0, 1 above 1, and smooth between.
fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The wheel, about z, with a gap at angle 0, in about `triangles` triangles.
fn wheel(triangles: usize, density: f64) -> MeshData {
    let steps = Steps {
        floor: scaled(4, density, 1),
        flank: scaled(6, density, 2),
        top: scaled(4, density, 1),
    };
    // Coarser than that, the concave face of the wheel would cut into the worm.
    let width = width_steps(triangles / TEETH, steps).max(5);
    let toothed = (0..=width).map(|k| {
        let z = HALF_WIDTH * (2.0 * k as f64 / width as f64 - 1.0);
        // How high a point of the worm's section is that lies at `rho` from the worm's axis.
        let height = |rho: f64| PITCH_RADIUS - (rho * rho - z * z).sqrt();
        let (floor, throat) = (height(CREST + CLEARANCE), height(FOOT + CLEARANCE));
        let section =
            Section { teeth: TEETH, z, floor, top: throat.min(OUTSIDE), rack: [floor, throat] };
        section.points(&WormSection, steps)
    });
    let radius = TEETH as f64 / 2.0;
    body(TEETH, toothed.collect(), radius - 4.0, 0.3 * radius)
}

/// A plane section of the worm, thinner by the depth at which the pair shall overlap.
struct WormSection;

impl RackFlank for WormSection {
    fn at(&self, side: f64, height: f64, z: f64) -> (f64, f64) {
        let h = PITCH_RADIUS - height;
        let rho = libm::hypot(h, z);
        let lead = PITCH * STARTS as f64 / TAU;
        let t = lead * libm::atan2(z, h) + side * (half_thickness(rho) - INTERFERENCE);
        (t, lead * z / (rho * rho) + side * TAN_PRESSURE * h / rho)
    }
}
