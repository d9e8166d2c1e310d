//! The figures as tables.

use super::Record;
use super::measure::{Measured, Spread, Took};
use std::io::{self, Write};

impl Record {
    /// What all workloads have in common.
    pub(super) fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { adapter, driver, depth, budget, .. } = self;
        writeln!(out, "{adapter}, {driver}")?;
        writeln!(out, "{depth} levels a pass, {budget} bytes of fronts and lists")
    }
}

impl Measured {
    pub(super) fn print(&self, threads: usize, out: &mut impl Write) -> io::Result<()> {
        let Self { name, triangles, frames, pairs, most, .. } = self;
        let meet = pairs.median;
        writeln!(
            out,
            "\n{name}: {triangles} triangles, {frames} frames, {meet} pairs in the median one; all \
             answers are the same"
        )?;
        writeln!(out, "  {:<10} {:<12} {:>12} {:>12}", "", "", "median", "p90")?;
        for pass in &self.passes {
            line(out, ["device", &pass.name], &pass.time, "µs")?;
        }
        match &self.device {
            Some(device) => line(out, ["device", "all passes"], device, "µs")?,
            None => writeln!(out, "  device     cannot tell the time of its passes")?,
        }
        took(out, "GPU", &self.gpu)?;
        took(out, "1 thread", &self.one_thread)?;
        took(out, &format!("{threads} threads"), &self.all_threads)?;
        let times = |took: &Took| took.frame.median / self.gpu.frame.median;
        writeln!(
            out,
            "  a frame on the GPU is {:.2} × as fast as on one thread, {:.2} × as on {threads}",
            times(&self.one_thread),
            times(&self.all_threads)
        )?;
        writeln!(
            out,
            "  at most {} node pairs in a front, {} leaf pairs, {} triangle pairs decided in integers, \
             {} on the CPU",
            most.front, most.leaf_pairs, most.undecided, most.on_cpu
        )?;
        writeln!(out, "  {} bytes of device memory for the models", self.device_bytes)?;
        if most.runs > 1 {
            let runs = most.runs;
            writeln!(
                out,
                "  up to {runs} runs a frame for want of budget; passes are of the last"
            )?;
        }
        Ok(())
    }
}

fn took(out: &mut impl Write, who: &str, took: &Took) -> io::Result<()> {
    line(out, [who, "update"], &took.update, "ms")?;
    line(out, [who, "query"], &took.query, "ms")?;
    line(out, [who, "frame"], &took.frame, "ms")
}

fn line(out: &mut impl Write, [who, what]: [&str; 2], time: &Spread, unit: &str) -> io::Result<()> {
    let Spread { median, p90 } = time;
    writeln!(out, "  {who:<10} {what:<12} {median:>9.3} {unit} {p90:>9.3} {unit}")
}
