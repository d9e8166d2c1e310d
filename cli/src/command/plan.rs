//! `pfront plan SCENE`: who answers each frame, and why.

use super::{milliseconds, progress};
use crate::args::{Mode, Plan};
use crate::engine::{objects, update};
use crate::output::out;
use crate::planning;
use crate::recording::Recording;
use anyhow::{Context, Result};
use pfront::planner::Planner;
use pfront_study::engine::{On, Tally};
use std::io::Write;
use std::time::{Duration, Instant};

pub(crate) fn run(asked: &Plan) -> Result<bool> {
    // Before anything is measured or printed.
    let recording = asked.scene.as_deref();
    let recording = recording.map(|name| Recording::open(name, asked.size, asked.frames));
    let recording = recording.transpose()?;
    let gpu = asked.backend.open()?;
    let machine = planning::machine(asked.machine.as_deref(), gpu.as_ref())?;
    if let Some(path) = &asked.calibrate {
        planning::write(&machine, path)?;
    }
    if !asked.json {
        writeln!(out(), "{machine}")?;
    }
    let planner = planning::planner(machine, asked.threads, gpu.as_ref())?;
    if let Some(recording) = recording {
        play(asked, recording, planner).with_context(|| asked.scene.clone().unwrap_or_default())?;
    }
    Ok(true)
}

fn play(asked: &Plan, mut recording: Recording, planner: Planner) -> Result<()> {
    let header = recording.take_header()?;
    let bar = progress(header.frames.into());
    let mut engine = objects(header)?.engine(On::Planner(Box::new(planner)).into())?;
    let (mut tally, mut took) = (Tally::default(), Duration::ZERO);
    let mut out = out();
    for number in 0.. {
        let Some(frame) = recording.next_frame()? else { break };
        let clock = Instant::now();
        update(&mut *engine, frame).with_context(|| format!("frame {number}"))?;
        match asked.mode {
            Mode::All => drop(engine.find()?),
            Mode::Any => drop(engine.any()?),
        }
        let own = clock.elapsed();
        took += own;
        let Some(plan) = engine.plan() else { continue };
        let is_new = tally.add(&plan, own) || number == 0;
        if asked.json {
            serde_json::to_writer(&mut out, &plan)?;
            writeln!(out)?;
        } else if is_new {
            bar.suspend(|| writeln!(out, "frame {number:>5}  {plan}"))?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if !asked.json {
        summary(&tally, took, &mut out)?;
    }
    Ok(())
}

fn summary(tally: &Tally, took: Duration, out: &mut impl Write) -> Result<()> {
    writeln!(out, "{tally}; {} changes of plan", tally.changes)?;
    writeln!(out, "{:.2} ms in all, moving included", milliseconds(took))?;
    if let Some(error) = tally.error() {
        writeln!(out, "predictions off by a factor of {error:.2} (median)")?;
    }
    writeln!(
        out,
        "deciding took {:.2} % of frames of {} µs and more",
        100.0 * tally.deciding(),
        Tally::LONG.as_micros()
    )?;
    Ok(())
}
