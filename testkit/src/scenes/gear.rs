//! Bodies of gears: toothed sections, repeated round the axis and closed by web and bore.

use std::f64::consts::TAU;

use crate::MeshData;

use super::mesh::closed_grid;
use super::tooth::{Cyl, Steps};

/// How many steps across its width give a gear about `triangles` triangles a tooth.
pub(crate) fn width_steps(triangles: usize, pitch: Steps) -> usize {
    let rows = (triangles as f64 / (2 * pitch.total()) as f64).round() as usize;
    rows.saturating_sub(1 + BODY_ROWS).max(1)
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
