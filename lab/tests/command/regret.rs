//! `pfront-lab regret`.

use super::{folder, out};
use std::fs;

#[test]
fn regret_of_a_few_cases() {
    let folder = folder();
    let at = folder.path();
    let facts = |on: &str| {
        let asked = format!("regret --quick --cases 4 --seed 5 --threads 2 --csv r.csv {on}");
        let table = out(at, &asked);
        for part in
            ["seed 5, 2 threads", "pair 1", "self 3", "scene 4", "4 cases", "naive rule  mean"]
        {
            assert!(table.contains(part), "no '{part}' in:\n{table}");
        }
        let csv = fs::read_to_string(at.join("r.csv")).unwrap();
        let head = csv.lines().next().unwrap();
        assert_eq!(head.contains(",GPU_ms,"), on.contains("gpu"), "{head}");
        let facts = |line: &str| line.split(',').take(6).collect::<Vec<_>>().join(",");
        csv.lines().skip(1).map(facts).collect::<Vec<_>>()
    };
    let cpu = facts("--backend cpu");
    assert_eq!(cpu.len(), 4);
    assert_eq!(cpu, facts("--backend gpu --rounds 2"));
    let played = out(at, "regret --workload worm-gear --frames 5 --rounds 1 --backend cpu");
    assert!(played.contains("worm-gear") && played.contains("1 cases"), "{played}");
}
