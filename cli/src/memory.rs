//! The memory that the process has had.

use memory_stats::memory_stats;

/// The most bytes that were resident, where the system tells (Linux), else those that are.
pub fn peak() -> usize {
    high_water_mark().or_else(|| Some(memory_stats()?.physical_mem)).unwrap_or(0)
}

fn high_water_mark() -> Option<usize> {
    kilobytes("/proc/self/status", "VmHWM:")
}

fn kilobytes(file: &str, row: &str) -> Option<usize> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(row))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok()? * 1024)
}
