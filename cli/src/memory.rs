//! The memory that the process has had.

use memory_stats::memory_stats;

/// The most bytes that were resident, where the system tells (Linux), else those that are.
#[must_use]
pub fn peak() -> usize {
    high_water_mark().or_else(|| Some(memory_stats()?.physical_mem)).unwrap_or(0)
}

fn high_water_mark() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()? * 1024)
}
