//! The header in the repository is that of the sources.

use std::{env, fs, path::Path};

/// In the order of the header.
const MODULES: [&str; 17] = [
    "status",
    "pose",
    "mesh",
    "buffers",
    "build",
    "bvh",
    "blob",
    "one_ring",
    "query",
    "cursor",
    "verbs",
    "front",
    "allocator",
    "meshes",
    "model",
    "scene",
    "scene/hits",
];

#[test]
fn the_header_is_up_to_date() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let builder = MODULES.iter().fold(cbindgen::Builder::new(), |builder, module| {
        builder.with_src(folder.join(format!("src/{module}.rs")))
    });
    let mut header = Vec::new();
    builder.with_config(config).generate().unwrap().write(&mut header);
    let (header, path) = (String::from_utf8(header).unwrap(), folder.join("include/pfront.h"));
    if env::var_os("PFRONT_WRITE_HEADER").is_some() {
        fs::write(&path, &header).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    let differs = header.lines().zip(kept.lines()).position(|(new, old)| new != old);
    assert!(
        header == kept,
        "include/pfront.h is not up to date from line {} on: PFRONT_WRITE_HEADER=1 cargo test --test header",
        differs.unwrap_or(header.lines().count().min(kept.lines().count())) + 1
    );
}
