//! `pfront` alone: a worm drive turns for 120 frames.

use super::{milliseconds, progress};
use crate::how::How;
use crate::memory;
use crate::output::out;
use anyhow::Result;
use pfront::{Model, Pose};
use pfront_scenes::Scene;
use pfront_study::engine::Objects;
use std::io::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub(crate) fn run() -> Result<bool> {
    let scene = Scene::by_name("worm-gear", None)?;
    let clock = Instant::now();
    let build = |&object: &usize| {
        let mesh = &scene.meshes[object];
        Model::new(mesh.positions.clone(), mesh.triangles.clone()).map(Arc::new)
    };
    let models: Vec<Arc<Model>> = scene.objects.iter().map(build).collect::<Result<_, _>>()?;
    let build = clock.elapsed();

    let objects = Objects::new(scene.kind(), models.clone());
    let mut engine = objects.engine(How::DEFAULT.asked()?)?;
    let mut poses = Vec::new();
    let (mut counts, mut times) = (Vec::new(), Vec::new());
    let bar = progress(scene.frames() as u64);
    for frame in 0..scene.frames() {
        scene.poses(frame, &mut poses);
        let clock = Instant::now();
        engine.place(1, Pose::new(poses[1]))?;
        counts.push(engine.all()?.len());
        times.push(clock.elapsed());
        bar.inc(1);
    }
    bar.finish_and_clear();

    let first = times[0];
    times.sort_unstable();
    let [median, slowest] = [times[times.len() / 2], times[times.len() - 1]];
    let ms = |time: Duration| format!("{:.2} ms", milliseconds(time));
    let mib = |bytes: usize| format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20));
    let models_bytes = models.iter().map(|model| model.bytes()).sum();
    let range = [counts.iter().min(), counts.iter().max()].map(|n| *n.unwrap_or(&0));
    let mut out = out();
    writeln!(out, "A worm drive for {} frames, exactly", scene.frames())?;
    writeln!(out, "  triangles  {} in {} meshes", scene.triangles(), models.len())?;
    writeln!(out, "  pairs      {} to {} meet in a frame", range[0], range[1])?;
    writeln!(out, "  build      {}", ms(build))?;
    writeln!(
        out,
        "  frame      {} (median; the first {}, the slowest {}) on {} threads",
        ms(median),
        ms(first),
        ms(slowest),
        How::DEFAULT.threads()
    )?;
    writeln!(
        out,
        "  memory     {} for the models, {} at most for all",
        mib(models_bytes),
        mib(memory::peak())
    )?;
    writeln!(out, "Your own meshes: pfront pairs A.obj B.stl --out hits.ply; more with --help")?;
    Ok(true)
}
