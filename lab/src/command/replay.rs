//! `pfront-lab replay FILE`

use super::progress;
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use pfront_cli::executor::ExecutorArgs;
use pfront_cli::memory;
use pfront_cli::output::{Draft, out};
use pfront_lab::pairs::PairWriter;
use pfront_lab::player::{Objects, Player};
use pfront_lab::recording::Recording;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// The workload (.tcw), the name of a built-in scene, or meshes as record takes them
    file: String,
    /// About so many triangles in a built-in scene, instead of its own number
    #[arg(long, value_name = "TRIANGLES")]
    size: Option<usize>,
    /// Find all pairs of a frame, or stop at the first
    #[arg(long, value_enum, default_value_t = Mode::All)]
    mode: Mode,
    /// Write the pairs of every frame here
    #[arg(long, value_name = "FILE")]
    pairs: Option<PathBuf>,
    /// Run only so many frames; a built-in scene may go on beyond its own
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Count the pairs of the first N frames before the clock starts
    #[arg(long, value_name = "N", default_value_t = 0)]
    warm: u32,
    #[command(flatten)]
    executor: ExecutorArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Mode {
    All,
    Any,
}

/// The clock on the wall, and the processor time of all threads of the process.
#[derive(Clone, Copy)]
struct Clock {
    wall: Instant,
    cpu: Duration,
}

impl Clock {
    fn now() -> Self {
        Self { wall: Instant::now(), cpu: cpu_time() }
    }

    /// Milliseconds on the wall and of processors from an earlier time to this.
    fn since(self, earlier: Self) -> [f64; 2] {
        [self.wall - earlier.wall, self.cpu.saturating_sub(earlier.cpu)]
            .map(|time| 1e3 * time.as_secs_f64())
    }
}

/// The processor time of the process; nothing where the system does not tell.
fn cpu_time() -> Duration {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    }
    #[cfg(not(unix))]
    Duration::ZERO
}

pub(crate) fn run(replay: &Replay) -> Result<bool> {
    ensure!(
        replay.mode == Mode::All || replay.pairs.is_none(),
        "--pairs needs --mode all, since any stops at the first pair"
    );
    let file = || replay.file.clone();
    let open = || Recording::open(&replay.file, replay.size, replay.frames);
    let (header, mut recording) = open()?;
    let frames = header.frames;
    let executor = replay.executor.open()?;
    let start = Clock::now();
    let objects = Objects::new(header).with_context(file)?;
    let mut player = Player::new(objects, &executor)?;
    let [build, build_cpu] = Clock::now().since(start);

    let mut pairs = match &replay.pairs {
        Some(path) => Some(PairWriter::new(Draft::new(path)?, frames)?),
        None => None,
    };
    if replay.warm > 0 {
        for _ in 0..replay.warm {
            let Some(frame) = recording.next_frame().with_context(file)? else { break };
            player.update(frame).context("while warming up")?;
            // Another question than those that are timed, since answers are kept.
            player.count()?;
        }
        (_, recording) = open()?;
    }
    let mut out = out();
    writeln!(out, "BUILD\t{build:.6}\t{build_cpu:.6}")?;
    let bar = progress(frames.into(), "frame");
    let mut plans = BTreeMap::<String, usize>::new();
    for number in 0.. {
        let Some(frame) = recording.next_frame().with_context(file)? else { break };
        let begun = Clock::now();
        player.update(frame).with_context(|| format!("frame {number}"))?;
        let updated = Clock::now();
        let count = match replay.mode {
            Mode::All => player.find()?,
            Mode::Any => usize::from(player.any()?),
        };
        let [query, query_cpu] = Clock::now().since(updated);
        let [update, update_cpu] = updated.since(begun);
        write!(out, "FRAME\t{number}\t{update:.6}\t{query:.6}\t{count}")?;
        writeln!(out, "\t{update_cpu:.6}\t{query_cpu:.6}")?;
        if let Some(plan) = player.plan() {
            *plans.entry(plan.backend.to_string()).or_default() += 1;
        }
        if let Some(pairs) = &mut pairs {
            // The query has kept them; to number them as a pair file does is none of its work.
            pairs.frame(player.all()?).context("cannot write the pairs")?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if let Some(pairs) = pairs {
        pairs.finish().finish()?;
    }
    if replay.executor.is_auto() {
        let told = plans.iter().map(|(backend, frames)| format!("{frames} {backend}"));
        eprintln!("{frames} frames: {}", told.collect::<Vec<_>>().join(", "));
    }
    writeln!(out, "RSS\t{}\tbytes", memory::peak())?;
    Ok(true)
}
