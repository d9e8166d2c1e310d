//! The dependencies of the core are part of its contract.

use std::collections::BTreeSet;
use std::error::Error;
use std::process::Command;

/// Crates that `pfront-core` may link: libm is glam's float functions where there is no std, thiserror a few lines of the error types.
const LINKED: [&str; 5] = ["bytemuck", "glam", "libm", "pfront-core", "thiserror"];

/// Dependencies of the derive macros of bytemuck and thiserror, which run in the compiler and are gone afterwards.
const MACRO: [&str; 6] =
    ["bytemuck_derive", "proc-macro2", "quote", "syn", "thiserror-impl", "unicode-ident"];

/// Packages that `pfront-core` is built from on any target, a line each with the features in force:
/// `glam v0.34.2|f64,libm`. A package met again ends in ` (*)`.
fn tree() -> Result<String, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into());
    let output = Command::new(cargo)
        .args(["tree", "--package", "pfront-core", "--edges", "normal"])
        .args(["--target", "all", "--prefix", "none", "--locked", "--offline"])
        .args(["--format", "{p}|{f}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()?;
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8(output.stdout)?)
}

#[test]
fn the_core_depends_on_three_small_crates_only() {
    let tree = tree().unwrap();
    let found: BTreeSet<_> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    let promised: BTreeSet<_> = LINKED.into_iter().chain(MACRO).collect();
    assert_eq!(
        found, promised,
        "the packages under pfront-core changed: take the dependency out of core/Cargo.toml, or, if \
         it is one of glam, bytemuck or thiserror themselves, list it here"
    );
}

#[test]
fn the_core_takes_no_std_unless_asked() {
    let tree = tree().unwrap();
    let asks = |line: &&str| {
        let features = line.rsplit('|').next().unwrap().trim_end_matches(" (*)");
        features.split(',').any(|f| f.ends_with("std") || f.ends_with("alloc"))
    };
    let found: Vec<_> = tree.lines().filter(asks).collect();
    assert!(found.is_empty(), "{found:?}: keep it off the default features in core/Cargo.toml");
}
