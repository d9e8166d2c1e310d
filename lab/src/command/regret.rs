//! `pfront-lab regret`: what the choices of an executor cost, against the best of three plans that never change.
//!
//! Everyone plays each case in turn, with a new query in each round, so that whatever else the machine does hits all alike.
//! A plan's time is the median over rounds of its total, which is what a user sees. Plans are compared by the median over
//! rounds of one's time over the other's in the same round.

use super::progress;
use anyhow::{Result, ensure};
use clap::Args;
use pfront::Executor;
use pfront::executor::Backend as By;
use pfront_cli::executor::{Backend, adapter_name, number, parse_threads, threads};
use pfront_cli::output::out;
use pfront_lab::median;
use pfront_lab::player::{Objects, Player};
use pfront_lab::recording::Recording;
use pfront_testkit::scenes::Kind;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::num::NonZero;
use std::sync::Arc;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(crate) struct Regret {
    /// Built-in scenes, workloads (.tcw), or meshes as record takes them [default: a table of built-in scenes]
    cases: Vec<String>,
    /// Frames of each
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// How often everyone plays a case
    #[arg(long, value_name = "N", default_value = "5")]
    rounds: NonZero<usize>,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    threads: Option<NonZero<usize>>,
    /// Backends to choose from beside CPU threads
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
}

/// Scenes, their triangles and frames: from microseconds a frame to tens of milliseconds, for some frames and for many.
const CASES: [(&str, usize, u32); 14] = [
    ("spheres", 400, 300),
    ("torus-knots", 2_000, 300),
    ("course", 2_000, 300),
    ("sheet", 2_000, 300),
    ("spheres", 20_000, 20),
    ("torus-knots", 20_000, 300),
    ("worm-gear", 64_000, 20),
    ("worm-gear", 64_000, 300),
    ("swarm", 149_000, 60),
    ("course", 116_000, 60),
    ("sheet", 92_000, 60),
    ("spheres", 500_000, 100),
    ("torus-knots", 500_000, 20),
    ("torus-knots", 500_000, 100),
];

/// A case to play.
struct Case {
    name: String,
    size: Option<usize>,
    frames: Option<u32>,
    objects: Objects,
}

/// Plans that never change, and at last the executor that chooses.
type Lanes = Vec<(String, Executor)>;

