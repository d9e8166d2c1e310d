//! `pfront-lab stability`.

use super::{folder, out};

#[test]
fn the_matrix_is_a_table() {
    let table = out(folder().path(), "stability --row few-nodes,contained --p 2,64");
    for part in ["few-nodes", "pfront, g = 16    passes 2 of 2 rows", "fails contained"] {
        assert!(table.contains(part), "no '{part}' in:\n{table}");
    }
}
