//! `pfront stability`.

use super::{folder, out};
use std::fs;

#[test]
fn the_matrix_as_table_csv_and_charts() {
    let folder = folder();
    let asked = "stability --row few-nodes,contained --p 2,64 --csv m.csv";
    let table = out(folder.path(), asked);
    for part in ["few-nodes", "pfront, g = 16    passes 2 of 2 rows", "fails contained"] {
        assert!(table.contains(part), "no '{part}' in:\n{table}");
    }
    let lines = fs::read_to_string(folder.path().join("m.csv")).unwrap();
    // Two scenes of four frames, two numbers of workers, two methods.
    assert_eq!(lines.lines().count(), 1 + 2 * 4 * 2 * 2);
    let columns = |line: &str| line.split(',').count();
    assert!(
        lines.lines().skip(1).all(|line| columns(line) == columns(lines.lines().nth(1).unwrap()))
    );
}
