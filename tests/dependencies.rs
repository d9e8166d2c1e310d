//! What the core depends on is part of what it promises.

use std::collections::BTreeSet;
use std::process::Command;

/// Packages that `pfront-core` builds with, by `cargo tree`.
fn packages(arguments: &[&str]) -> BTreeSet<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["tree", "-p", "pfront-core", "--prefix", "none", "--format", "{p}"])
        .args(["--edges", "normal", "--target", "all"])
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    let output = output.unwrap_or_else(|e| unreachable!("cargo tree did not start: {e}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = String::from_utf8_lossy(&output.stdout).into_owned();
    names.lines().filter_map(|line| Some(line.split(' ').next()?.to_owned())).collect()
}

/// glam and bytemuck, and what they need: libm where there is no std, and the derive macro, which is
/// gone once the code is built.
#[test]
fn the_core_depends_on_glam_and_bytemuck() {
    let library = ["bytemuck", "glam", "libm", "pfront-core"];
    let macros = ["bytemuck_derive", "proc-macro2", "quote", "syn", "unicode-ident"];
    let allowed: BTreeSet<String> = library.iter().chain(&macros).map(|s| s.to_string()).collect();
    let found = packages(&[]);
    let stray: Vec<_> = found.difference(&allowed).collect();
    assert!(stray.is_empty(), "pfront-core must not depend on {stray:?}; see design.md");
    assert!(["bytemuck", "glam", "libm"].iter().all(|name| found.contains(*name)), "{found:?}");
}
