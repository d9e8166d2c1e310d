//! `pfront-lab judge` and `chart`, of very little.

use super::{command, folder, out, refused};
use std::fs;
use std::path::Path;

/// Standard output of a run without recorded data, which standard error must say.
fn generated(folder: &Path, arguments: &str) -> String {
    let output = command(folder, arguments).env_remove("PFRONT_DATA").output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {stderr}");
    assert!(
        stderr.starts_with("PFRONT_DATA is not set") && stderr.lines().count() == 1,
        "{stderr}"
    );
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn judging_ours_and_somebodys_answers() {
    let folder = folder();
    let at = folder.path();
    let table = generated(at, "judge --pairs 660 --seed 4 --out pairs.bin --gpu");
    assert!(table.contains("A: Exact: 0 of 660 missed (< 4.5e-3), 0 of 660 false hits"), "{table}");
    assert!(table.contains("E: ") && table.contains("left to the CPU: 0 of 660 missed"), "{table}");
    assert_eq!(table.lines().count(), 1 + 33 + 5 + 1);
    let again = out(at, "judge pairs.bin --gpu");
    assert_eq!(again, table);

    let bytes = fs::read(at.join("pairs.bin")).unwrap();
    let truths: Vec<u8> =
        bytes[bytes.len() - 660 * 73..].iter().skip(72).step_by(73).copied().collect();
    let hits = truths.iter().filter(|truth| **truth == 1).count();
    fs::write(at.join("right.bin"), &truths).unwrap();
    fs::write(at.join("never.bin"), [0; 660]).unwrap();
    let right = out(at, "judge pairs.bin --answers right.bin");
    assert!(right.contains("A: right.bin: 0 of 660 missed (< 4.5e-3), 0 of 660 false"), "{right}");
    let never = out(at, "judge pairs.bin --answers never.bin");
    assert!(never.contains(&format!("A: never.bin: {hits} of 660 missed, 0 of 660 ")), "{never}");

    fs::write(at.join("few.bin"), &truths[..659]).unwrap();
    fs::write(at.join("short.bin"), &bytes[..bytes.len() - 1]).unwrap();
    for (arguments, message) in [
        ("judge pairs.bin --answers few.bin", "few.bin: there are 659 answers to 660 pairs"),
        ("judge right.bin", "right.bin: at byte 0"),
        ("judge short.bin", "too few for the pairs"),
        ("judge nothing.bin", "cannot read nothing.bin"),
        ("judge pairs.bin --pairs 9", "cannot be used with"),
        ("judge --answers right.bin", "required"),
    ] {
        let refused = refused(at, arguments);
        assert!(refused.contains(message), "{arguments}: {refused}");
    }
}

#[test]
fn judging_in_f64() {
    let folder = folder();
    let table = out(folder.path(), "judge --in-f64 --pairs 29000");
    let total = |letter: &str| {
        let line = table.lines().find(|line| line.starts_with(letter)).unwrap();
        line.contains(" 0 of ") && line.matches(" 0 of ").count() == 2
    };
    // Rounding to f32 and plain f64 are both wrong.
    assert!(total("A: Exact, in f64") && !total("B: ") && !total("C: "), "{table}");
}

#[test]
fn charts_are_written() {
    let folder = folder();
    let at = folder.path();
    let summary = generated(at, "chart --out charts --quick --pairs 660 --size 8000");
    assert!(summary.starts_with("triangle pairs") && summary.contains("torus-knots"), "{summary}");
    let read = |file: &str| fs::read_to_string(at.join("charts").join(file)).unwrap();
    let svg = read("pareto.svg");
    for part in ["Guigue-Devillers, f64", "better: lower left", "ns per triangle pair"] {
        assert!(svg.contains(part), "no '{part}'");
    }
    assert!(read("pareto.csv").contains("sheet,1,pfront Exact,"));
}
