//! The header in the repository is that of the sources.

use std::{env, fs, path::Path};

/// In the order of the header.
const MODULES: [&str; 26] = [
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
    "executor",
    "subject",
    "relation",
    "impacts",
    "segment",
    "scene",
    "scene/hits",
    "scene/impacts",
    "scene/bodies",
    "scene/check",
    "scene/segments",
];

#[test]
fn the_header_is_up_to_date() {
    /// A module after the attribute `entry`, as far as cbindgen reads it.
    fn exported(source: &str) -> String {
        let mut functions = source.split("#[entry]\n");
        let mut exported = functions.next().unwrap().to_owned();
        for function in functions {
            let (head, body) = function.split_once(" {\n").unwrap();
            let head = match head.strip_suffix(") -> Done") {
                None => head.replacen("fn ", "pub extern \"C\" fn ", 1),
                Some(head) => {
                    let (name, parameters) = head.split_once("call: &mut Call<'_>,").unwrap();
                    let name = name.replacen("fn ", "pub unsafe extern \"C\" fn ", 1);
                    let comma = if parameters.ends_with('\n') { "" } else { "," };
                    format!(
                        "{name}{parameters}{comma} error: *mut pfront_error_t) -> pfront_status_t"
                    )
                }
            };
            exported += &format!("#[unsafe(no_mangle)]\n{head} {{\n{body}");
        }
        exported
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let out = &Path::new(env!("CARGO_TARGET_TMPDIR")).join("header");
    // Files of an earlier run may be modules to cbindgen.
    if out.exists() {
        fs::remove_dir_all(out).unwrap();
    }
    fs::create_dir(out).unwrap();
    let builder = MODULES.iter().fold(cbindgen::Builder::new(), |builder, module| {
        let source = fs::read_to_string(folder.join(format!("src/{module}.rs"))).unwrap();
        // A name that no `mod` of another leads to, or cbindgen would read it twice.
        let path = out.join(format!("of-{}.rs", module.replace('/', "-")));
        fs::write(&path, exported(&source)).unwrap();
        builder.with_src(path)
    });
    let mut header = Vec::new();
    let [major, minor, patch] = [
        env!("CARGO_PKG_VERSION_MAJOR"),
        env!("CARGO_PKG_VERSION_MINOR"),
        env!("CARGO_PKG_VERSION_PATCH"),
    ];
    config.after_includes = Some(format!(
        "
// The version of this header; `pfront_version` tells that of the library.
#define PFRONT_VERSION_MAJOR {major}
#define PFRONT_VERSION_MINOR {minor}
#define PFRONT_VERSION_PATCH {patch}
#define PFRONT_VERSION \"{}\"",
        env!("CARGO_PKG_VERSION")
    ));
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

/// The verbs of a scene that C has by another name, or has no use for.
const BY_ANOTHER_NAME: [(&str, &str); 17] = [
    // A limit that is INFINITY is none.
    ("distance_below", "pfront_scene_distance"),
    ("new", "pfront_scene_create"),
    ("on", "pfront_scene_create"),
    ("all", "pfront_scene_update"),
    ("hits", "pfront_scene_update"),
    ("last_contacts", "pfront_scene_contacts"),
    ("add_with", "pfront_scene_add"),
    ("set_options", "pfront_scene_set_groups"),
    ("body", "pfront_scene_user_data"),
    // C keeps the numbers of bodies, and what it ignores.
    ("bodies", "pfront_scene_add"),
    ("len", "pfront_scene_add"),
    ("is_empty", "pfront_scene_add"),
    ("ignored", "pfront_scene_ignore"),
    // Counts, times and who answered are for those who tune.
    ("report", "pfront_executor_create"),
    ("plan", "pfront_executor_create"),
    ("add", "pfront_scene_add"),
    ("set_positions", "pfront_scene_set_positions_f64"),
];

/// The names of the public methods of a source.
fn methods(source: &str) -> impl Iterator<Item = &str> {
    let lines = source.lines().filter_map(|line| line.strip_prefix("    pub fn "));
    lines.filter_map(|rest| rest.split(['(', '<']).next())
}

#[test]
fn every_verb_of_a_scene_and_of_models_is_there() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = fs::read_to_string(folder.join("include/pfront.h")).unwrap();
    let has = |function: &str| header.contains(&format!("{function}("));
    let files = ["mod.rs", "edit.rs", "nearest.rs", "check.rs", "segment.rs", "impacts.rs"];
    for file in files.map(|file| format!("scene/{file}")) {
        let source = fs::read_to_string(folder.join("../src").join(file)).unwrap();
        for verb in methods(&source) {
            let other = BY_ANOTHER_NAME.iter().find(|(name, _)| *name == verb);
            let function =
                other.map_or(format!("pfront_scene_{verb}"), |(_, name)| (*name).to_owned());
            assert!(has(&function), "SceneQuery::{verb} is not in C as {function}");
        }
    }
    // These have no counterpart: C takes a mesh in its own memory step by step, and forgets by a new query.
    let elsewhere =
        ["new", "on", "visit", "report", "forget", "plan", "contacts_f64", "distance_below"];
    for file in ["pair.rs", "relation.rs", "impacts.rs"] {
        let pair = fs::read_to_string(folder.join("../src").join(file)).unwrap();
        for verb in methods(&pair).filter(|verb| !elsewhere.contains(verb)) {
            assert!(has(&format!("pfront_model_query_{verb}")), "PairQuery::{verb} is not in C");
        }
    }
}
