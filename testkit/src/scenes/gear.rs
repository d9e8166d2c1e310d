//! Bodies of gears: toothed sections, repeated round the axis and closed by web and bore; and the
//! spur gears, outer and inner.

use std::f64::consts::{PI, TAU};

use crate::MeshData;

use super::mesh::closed_grid;
use super::tooth::{
    ADDENDUM, Cyl, DEDENDUM, INTERFERENCE, RackFlank, Section, Steps, TAN_PRESSURE,
};

/// Whether the teeth of a spur gear point away from the axis or at it.
#[derive(Clone, Copy)]
pub(crate) enum Teeth {
    Outer,
    Inner,
}

/// Numbers of steps of a spur gear: along a pitch, and across the width of its teeth.
#[derive(Clone, Copy)]
pub(crate) struct SpurSteps {
    pub(crate) pitch: Steps,
    pub(crate) width: usize,
}

/// How many steps across its width give a gear about `triangles` triangles a tooth.
pub(crate) fn width_steps(triangles: usize, pitch: Steps) -> usize {
    let rows = (triangles as f64 / (2 * pitch.total()) as f64).round() as usize;
    rows.saturating_sub(1 + BODY_ROWS).max(1)
}

/// A spur gear of module 1 about z, from −`half_width` to `half_width`; the middle of a gap is at
/// angle 0, that of a tooth for inner teeth.
pub(crate) fn spur(teeth: usize, kind: Teeth, half_width: f64, steps: SpurSteps) -> MeshData {
    let radius = teeth as f64 / 2.0;
    // The space between inner teeth has the shape of outer teeth that reach down to the inner top.
    let (floor, top, thinning) = match kind {
        Teeth::Outer => (-DEDENDUM, ADDENDUM, -INTERFERENCE / 2.0),
        Teeth::Inner => (-ADDENDUM, DEDENDUM, INTERFERENCE / 2.0),
    };
    // On the inside the loop through teeth, web and bore runs the other way.
    let (rim, bore, end) = match kind {
        Teeth::Outer => (radius - 3.0, 0.4 * radius, half_width),
        Teeth::Inner => (radius + 3.0, radius + 5.0, -half_width),
    };
    let rack = StraightRack { half_thickness: PI / 4.0 + thinning };
    let section = Section { teeth, z: 0.0, floor, top, rack: [floor, top] };
    let points = section.points(&rack, steps.pitch);
    let toothed = (0..=steps.width).map(|k| {
        let z = end * (2.0 * k as f64 / steps.width as f64 - 1.0);
        points.iter().map(|&p| Cyl { z, ..p }).collect()
    });
    body(teeth, toothed.collect(), rim, bore)
}

/// Rows that [`body`] adds.
const BODY_ROWS: usize = 6;

/// A gear of which `rows` are one pitch of its toothed face, from one end of its width to the
/// other; a rim, a thinner web and a bore close it. Between the ends the columns twist evenly.
pub(crate) fn body(teeth: usize, mut rows: Vec<Vec<Cyl>>, rim: f64, bore: f64) -> MeshData {
    let toothed = rows.len();
    let end = rows[toothed - 1][0].z;
    let web = 0.6 * end;
    let corners: [_; BODY_ROWS] =
        [(rim, end), (rim, web), (bore, web), (bore, -web), (rim, -web), (rim, -end)];
    for (r, z) in corners {
        let columns = rows[0].iter().zip(&rows[toothed - 1]);
        let row = columns.map(|(first, last)| {
            let share = (z + end) / (2.0 * end);
            Cyl { r, angle: first.angle + (last.angle - first.angle) * share, z }
        });
        let row = row.collect();
        rows.push(row);
    }
    repeat(teeth, &rows)
}

/// The closed body whose `rows` hold one pitch each.
fn repeat(teeth: usize, rows: &[Vec<Cyl>]) -> MeshData {
    let pitch = rows[0].len();
    closed_grid(rows.len(), teeth * pitch, |i, j| {
        let Cyl { r, angle, z } = rows[i][j % pitch];
        Cyl { r, angle: angle + TAU * (j / pitch) as f64 / teeth as f64, z }.point()
    })
}

/// The basic rack of involute gears.
struct StraightRack {
    /// Half of a rack tooth's thickness on the pitch line.
    half_thickness: f64,
}

impl RackFlank for StraightRack {
    fn at(&self, side: f64, height: f64, _z: f64) -> (f64, f64) {
        (side * (self.half_thickness + height * TAN_PRESSURE), side * TAN_PRESSURE)
    }
}
