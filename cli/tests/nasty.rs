//! The meshes of `nasty/`, which have broken other libraries, through every command: the right answer or a
//! clear refusal, within bounds of time and memory.
//!
//! They run with `--features recorded`; the data is looked for in `$PFRONT_DATA`, else in `../shared/data`
//! beside the checkout.

#![cfg(unix)]
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod capped;

use capped::{FEW, run};
use pfront_cli::mesh::read;
use pfront_testkit::oracle::{self_pairs, share_a_vertex};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// The files that are no meshes.
const REFUSED: [&str; 1] = ["notenoughindices.obj"];

/// Larger meshes, with 48 million overlapping boxes, are asked less.
const LARGE: usize = 10_000;

fn nasty() -> PathBuf {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let data = std::env::var_os("PFRONT_DATA").map_or_else(|| beside.into(), PathBuf::from);
    let nasty = data.join("nasty");
    assert!(
        nasty.exists(),
        "no {}: set PFRONT_DATA to the folder with nasty/, or run without --features recorded",
        nasty.display()
    );
    nasty
}

fn files() -> Vec<String> {
    let entries = fs::read_dir(nasty()).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort_unstable();
    assert_eq!(names.len(), 25);
    names
}

/// The lines after the first of a table in csv.
fn pairs(csv: &str) -> Vec<(u32, u32)> {
    let pair = |line: &str| {
        let (a, b) = line.split_once(',').unwrap();
        (a.parse().unwrap(), b.parse().unwrap())
    };
    csv.lines().skip(1).map(pair).collect()
}

#[test]
fn with_themselves() {
    let folder = TempDir::new().unwrap();
    for name in files() {
        let path = nasty().join(&name);
        let file = path.to_str().unwrap();
        let ask = |arguments: &str| run(folder.path(), &format!("{arguments} {FEW}"));
        if REFUSED.contains(&&*name) {
            for command in ["self", "self --weld", "any good.obj"] {
                let error = ask(&format!("{command} {file}")).unwrap_err();
                assert!(command.starts_with("any") || error.contains(&name), "{error}");
            }
            continue;
        }
        let mesh = read(&path).unwrap();
        let found = pairs(&ask(&format!("self {file} --format csv")).unwrap());
        assert!(ask(&format!("any {file} {file}")).unwrap().ends_with("meet\n"), "{name}");
        if mesh.triangles.len() > LARGE {
            continue;
        }
        let skipped = ask(&format!("self {file} --format csv --skip-neighbours")).unwrap();
        // Larger ones `tests/recorded.rs` asks of the oracle, which takes its time.
        if mesh.triangles.len() < 1_000 {
            let truth = self_pairs(&mesh.positions, &mesh.triangles);
            assert_eq!(found, truth, "{name}");
        }
        let strangers = |&(a, b): &(u32, u32)| {
            !share_a_vertex(mesh.triangles[a as usize], mesh.triangles[b as usize])
        };
        let strangers: Vec<_> = found.iter().copied().filter(strangers).collect();
        assert_eq!(pairs(&skipped), strangers, "{name}");
        ask(&format!("self {file} --weld --contacts --format json")).unwrap();

        // Each triangle meets itself, and the picture has both meshes.
        let far = format!("any {file} {file} --translate 1e9,0,0");
        assert_eq!(ask(&far).unwrap(), "nothing meets\n", "{name}");
        let drawn = ask(&format!("pairs {file} {file} --out hits.ply")).unwrap();
        let count: usize = drawn.split_once(' ').unwrap().0.parse().unwrap();
        assert!(count >= mesh.triangles.len(), "{name}: {drawn}");
        let picture = read(&folder.path().join("hits.ply")).unwrap();
        assert_eq!(picture.triangles.len(), 2 * mesh.triangles.len(), "{name}");
    }
}

/// Counts are those of `tests/data/mod.rs`; the last pair has 48 million overlapping boxes.
#[test]
fn with_each_other() {
    let folder = TempDir::new().unwrap();
    for (a, b, count) in [
        ("ballA.off", "ballB.off", 276),
        ("self_intersectA.obj", "self_intersectB.obj", 600),
        ("Offset3.obj", "Offset4.obj", 27),
        ("Havocglass8_left.obj", "Havocglass8_right.obj", 95),
        ("center_cylinder.obj", "offset_cylinder.obj", 72),
        ("Generic_Twin_7081.1.t0_left.obj", "Generic_Twin_7081.1.t0_right.obj", 1239),
    ] {
        let [s, t] = [a, b].map(|name| nasty().join(name));
        let both = format!("{} {}", s.display(), t.display());
        let csv = run(folder.path(), &format!("pairs {both} --format csv {FEW}")).unwrap();
        assert_eq!(pairs(&csv).len(), count, "{a} and {b}");
        let any = run(folder.path(), &format!("any {both} {FEW}")).unwrap();
        assert!(any.ends_with("meet\n"), "{a} and {b}: {any}");
    }
}
