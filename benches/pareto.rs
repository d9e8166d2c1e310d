//! Speed against accuracy: the charts of `pfront chart`, with parry3d's own test among the textbook's.
//!
//! `cargo bench --bench pareto [-- --quick]` writes into `target/pareto`; with `--features pfront-study/gpu` a GPU takes
//! part, and with `PFRONT_DATA` (see test.sh) recorded meshes do.

#![expect(clippy::unwrap_used, reason = "a bench fails by panicking")]

use pfront_cli::recorded;
use pfront_study::chart::frames::Machine;
use pfront_study::chart::{Charts, Plan};
use std::path::Path;

fn main() {
    let is_asked = |name| std::env::args().any(|argument| argument == name);
    let plan = match (is_asked("--test"), is_asked("--quick")) {
        (true, _) => Plan { pairs: 4_000, frames: 1, rounds: 1 },
        (_, true) => Plan::QUICK,
        _ => Plan::FULL,
    };
    let size = is_asked("--test").then_some(8_000);
    let suite = recorded::suite(1, size).unwrap();
    let tell = |what: &str| eprintln!("{what}");
    let charts = Charts::measure(&suite, &plan, &Machine::this(), tell).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/pareto");
    charts.write(&folder).unwrap();
    println!("{}in {}", charts.summary(), folder.display());
}
