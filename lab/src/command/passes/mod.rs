//! `pfront bench gpu`: where a GPU spends its time, and the CPU's on the same frames.

mod measure;
mod print;

use crate::args::Passes;
use crate::stacks;
use anyhow::{Context, Result};
use measure::measure;
use pfront::gpu::{Budget, Gpu, GpuSettings};
use pfront_cli::executor as how;
use pfront_cli::executor::adapter_name;
use pfront_cli::output::{Draft, out};
use pfront_lab::engine::OnGpu;
use serde::Serialize;
use std::io::Write;

pub(crate) use measure::{Measured, Took};

/// All that was measured, and on what.
#[derive(Serialize)]
struct Record {
    adapter: String,
    driver: String,
    /// The depth bound d_b.
    depth: u32,
    /// Bytes of fronts and lists.
    budget: u64,
    threads: usize,
    workloads: Vec<Measured>,
}

pub(crate) fn run(bench: &Passes) -> Result<bool> {
    let gpu = Gpu::new()?;
    let info = gpu.device().adapter_info();
    let suits = gpu.settings();
    let settings = GpuSettings {
        depth: bench.depth.unwrap_or(suits.depth),
        budget: bench.budget.map_or(suits.budget, |bytes| Budget { bytes }),
        ..suits
    };
    let on = OnGpu { gpu, settings, timed: false };
    let threads = how::number(bench.threads);
    let mut record = Record {
        adapter: adapter_name(&info),
        driver: format!("{} {}", info.driver, info.driver_info),
        depth: settings.depth,
        budget: settings.budget.bytes,
        threads,
        workloads: Vec::new(),
    };
    let mut out = out();
    if !bench.json {
        record.print(&mut out)?;
    }
    for name in &bench.workloads {
        let measured = measure(name, bench, &on, threads).with_context(|| name.clone())?;
        if !bench.json {
            measured.print(threads, &mut out)?;
            out.flush()?;
        }
        record.workloads.push(measured);
    }
    if bench.json {
        serde_json::to_writer_pretty(&mut out, &record)?;
        writeln!(out)?;
    }
    if let Some(path) = &bench.chart {
        let mut file = Draft::new(path)?;
        let svg = stacks::draw(&record.adapter, threads, &record.workloads)?;
        file.write_all(svg.as_bytes())?;
        file.finish()?;
    }
    Ok(true)
}
