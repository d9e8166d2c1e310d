//! A line from the time of a question on the CPU to that on a GPU: a short and a long one are asked of both.

use crate::executor::choice::Line;
use crate::executor::{CpuHistory, Executor, Verb};
use crate::gpu::{Gpu, GpuError, GpuModel, GpuQuery, GpuQuestion};
use crate::subject::Subject;
use crate::{Model, Pose, TrianglePair};
use std::time::Instant;

/// Cells along a side of the sheets that are asked about, two triangles each: few enough that the GPU takes its latency, and
/// enough that it takes several times as long.
const SIDES: [usize; 2] = [32, 192];
/// How often each question is asked, in other poses; the median counts.
const RUNS: usize = 9;

/// Measures a GPU and the CPU of an executor.
pub(super) fn measure(executor: &Executor, gpu: &Gpu) -> Result<Line, GpuError> {
    // Else the first deforming mesh would wait for that.
    gpu.warm_up()?;
    let (mut on_cpu, mut pairs) = (CpuHistory::new(executor), Vec::<TrianglePair>::new());
    let mut on_gpu = GpuQuery::new(gpu)?;
    let (mut cpu, mut there, mut uploads) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let sheets = [sheet(SIDES[0])?, sheet(SIDES[1])?];
    // The first round wakes threads and grows buffers.
    for _ in 0..2 {
        for (i, sheet) in sheets.iter().enumerate() {
            let clock = Instant::now();
            let model = GpuModel::new(gpu, sheet.bvh())?;
            on_gpu.count(&GpuQuestion::pair(&model, &model, &pose(RUNS)))?;
            let first = clock.elapsed().as_secs_f64();
            let mut ask = |pose| on_gpu.all(&GpuQuestion::pair(&model, &model, &pose)).map(drop);
            there[i] = median(&mut ask)?;
            uploads[i] = (first - there[i]).max(0.0);
            cpu[i] = median(|pose| {
                let subject = Subject::Pair {
                    models: [sheet; 2],
                    a_from_b: pose.into(),
                    within: crate::Distance::default(),
                };
                let tree = subject.tree().map_err(refused)?;
                let (_, answer) = on_cpu.ask((), &tree, Verb::All, &mut pairs);
                answer.map(drop).map_err(refused)
            })?;
        }
    }
    let triangles = sheets.map(|sheet| sheet.mesh().triangles().len() as f64);
    let (latency, slope) = line(cpu, there);
    let (setup, upload) = line(triangles, uploads);
    Ok(Line { latency, slope, setup, upload })
}

/// The start and the slope of the line through two points, neither less than nothing.
fn line(x: [f64; 2], y: [f64; 2]) -> (f64, f64) {
    let slope = ((y[1] - y[0]) / (x[1] - x[0])).max(0.0);
    let slope = if slope.is_finite() { slope } else { 0.0 };
    ((y[0] - slope * x[0]).max(0.0), slope)
}

/// A wavy sheet of the unit square.
fn sheet(side: usize) -> Result<Model, GpuError> {
    let at = |i: usize| i as f32 / side as f32;
    let wave = |x: f32, y: f32| 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
    let grid = (0..=side).flat_map(|j| (0..=side).map(move |i| (at(i), at(j))));
    let positions = grid.map(|(x, y)| [x, y, wave(x, y)]).collect();
    let corner = |i: usize, j: usize| (j * (side + 1) + i) as u32;
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| corner(i + x, j + y));
        [[a, b, c], [b, d, c]]
    });
    Model::new(positions, triangles.collect()).map_err(refused)
}

/// A sheet moved a little way through itself, never twice alike: an answer must not be a kept one.
fn pose(run: usize) -> Pose {
    Pose::from_translation([0.011 + 0.0004 * run as f32, 0.007, 0.003])
}

/// The CPU refuses no such sheet, and no such pose.
fn refused(error: crate::Error) -> GpuError {
    GpuError::Device { reason: error.to_string() }
}

/// The median time of a run.
fn median(mut run: impl FnMut(Pose) -> Result<(), GpuError>) -> Result<f64, GpuError> {
    let mut times = [0.0; RUNS];
    for (number, time) in times.iter_mut().enumerate() {
        let clock = Instant::now();
        run(pose(number))?;
        *time = clock.elapsed().as_secs_f64();
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RUNS / 2])
}