pub(crate) fn run(asked: &Regret) -> Result<bool> {
    let mut out = out();
    let all = number(asked.threads);
    let mut lanes = vec![("one thread".to_owned(), Executor::sequential())];
    if all > 1 {
        lanes.push((format!("{all} threads"), threads(all)?));
    }
    let mut chooser = threads(all)?;
    if let Some(gpu) = asked.backend.open()? {
        writeln!(out, "GPU: {}", adapter_name(&gpu.device().adapter_info()))?;
        lanes.push(("GPU".to_owned(), Executor::gpu(&gpu, gpu.settings())));
        chooser = chooser.and_gpu(&gpu, gpu.settings())?;
    }
    lanes.push(("choice".to_owned(), chooser));
    let given = asked.cases.iter().map(|name| (&name[..], asked.size, asked.frames));
    let table = CASES.iter().map(|&(name, size, frames)| {
        let size = asked.size.map_or(size, |most| size.min(most));
        (name, Some(size), Some(asked.frames.map_or(frames, |most| frames.min(most))))
    });
    let cases: Vec<_> = if asked.cases.is_empty() { table.collect() } else { given.collect() };
    write!(out, "{:<14} {:>9} {:>6}", "case", "triangles", "frames")?;
    lanes.iter().try_for_each(|(name, _)| write!(out, " {:>12}", format!("{name}, ms")))?;
    writeln!(out, " {:>8}  answered", "regret")?;
    let bar = progress(cases.len() as u64, "case");
    let mut regrets = Vec::new();
    for (name, size, frames) in cases {
        let (header, _) = Recording::open(name, size, frames)?;
        let case = Case { name: name.to_owned(), size, frames, objects: Objects::new(header)? };
        let (times, answered) = race(&case, &lanes, asked.rounds.get())?;
        regrets.push(100.0 * regret(&times));
        write!(out, "{name:<14.14} {:>9} {:>6}", case.objects.triangles(), answered[0])?;
        times
            .iter()
            .try_for_each(|times| write!(out, " {:>12.3}", 1e3 * median(&mut times.clone())))?;
        let [frames, kept, one, many, gpu] = answered;
        let by = format!("{kept} kept, {one} one thread, {many} threads, {gpu} GPU of {frames}");
        writeln!(out, " {:>7.1}%  {by}", regrets[regrets.len() - 1])?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mean = regrets.iter().sum::<f64>() / regrets.len().max(1) as f64;
    let worst = regrets.iter().copied().fold(0.0, f64::max);
    let middle = median(&mut regrets);
    writeln!(out, "regret: mean {mean:.1} %, median {middle:.1} %, at worst {worst:.1} %")?;
    Ok(true)
}

/// By how much the last took longer than the best of the others, as a share of that. Less than nothing if it keeps answers.
fn regret(times: &[Vec<f64>]) -> f64 {
    let Some((chooser, fixed)) = times.split_last() else { return 0.0 };
    let over = |other: &Vec<f64>| {
        median(&mut chooser.iter().zip(other).map(|(own, other)| own / other).collect::<Vec<_>>())
    };
    fixed.iter().map(over).fold(f64::MIN, f64::max) - 1.0
}

/// Lets everyone play a case; returns the seconds of each round, and how many frames who answered of those that were chosen. In
/// a first round, which is not counted, all answers are compared.
fn race(case: &Case, lanes: &Lanes, rounds: usize) -> Result<(Vec<Vec<f64>>, [usize; 5])> {
    let mut expected = None;
    let mut answered = [0; 5];
    for (name, executor) in lanes {
        let mut digests = Vec::new();
        answered = [0; 5];
        play(case, executor, |player| {
            let mut hasher = DefaultHasher::new();
            player.all()?.hash(&mut hasher);
            digests.push(hasher.finish());
            answered[0] += 1;
            let by = player.plan().map(|plan| match plan.backend {
                By::Cached => 1,
                By::Threads => 3,
                By::Gpu => 4,
                _ => 2,
            });
            by.into_iter().for_each(|by: usize| answered[by] += 1);
            Ok(())
        })?;
        let first = expected.get_or_insert_with(|| digests.clone());
        ensure!(*first == digests, "{name} answers {} otherwise: please report this", case.name);
    }
    let mut times = vec![Vec::new(); lanes.len()];
    for round in 0..rounds {
        for turn in 0..lanes.len() {
            // Another is first in each round.
            let lane = (round + turn) % lanes.len();
            let time = play(case, &lanes[lane].1, |player| player.find().map(drop))?;
            times[lane].push(time.as_secs_f64());
        }
    }
    Ok((times, answered))
}

/// The time that a whole case takes: making the query, which uploads what a GPU needs, and all frames. Models are there.
fn play(
    case: &Case,
    executor: &Executor,
    mut ask: impl FnMut(&mut Player) -> Result<()>,
) -> Result<Duration> {
    let mut objects = case.objects.clone();
    // A shared model is copied by the first refit.
    if let (Kind::SelfMesh, [model]) = (objects.kind, &mut objects.models[..]) {
        *model = Arc::new((**model).clone());
    }
    let (_, mut recording) = Recording::open(&case.name, case.size, case.frames)?;
    let clock = Instant::now();
    let mut player = Player::new(objects, executor)?;
    let mut whole = clock.elapsed();
    while let Some(frame) = recording.next_frame()? {
        let clock = Instant::now();
        player.update(frame)?;
        ask(&mut player)?;
        whole += clock.elapsed();
    }
    Ok(whole)
}
