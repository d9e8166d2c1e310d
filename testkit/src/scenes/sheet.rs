//! The folded sheet: a deforming mesh that touches and crosses itself, as the cloth of the paper's
//! Fig. 8 does.
//!
//! Its section is the sine-generated curve, whose direction swings by ±A along its length: the
//! shape of river meanders (Langbein & Leopold 1966). It keeps lengths, folds a flat sheet into
//! pleats as A grows, and at A of about 125° neighbouring pleats meet. A differs from row to row
//! and drifts with time, so they meet in places, and the places wander; small waves crumple it.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::MeshData;

use super::mesh::{grid_triangles, round, scaled};
use super::scene::{FRAMES, Motion, Scene};

/// Triangles at the default size.
pub(crate) const TRIANGLES: usize = 92_000;

/// The sheet in about `triangles` triangles. It is open: a disc, with a border; each inner edge has
/// two triangles, all turned the same way.
pub(crate) fn scene(triangles: usize) -> Scene {
    let density = (triangles as f64 / TRIANGLES as f64).sqrt();
    let sheet = Sheet { rows: scaled(200, density, 2), columns: scaled(230, density, 2) };
    let Sheet { rows, columns } = sheet;
    let mut mesh = MeshData {
        positions: Vec::new(),
        triangles: grid_triangles([rows + 1, columns + 1], [rows, columns]),
    };
    sheet.positions(0, &mut mesh.positions);
    let positions = move |frame: usize, out: &mut Vec<[f32; 3]>| sheet.positions(frame, out);
    Scene {
        name: "sheet",
        meshes: vec![mesh],
        objects: vec![0],
        frames: FRAMES,
        motion: Motion::Deforming(Box::new(positions)),
    }
}

/// Side lengths: across the pleats, and along them.
const LENGTH: f64 = 1.15;
const WIDTH: f64 = 1.0;
/// Pleats across the sheet, up and down counted as one.
const PLEATS: f64 = 4.0;

/// Numbers of cells along the pleats and across them.
#[derive(Clone, Copy)]
struct Sheet {
    rows: usize,
    columns: usize,
}

impl Sheet {
    fn positions(self, frame: usize, out: &mut Vec<[f32; 3]>) {
        let time = frame as f64 / FRAMES as f64;
        out.clear();
        for i in 0..=self.rows {
            let along = i as f64 / self.rows as f64;
            let folded = self.pleated(swing(along, time));
            let row = folded.iter().enumerate().map(|(j, p)| {
                let across = j as f64 / self.columns as f64;
                round(*p + DVec3::Y * (WIDTH * (along - 0.5)) + crumple(across, along, time))
            });
            out.extend(row);
        }
    }

    /// One row in the plane y = 0, centred: its direction swings by ±`swing` radians.
    fn pleated(self, swing: f64) -> Vec<DVec3> {
        let step = LENGTH / self.columns as f64;
        let middle = |j: usize| (j as f64 + 0.5) / self.columns as f64;
        let mut p = DVec3::ZERO;
        let mut row = vec![p];
        for j in 0..self.columns {
            let (sin, cos) = libm::sincos(swing * libm::sin(TAU * PLEATS * middle(j)));
            p += DVec3::new(cos, 0.0, sin) * step;
            row.push(p);
        }
        let center = p / 2.0;
        row.iter_mut().for_each(|q| *q -= center);
        row
    }
}

/// By how much the section's direction swings at `along` in radians: growing for the first third
/// of the frames until pleats meet, then wandering about that.
fn swing(along: f64, time: f64) -> f64 {
    let folded = 2.17 * (0.5 + 0.5 * (3.0 * time).min(1.0));
    folded
        + 0.07 * libm::sin(TAU * (1.5 * along - time))
        + 0.03 * libm::sin(TAU * (5.0 * along + 2.0 * time))
}

/// Displacement by three waves that share no period with the pleats.
fn crumple(across: f64, along: f64, time: f64) -> DVec3 {
    let wave = |a: f64, b: f64, t: f64| libm::sin(TAU * (a * across + b * along + t * time));
    DVec3::new(
        0.004 * wave(7.3, 5.1, 1.0),
        0.006 * wave(5.7, -3.3, -1.0),
        0.005 * wave(-3.9, 6.1, 1.0) + 0.03 * wave(0.6, 0.9, 1.0),
    )
}
