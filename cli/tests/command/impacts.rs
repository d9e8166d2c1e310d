//! `pfront impacts`: what meets on the way.

use super::within::json;
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
        for which in ["", " --first", " --any"] {
            let said = out(at, &format!("impacts wall.obj before.obj {end}{which}"));
            let row: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
            let [a, b, from, to] = row[..] else { panic!("{said}") };
            assert!(
                (a, b) == (0.0, 0.0) && from <= 0.25 && 0.25 <= to && to < from + 1e-6,
                "{said}"
            );
        }
    }
    let through = "impacts wall.obj before.obj --translate-end 0,-1,0";
    for which in ["", " --first", " --any"] {
        let found = json(at, &format!("{through} --json{which}"));
        assert_eq!((&found["count"], &found["impacts"][0]["a"]), (&1.into(), &0.into()));
        assert_eq!(found["files"].as_array().unwrap().len(), 2);
        assert!(found.get("within").is_none());
    }
    assert_eq!(out(at, &format!("{through} --count")), "1 pair\n");
    let counts = json(at, &format!("{through} --count --json"));
    assert_eq!((&counts["count"], &counts["proven"]), (&1.into(), &1.into()));
    for both in ["--first --any", "--first --count", "--any --count"] {
        assert!(refused(at, &format!("{through} {both}")).contains("cannot be used with"));
    }
    // It stops before the wall.
    let short = "impacts wall.obj before.obj --translate-end 0,-0.2,0";
    assert_eq!(out(at, short), "");
    assert_eq!(out(at, &format!("{short} --count")), "0 pairs\n");
    for which in ["--first", "--any"] {
        assert_eq!(pfront(at, &format!("{short} {which}")).status.code(), Some(1));
        let none = pfront(at, &format!("{short} {which} --json"));
        let said: serde_json::Value = serde_json::from_slice(&none.stdout).unwrap();
        assert_eq!((none.status.code(), &said["count"]), (Some(1), &0.into()));
        // It comes as near as 0.05.
        let near = out(at, &format!("{short} {which} --within 0.125"));
        assert!(near.starts_with("0 0 0.62"), "{near}");
    }
    assert_eq!(out(at, &format!("{short} --count --within 0.125")), "1 pair\n");
    let near = json(at, &format!("{short} --within 0.125 --json"));
    assert_eq!((&near["count"], &near["within"]), (&1.into(), &0.125.into()));
    assert_eq!(out(at, &format!("{short} --within 0.04")), "");
    // It stops upon the wall, which the test at the end decides.
    let upon = out(at, "impacts wall.obj before.obj --translate-end 0,-0.25,0");
    assert_eq!(upon.lines().count(), 1, "{upon}");
}

/// Triangles that slide over each other in one plane, and perhaps one more that goes through.
#[test]
fn what_is_open_is_said() {
    let folder = folder();
    let at = folder.path();
    let triangle = |x: i32, y: i32, z: i32| {
        format!("v {x} {y} {z}\nv {} {y} {z}\nv {x} {} {z}\n", x + 2, y + 2)
    };
    let faces = "f 1 2 3\nf 4 5 6\n";
    let file = |name: &str, first: [i32; 3], second: [i32; 3]| {
        let [first, second] = [first, second].map(|[x, y, z]| triangle(x, y, z));
        fs::write(at.join(name), first + &second + faces).unwrap();
    };
    file("floor.obj", [0, 0, 0], [9, 0, 0]);
    file("start.obj", [-3, 0, 0], [9, 0, 1]);
    file("beside.obj", [3, 0, 0], [9, 0, 1]);
    file("through.obj", [3, 0, 0], [9, 0, -1]);
    for (end, counts, rows) in [("beside", [0, 1], "1"), ("through", [1, 2], "2")] {
        let asked = format!("impacts floor.obj start.obj --end-b {end}.obj");
        let said = |options: &str| {
            let run = pfront(at, &format!("{asked} {options}"));
            assert_eq!(run.status.code(), Some(0), "{options}");
            [run.stdout, run.stderr].map(|text| String::from_utf8(text).unwrap())
        };
        let [count, why] = said("--count");
        assert_eq!(count.split(" pair").next(), Some(&*format!("{} to {}", counts[0], counts[1])));
        assert!(why.starts_with(&format!("1 of {rows} are open: they touch")), "{why}");
        let found = json(at, &format!("{asked} --count --json"));
        assert_eq!((&found["proven"], &found["count"]), (&counts[0].into(), &counts[1].into()));
        // Some pair is one that certainly meets, if there is one.
        let [any, why] = said("--any");
        assert_eq!((any.ends_with("inf\n"), why.is_empty()), (counts[0] == 0, counts[0] > 0));
    }
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
    assert_eq!(out(at, "impacts above.obj --end-a below.obj --any"), said);
    assert_eq!(out(at, "impacts above.obj --end-a below.obj --count"), "1 pair\n");
    assert!(out(at, "impacts above.obj --end-a below.obj --within 0.25").starts_with("0 1 0.2"));
    assert!(refused(at, "impacts above.obj").contains("one mesh alone has to move"));
    assert!(refused(at, "impacts above.obj --end-a a.obj").contains("a.obj"));
    assert!(refused(at, "impacts above.obj --translate-end 0,0,1").contains("<B>"));
}
