//! `pfront bench` and `pfront demo`: frames of two meshes on every executor that this machine has.

use super::knot::torus_knot;
use super::{check_files, model};
use crate::args::{Bench, Reading};
use anyhow::{Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use pfront::gpu::{Gpu, GpuModel, GpuQuery, GpuQuestion};
use pfront::{AnyPose, Executor, Model, PairQuery, Pose, Pose64, TrianglePair};
use pfront_cli::executor::{Backend, adapter_name, number, threads};
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::memory;
use pfront_cli::output::out;
use pfront_files::escape::escaped;
use serde::Serialize;
use std::f64::consts::TAU;
use std::io::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The measurements of a course.
#[derive(Serialize)]
struct Record {
    version: u32,
    name: String,
    triangles: usize,
    frames: usize,
    /// The fewest and the most pairs of a frame.
    pairs: [usize; 2],
    build_ms: f64,
    model_bytes: usize,
    peak_bytes: usize,
    executors: Vec<Times>,
}

/// Milliseconds of a frame on one executor.
#[derive(Serialize)]
struct Times {
    executor: String,
    first_ms: f64,
    median_ms: f64,
    slowest_ms: f64,
    /// The median time of the passes on the device, which are a part of what a user waits for.
    #[serde(skip_serializing_if = "Option::is_none")]
    device_ms: Option<f64>,
}

/// Two models, and the pose of the second in each frame.
struct Course {
    name: String,
    models: [Model; 2],
    poses: Vec<AnyPose>,
}

pub(crate) fn demo() -> Result<bool> {
    let frames = NonZero::<u32>::MIN.saturating_add(119);
    let reading = Reading::default();
    run(&Bench {
        reading,
        meshes: Vec::new(),
        frames,
        threads: None,
        backend: Backend::Cpu,
        json: false,
    })?;
    writeln!(out(), "Your own meshes: pfront pairs A.obj B.stl --out hits.ply; more with --help")?;
    Ok(true)
}

pub(crate) fn run(bench: &Bench) -> Result<bool> {
    let frames = bench.frames.get() as usize;
    let clock = Instant::now();
    let read = |path: &PathBuf| anyhow::Ok(model(path, &bench.reading)?.0);
    let course = match &bench.meshes[..] {
        [a, b] => {
            check_files(&[a, b], None)?;
            let name = format!("{} and {}", a.display(), b.display());
            Course::turning(name, [read(a)?, read(b)?], frames)
        }
        _ => {
            let knots = [torus_knot(0.0)?, torus_knot(0.8)?];
            Course::turning("two torus knots".to_owned(), knots, frames)
        }
    };
    let build = clock.elapsed();
    let mut executors = vec![("one thread".to_owned(), Executor::sequential())];
    let all = number(bench.threads);
    if all > 1 {
        executors.push((format!("{all} threads"), threads(all)?));
    }
    let gpu = bench.backend.open()?;
    if let Some(gpu) = &gpu {
        let name = escaped(&adapter_name(&gpu.device().adapter_info())).into_owned();
        executors.push((name, Executor::gpu(gpu, gpu.settings())));
    }
    let turns = executors.len() + usize::from(gpu.is_some());
    let bar = ProgressBar::new((frames * turns) as u64);
    bar.set_style(ProgressStyle::with_template("{bar:40} frame {pos} of {len}, {eta} left")?);
    let (mut answers, mut times) = (Vec::new(), Vec::new());
    for (name, executor) in executors {
        times.push(course.play(name, &executor, &mut answers, &bar)?);
    }
    let peak_bytes = memory::peak();
    if let (Some(gpu), Some(of_gpu)) = (&gpu, times.last_mut()) {
        of_gpu.device_ms = course.device_ms(gpu, &bar)?;
    }
    bar.finish_and_clear();
    let counts = || answers.iter().map(Vec::len);
    let record = Record {
        version: VERSION,
        triangles: course.models.iter().map(|model| model.mesh().triangles().len()).sum(),
        frames,
        pairs: [counts().min(), counts().max()].map(Option::unwrap_or_default),
        build_ms: milliseconds(build),
        model_bytes: course.models.iter().map(Model::bytes).sum(),
        peak_bytes,
        executors: times,
        name: course.name,
    };
    if bench.json {
        write_json(&mut out(), &record)?;
    } else {
        record.print()?;
    }
    Ok(true)
}

impl Course {
    /// One turn of the second mesh about the z axis through the middle of its box.
    fn turning(name: String, models: [Model; 2], frames: usize) -> Self {
        let (bvh, is_f64) = (models[1].bvh(), models.iter().any(Model::is_f64));
        let origin = bvh.mesh().origin();
        let middle = bvh.aabb().map_or([0.0; 3], |aabb| {
            let middle = |k: usize| f64::midpoint(aabb.min[k].into(), aabb.max[k].into());
            [0, 1, 2].map(|axis| origin[axis] + middle(axis))
        });
        let pose = |frame| {
            let (sin, cos) = (TAU * frame as f64 / frames as f64).sin_cos();
            let [x, y, _] = middle;
            let rows = [
                [cos, -sin, 0.0, x - cos * x + sin * y],
                [sin, cos, 0.0, y - sin * x - cos * y],
                [0.0, 0.0, 1.0, 0.0],
            ];
            match is_f64 {
                true => AnyPose::from(Pose64::new(rows)),
                false => Pose::new(rows.map(|row| row.map(|number| number as f32))).into(),
            }
        };
        Self { name, models, poses: (0..frames).map(pose).collect() }
    }

    /// Times every frame. Answers must be those of the executor before, if there was one.
    fn play(
        &self,
        name: String,
        executor: &Executor,
        answers: &mut Vec<Vec<TrianglePair>>,
        bar: &ProgressBar,
    ) -> Result<Times> {
        let mut query = PairQuery::new().on(executor);
        let ([a, b], mut times) = (&self.models, Vec::new());
        for (frame, pose) in self.poses.iter().enumerate() {
            let clock = Instant::now();
            let pairs = query.all(a, b, pose)?;
            times.push(clock.elapsed());
            match answers.get(frame) {
                Some(answer) => ensure!(
                    answer == pairs,
                    "{name} answers frame {frame} differently: please report this"
                ),
                None => answers.push(pairs.to_vec()),
            }
            bar.inc(1);
        }
        let first = times[0];
        times.sort_unstable();
        let [median, slowest] = [times[times.len() / 2], times[times.len() - 1]];
        let [first_ms, median_ms, slowest_ms] = [first, median, slowest].map(milliseconds);
        Ok(Times { executor: name, first_ms, median_ms, slowest_ms, device_ms: None })
    }

    /// The median of the milliseconds that the passes of a frame take on a device; `None` if it cannot tell. In a turn of its
    /// own, since a query that keeps time records nothing ahead, and a user waits longer.
    fn device_ms(&self, gpu: &Gpu, bar: &ProgressBar) -> Result<Option<f64>> {
        let [a, b] = &self.models;
        let on_device = [GpuModel::new(gpu, a.bvh())?, GpuModel::new(gpu, b.bvh())?];
        let mut query = GpuQuery::new(gpu)?.with_time()?;
        let mut times = Vec::new();
        for pose in &self.poses {
            let [a_there, b_there] = &on_device;
            let question = match (pose.pair([a.bvh(), b.bvh()])?.shadows(), pose) {
                (Some(shadows), _) => GpuQuestion::shadows(a_there, b_there, &shadows),
                (None, AnyPose::F32(a_from_b)) => GpuQuestion::pair(a_there, b_there, a_from_b),
                // One of them is empty.
                (None, AnyPose::F64(_)) => return Ok(None),
            };
            query.all(&question)?;
            let passes = query.timings()?;
            if passes.is_empty() {
                return Ok(None);
            }
            // A frame that took several runs, of which the last alone is known, took longer than any of one run.
            let is_whole = query.report().runs == 1;
            times.push(is_whole.then(|| passes.iter().map(|pass| pass.time).sum()));
            bar.inc(1);
        }
        times.sort_unstable_by_key(|time| time.unwrap_or(Duration::MAX));
        Ok(times.get(times.len() / 2).copied().flatten().map(milliseconds))
    }
}

impl Record {
    fn print(&self) -> Result<()> {
        let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        let Self { name, triangles, frames, pairs: [fewest, most], build_ms, .. } = self;
        let mut out = out();
        writeln!(
            out,
            "{}: {triangles} triangles, {frames} frames of {fewest} to {most} pairs",
            escaped(name)
        )?;
        let title = "ms per frame";
        let names = self.executors.iter().map(|times| times.executor.chars().count());
        let width = names.max().unwrap_or(0).max(title.len());
        let row = |name: &str, cells: [&str; 3], on_device: Option<&str>| {
            let [median, slowest, first] = cells;
            let on_device = on_device.map_or(String::new(), |cell| format!(" {cell:>9}"));
            format!("  {name:<width$} {median:>9} {slowest:>9} {first:>9}{on_device}")
        };
        // A column only where some device has told its time.
        let has_device = self.executors.iter().any(|times| times.device_ms.is_some());
        let title_cells = ["median", "slowest", "first"];
        writeln!(out, "{}", row(title, title_cells, has_device.then_some("on device")))?;
        for times in &self.executors {
            let cell = |ms: f64| format!("{ms:.3}");
            let [median, slowest, first] =
                [times.median_ms, times.slowest_ms, times.first_ms].map(cell);
            let on_device = times.device_ms.map_or("-".to_owned(), cell);
            let on_device = has_device.then_some(on_device.as_str());
            writeln!(out, "{}", row(&times.executor, [&median, &slowest, &first], on_device))?;
        }
        let [models, peak] = [self.model_bytes, self.peak_bytes].map(mib);
        writeln!(
            out,
            "  built in {build_ms:.1} ms; models {models:.1} MiB, at most {peak:.1} MiB"
        )?;
        Ok(())
    }
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
