//! A process that leaves with tickets of a GPU in flight ends as it says, and soon, whichever way it leaves.
//!
//! The test runs itself as a child for each way. `PFRONT_ROUNDS` says how often.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use pfront::gpu::{Budget, Gpu, GpuSettings};
use pfront::{Adjacency, Batch, Error, Executor, Model, PairQuery, Pose};
use std::io::{BufRead, BufReader, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, ExitStatus, Stdio, exit};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

/// The ways, with the exit status that each ends with; none if a signal ends it.
const WAYS: [(&str, Option<i32>); 14] = [
    ("read", Some(0)),
    ("return", Some(0)),
    ("error", Some(1)),
    ("panic", Some(101)),
    ("caught panic", Some(0)),
    ("exit", Some(7)),
    ("exit with a static executor", Some(7)),
    ("terminate", None),
    ("ticket first", Some(0)),
    ("ticket last", Some(0)),
    ("gpu first", Some(0)),
    ("cancel", Some(0)),
    ("forget the ticket", Some(0)),
    ("forget all", Some(0)),
];

/// The longest that leaving takes beyond what it takes with nothing in flight.
const LONGEST: Duration = Duration::from_secs(2);

fn main() -> Result<(), Error> {
    if let Ok(way) = std::env::var("PFRONT_WAY") {
        return leave(&way);
    }
    let rounds = std::env::var("PFRONT_ROUNDS").map_or(1, |rounds| rounds.parse().unwrap());
    for round in 0..rounds {
        let [mut alone, mut longest] = [Duration::ZERO; 2];
        for (way, code) in WAYS {
            let (status, took) = run(way, round);
            assert!(is_as_said(status, code), "{way}, round {round}: {status}");
            if way == "read" {
                alone = took;
            }
            assert!(took <= alone + LONGEST, "{way}, round {round}: {took:?}, {alone:?} alone");
            longest = longest.max(took);
        }
        println!("round {round}: {} ways, the longest {longest:?}", WAYS.len());
    }
    Ok(())
}

fn is_as_said(status: ExitStatus, code: Option<i32>) -> bool {
    #[cfg(unix)]
    if code.is_none() {
        use std::os::unix::process::ExitStatusExt;
        return status.signal() == Some(15);
    }
    status.code() == code
}

/// The exit status of a child, and how long it took from the moment that it began to leave.
fn run(way: &str, round: u64) -> (ExitStatus, Duration) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .env("PFRONT_WAY", way)
        .env("PFRONT_DELAY", (round * 7 % 60).to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "leaving", "{way}");
    let clock = Instant::now();
    let status = child.wait().unwrap();
    (status, clock.elapsed())
}

static STATIC: LazyLock<Executor> = LazyLock::new(|| {
    let gpu = Gpu::new().unwrap();
    Executor::gpu(&gpu, small(&gpu))
});

/// A budget for which a batch takes many runs.
fn small(gpu: &Gpu) -> GpuSettings {
    GpuSettings { budget: Budget { bytes: 1 << 18 }, ..gpu.settings() }
}

fn sheet() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let side = 60_u32;
    let at = |i: u32| i as f32 / side as f32;
    let grid = (0..=side).flat_map(|j| (0..=side).map(move |i| (at(i), at(j))));
    let positions = grid.map(|(u, v)| [u, v, 0.1 * (9.0 * u).sin() * (17.0 * v).cos()]).collect();
    let cells = (0..side).flat_map(|j| (0..side).map(move |i| j * (side + 1) + i));
    let triangles =
        cells.flat_map(|k| [[k, k + 1, k + side + 1], [k + 1, k + side + 2, k + side + 1]]);
    (positions, triangles.collect())
}

fn leave(way: &str) -> Result<(), Error> {
    let gpu = Gpu::new()?;
    let executor = match way {
        "exit with a static executor" => STATIC.clone(),
        _ => Executor::gpu(&gpu, small(&gpu)),
    };
    let (positions, triangles) = sheet();
    let in_f64 = positions.iter().map(|p| p.map(f64::from)).collect();
    let in_f64 = Arc::new(Model::from_f64(in_f64, triangles.clone())?);
    let model = Arc::new(Model::new(positions, triangles)?);
    let mut batch = Batch::new();
    for i in 0..50 {
        batch.pair(&model, &model, Pose::from_translation([0.01 * i as f32, 0.0, 0.01]))?;
    }
    batch.itself(&model, Adjacency::default());
    batch.itself(&in_f64, Adjacency::default());
    batch.pair(&model, &in_f64, Pose::from_translation([0.3, 0.0, 0.01]))?;
    let mut few = Batch::new();
    few.pair(&model, &model, Pose::from_translation([0.7, 0.0, 0.01]))?;
    let mut ticket = batch.count(&executor)?;
    let others = [few.any(&executor)?, few.any(&executor)?, few.any(&executor)?];
    let delay = std::env::var("PFRONT_DELAY").unwrap_or_default().parse().unwrap_or(0);
    std::thread::sleep(Duration::from_millis(delay));
    if way == "read" {
        drop(others);
        let few = few.count(&executor)?;
        drop(ticket);
        few.read()?;
        say();
        return Ok(());
    }
    say();
    match way {
        "error" => return Err(Error::Cancelled),
        "panic" => panic!("on purpose"),
        "caught panic" => {
            let caught = catch_unwind(AssertUnwindSafe(move || {
                let _held = (ticket, others);
                panic!("on purpose")
            }));
            assert!(caught.is_err());
        }
        "exit" | "exit with a static executor" => exit(7),
        "terminate" => {
            let id = std::process::id().to_string();
            // Tests that a shell starts in the background ignore interrupts.
            Command::new("kill").args(["-TERM", &id]).status().unwrap();
            std::thread::sleep(Duration::from_secs(30));
        }
        "ticket first" => {
            drop((ticket, others));
            drop((batch, few));
            drop(executor);
            drop(gpu);
        }
        "ticket last" => {
            drop(gpu);
            drop((batch, few));
            drop(executor);
            drop((others, ticket));
        }
        "gpu first" => {
            drop((gpu, executor));
            drop((ticket, others));
        }
        "cancel" => {
            ticket.cancel();
            let mut query = PairQuery::new().on(&executor);
            query.count(&model, &model, Pose::from_translation([0.7, 0.0, 0.01]))?;
        }
        "forget the ticket" => std::mem::forget((ticket, others)),
        "forget all" => std::mem::forget((ticket, others, batch, executor, gpu)),
        _ => assert_eq!(way, "return"),
    }
    Ok(())
}

fn say() {
    println!("leaving");
    std::io::stdout().flush().unwrap();
}
