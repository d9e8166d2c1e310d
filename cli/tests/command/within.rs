//! `--within`: pairs of triangles at most so far apart; and how far apart meshes are.

use super::{folder, out, pfront, refused};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const FLOOR: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A triangle, and another above it: 0.02 in decimals, which no f32 is.
fn apart() -> TempDir {
    let folder = folder();
    fs::write(folder.path().join("low.obj"), FLOOR).unwrap();
    fs::write(folder.path().join("high.obj"), FLOOR.replace(" 0\n", " 0.02\n")).unwrap();
    folder
}

pub(super) fn json(at: &Path, arguments: &str) -> serde_json::Value {
    serde_json::from_str(&out(at, arguments)).unwrap()
}

#[test]
fn two_triangles_above_each_other() {
    let folder = apart();
    let at = folder.path();
    assert_eq!(out(at, "pairs low.obj high.obj --csv"), "a,b\n");
    assert_eq!(out(at, "pairs low.obj high.obj --csv --within 0"), "a,b\n");
    assert_eq!(out(at, "pairs low.obj high.obj --csv --within 0.0199999"), "a,b\n");
    // The f32 nearest to 0.02 is less.
    assert_eq!(out(at, "pairs low.obj high.obj --csv --within 0.02"), "a,b\n0,0\n");
    let found = json(at, "pairs low.obj high.obj --json --within 0.02");
    assert_eq!((&found["count"], &found["pairs"][0]), (&1.into(), &serde_json::json!([0, 0])));
    assert!(
        out(at, "pairs low.obj high.obj --json --within 0.5")
            .contains("],\"within\":0.5,\"pairs\":")
    );
    assert!(found["within"].as_f64().unwrap() > 0.02, "{found}");
    assert!(json(at, "pairs low.obj high.obj --json").get("within").is_none());
    let failed = pfront(at, "pairs low.obj high.obj --within 0.02 --fail");
    assert_eq!(failed.status.code(), Some(1));
}

#[test]
fn contacts_are_those_of_what_intersects() {
    let folder = apart();
    let at = folder.path();
    let contacts = out(at, "pairs a.obj b.obj --contacts --csv");
    assert_eq!(contacts.lines().count(), 3);
    assert_eq!(out(at, "pairs a.obj b.obj --contacts --csv --within 0.9"), contacts);
    assert_eq!(out(at, "pairs a.obj b.obj --csv --within 0.9").lines().count(), 5);
    assert_eq!(json(at, "scene a.obj b.obj --json --contacts --within 0.9")["count"], 2);
    assert_eq!(json(at, "scene low.obj high.obj --json --contacts --within 1")["count"], 0);
}

#[test]
fn every_question_takes_a_distance() {
    let folder = apart();
    let at = folder.path();
    let none = pfront(at, "any low.obj high.obj --within 0.01");
    assert_eq!(
        (none.status.code(), &none.stdout[..]),
        (Some(1), &b"nothing is within the distance\n"[..])
    );
    assert_eq!(pfront(at, "any low.obj high.obj").stdout, b"nothing meets\n");
    let near = out(at, "any low.obj high.obj --within 0.02");
    assert_eq!(near, "triangles 0 and 0 are within the distance\n");
    let found = json(at, "any low.obj high.obj --within 0.25 --json");
    assert_eq!((&found["within"], &found["pair"]), (&0.25.into(), &serde_json::json!([0, 0])));

    let high = FLOOR.replace(" 0\n", " 0.02\n").replace("f 1 2 3", "f 4 5 6");
    fs::write(at.join("both.obj"), format!("o low\n{FLOOR}o high\n{high}")).unwrap();
    assert_eq!(out(at, "self both.obj --csv"), "a,b\n");
    assert_eq!(out(at, "self both.obj --csv --within 0.02"), "a,b\n0,1\n");
    assert_eq!(json(at, "self both.obj --json --within 0.25")["within"], 0.25);
    // Triangles that share a vertex are decided as before.
    assert_eq!(out(at, "self a.obj --csv --within 5"), "a,b\n");
    assert_eq!(out(at, "scene both.obj --csv"), "body_a,body_b,a,b\n");
    assert_eq!(out(at, "scene both.obj --csv --within 0.02"), "body_a,body_b,a,b\nlow,high,0,0\n");
    let bodies = json(at, "scene both.obj --bodies --json --within 0.25");
    assert_eq!((&bodies["within"], &bodies["count"]), (&0.25.into(), &1.into()));
}

#[test]
fn distances_that_are_none() {
    let folder = apart();
    for question in [
        "pairs low.obj high.obj",
        "any low.obj high.obj",
        "self low.obj",
        "scene low.obj",
        "impacts low.obj high.obj",
    ] {
        for bad in ["-1", "-1e-300", "nan", "inf", "1e300"] {
            let error = refused(folder.path(), &format!("{question} --within {bad}"));
            assert!(error.contains("a distance must be finite and not negative"), "{error}");
        }
        let error = refused(folder.path(), &format!("{question} --within near"));
        assert!(error.contains("not a number"), "{error}");
    }
}

#[test]
fn help_says_what_contacts_are() {
    let folder = folder();
    for command in ["pairs", "any", "self", "scene"] {
        let help = out(folder.path(), &format!("{command} --help"));
        let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("rounded up to f32, so that no pair is missed"), "{help}");
        assert!(words.contains("Contacts and curves are those of pairs that intersect"), "{help}");
    }
}

#[test]
fn how_far_apart_two_meshes_are() {
    let folder = apart();
    let at = folder.path();
    let found = json(at, "distance low.obj high.obj --json");
    let (low, high) =
        (found["distance"][0].as_f64().unwrap(), found["distance"][1].as_f64().unwrap());
    assert!(low <= 0.02 && 0.02 <= high && high - low < 1e-8, "{found}");
    assert_eq!(
        (&found["pair"], &found["points"][1][2]),
        (&serde_json::json!([0, 0]), &0.02.into())
    );
    let said = out(at, "distance low.obj high.obj");
    assert!(said.contains(" to 0.02") && said.contains("triangles 0 and 0, from "), "{said}");
    assert!(out(at, "distance low.obj low.obj").starts_with("0, as triangles 0 and 0 meet at "));
    // The limit is rounded up, and is exact.
    assert_eq!(pfront(at, "distance low.obj high.obj --within 0.02").status.code(), Some(0));
    let farther = pfront(at, "distance low.obj high.obj --json --within 0.0199999");
    assert_eq!(farther.status.code(), Some(1));
    let said: serde_json::Value = serde_json::from_slice(&farther.stdout).unwrap();
    assert!(said["distance"].is_null() && said["pair"].is_null() && said["within"].is_number());
}
