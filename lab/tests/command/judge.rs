//! `pfront-lab judge` and `chart`, of very little.

use super::{folder, out};
use std::fs;

#[test]
fn ours_keep_their_promises() {
    let table = out(folder().path(), "judge --pairs 660 --seed 4 --gpu");
    assert!(table.contains("A: Exact: 0 of 660 missed (< 4.5e-3), 0 of 660 false hits"), "{table}");
    assert!(table.contains("D: ") && table.contains("left to the CPU: 0 of 660 missed"), "{table}");
    assert_eq!(table.lines().count(), 1 + 33 + 4 + 1);
}

#[test]
fn judging_in_f64() {
    let table = out(folder().path(), "judge --in-f64 --pairs 29000");
    let total = |letter: &str| {
        let line = table.lines().find(|line| line.starts_with(letter)).unwrap();
        line.contains(" 0 of ") && line.matches(" 0 of ").count() == 2
    };
    // Rounding to f32 and plain f64 are both wrong.
    assert!(total("A: Exact, in f64") && !total("B: ") && !total("C: "), "{table}");
}

/// Tests that are faster than ours are wrong; how fast they are is measured on a quiet machine, and not here.
#[test]
fn charts_have_a_line_for_each_test_of_each_set() {
    let folder = folder();
    let at = folder.path();
    let table = out(at, "chart pareto.csv --pairs 66000 --rounds 1 --size 8000");
    let line = |source: &str, test: &str| {
        let line = table.lines().find(|line| line.starts_with(&format!("{source}: {test}")));
        let numbers = line.unwrap().split_whitespace().rev().take(2);
        numbers.map(|number| number.parse::<f64>().unwrap()).sum::<f64>()
    };
    assert_eq!([line("family", "Exact "), line("contact", "Exact ")], [0.0; 2], "{table}");
    for test in ["Möller 1997, ε = 1", "Möller 1997, ε = 0", "Guigue-Devillers, f32"] {
        assert!(line("family", test) > 0.0, "{test}: {table}");
    }
    for test in ["Guigue-Devillers, f64", "17 separating axes", "parry3d's own", "Fast"] {
        assert!(line("family", test) > 0.0, "{test}: {table}");
    }
    assert!(line("family in f64", "Guigue-Devillers, f64") > 0.0, "{table}");
    let csv = fs::read_to_string(at.join("pareto.csv")).unwrap();
    assert!(csv.contains("sheet,contact,Exact,"), "{csv}");
}
