//! `pfront impacts`: what meets on the way.

use super::{folder, out, pfront, refused};
use std::fs;

/// A wall in the plane y = 0, a small triangle before it, and the same behind it.
#[test]
fn what_flies_through_a_wall_hits_it() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("wall.obj"), "v -1 0 -1\nv 1 0 -1\nv 0 0 2\nf 1 2 3\n").unwrap();
    let bullet = |y: &str| format!("v 0 {y} 0\nv 0.01 {y} 0\nv 0 {y} 0.01\nf 1 2 3\n");
    fs::write(at.join("before.obj"), bullet("0.25")).unwrap();
    fs::write(at.join("behind.obj"), bullet("-0.75")).unwrap();
    for end in
        ["--translate-end 0,-1,0", "--end-b behind.obj", "--pose-end 1,0,0,0,0,1,0,-1,0,0,1,0"]
    {
        for first in ["", " --first"] {
            let said = out(at, &format!("impacts wall.obj before.obj {end}{first}"));
            let row: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
            let [a, b, from, to] = row[..] else { panic!("{said}") };
            assert!(
                (a, b) == (0.0, 0.0) && from <= 0.25 && 0.25 <= to && to < from + 1e-6,
                "{said}"
            );
        }
    }
    let found: serde_json::Value =
        serde_json::from_str(&out(at, "impacts wall.obj before.obj --translate-end 0,-1,0 --json"))
            .unwrap();
    assert_eq!((&found["count"], &found["impacts"][0]["a"]), (&1.into(), &0.into()));
    assert_eq!(found["files"].as_array().unwrap().len(), 2);
    // It stops before the wall.
    let short = "impacts wall.obj before.obj --translate-end 0,-0.2,0";
    assert_eq!(out(at, short), "");
    assert_eq!(pfront(at, &format!("{short} --first")).status.code(), Some(1));
    // It stops upon the wall, which the test at the end decides.
    let upon = out(at, "impacts wall.obj before.obj --translate-end 0,-0.25,0");
    assert_eq!(upon.lines().count(), 1, "{upon}");
}

#[test]
fn a_mesh_that_deforms_meets_itself() {
    let folder = folder();
    let at = folder.path();
    let sheets = |z: f64| {
        let sheet = |z: f64| format!("v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\n");
        sheet(0.0) + &sheet(z) + "f 1 2 3\nf 4 5 6\n"
    };
    fs::write(at.join("above.obj"), sheets(0.5)).unwrap();
    fs::write(at.join("below.obj"), sheets(-0.5)).unwrap();
    let said = out(at, "impacts above.obj --end-a below.obj");
    assert!(said.starts_with("0 1 0.4") || said.starts_with("0 1 0.5"), "{said}");
    assert!(refused(at, "impacts above.obj").contains("one mesh alone has to move"));
    assert!(refused(at, "impacts above.obj --end-a a.obj").contains("a.obj"));
    assert!(refused(at, "impacts above.obj --translate-end 0,0,1").contains("<B>"));
}
