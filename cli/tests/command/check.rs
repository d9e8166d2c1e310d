//! `pfront check`: is an assembly right?

use super::{folder, pfront, refused};
use std::fs;
use std::path::Path;

/// A cube as OBJ, by its lowest corner and its edge.
fn cube([x, y, z]: [f64; 3], edge: f64) -> String {
    let corner = |k: u32| {
        let at = |bit: u32, from: f64| from + edge * f64::from(k >> bit & 1);
        format!("v {} {} {}\n", at(0, x), at(1, y), at(2, z))
    };
    let sides = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    (0..8).map(corner).collect::<String>() + sides
}

/// Standard output, and the exit code.
fn check(at: &Path, arguments: &str) -> (String, i32) {
    let run = pfront(at, &format!("check {arguments}"));
    (String::from_utf8(run.stdout).unwrap(), run.status.code().unwrap())
}

fn json(at: &Path, arguments: &str) -> (serde_json::Value, i32) {
    let (text, code) = check(at, &format!("{arguments} --json"));
    (serde_json::from_str(&text).unwrap(), code)
}

#[test]
fn an_assembly_in_words_and_numbers() {
    let folder = folder();
    let at = folder.path();
    for (name, place, edge) in [
        ("plate", [0.0; 3], 4.0),
        ("flush", [4.0, 0.0, 0.0], 2.0),
        ("clash", [3.5, 3.5, 3.5], 1.0),
        ("inside", [1.0; 3], 1.0),
        ("near", [-1.25, 0.0, 0.0], 1.0),
    ] {
        fs::write(at.join(format!("{name}.obj")), cube(place, edge)).unwrap();
    }
    let (text, code) = check(at, "plate.obj flush.obj");
    assert_eq!(
        (text.as_str(), code),
        ("2 bodies, 1 pair of them whose boxes overlap, 0 not allowed\n", 0)
    );
    let (text, code) = check(at, "plate.obj clash.obj");
    assert!(text.starts_with("plate.obj  clash.obj  crossing  volume ") && code == 1, "{text}");
    for allowed in ["--allow crossing", "--allow-overlap 0.126", "--ignore plate* c?ash.obj"] {
        assert_eq!(check(at, &format!("plate.obj clash.obj {allowed}")).1, 0, "{allowed}");
    }
    assert_eq!(check(at, "plate.obj clash.obj --allow-overlap 0.124").1, 1);

    let (found, code) = json(at, "plate.obj clash.obj inside.obj near.obj --clearance 0.5");
    assert_eq!(code, 1);
    assert_eq!(found["counts"], serde_json::json!({"b_in_a": 1, "crossing": 1, "near": 1}));
    assert_eq!(
        (&found["allowed"], &found["bodies"][0]["name"]),
        (&false.into(), &"plate.obj".into())
    );
    for pair in found["pairs"].as_array().unwrap() {
        let interval = |name: &str| {
            let of = |k: usize| pair[name][k].as_f64().unwrap();
            (of(0), of(1))
        };
        match pair["b"].as_str().unwrap() {
            "clash.obj" => {
                let (low, high) = interval("overlap_volume");
                assert!(low <= 0.125 && 0.125 <= high && high - low < 1e-9, "{pair}");
                assert!(pair["place"][0].as_f64().unwrap() >= 3.5, "{pair}");
                // A face of the file is two triangles.
                for k in 0..2 {
                    let number = |name: &str| pair[name][k].as_u64().unwrap();
                    assert_eq!(number("faces"), number("triangles") / 2, "{pair}");
                }
                assert!(pair.get("gap").is_none());
            }
            "near.obj" => {
                let (low, high) = interval("gap");
                assert!(low <= 0.25 && 0.25 <= high && high - low < 1e-6, "{pair}");
            }
            _ => assert!(pair["relation"] == "b_in_a" && pair.get("place").is_none(), "{pair}"),
        }
    }
    // The flush side, and the outline of a corner in another.
    let (found, _) = json(at, "plate.obj flush.obj clash.obj --patches");
    let pairs = found["pairs"].as_array().unwrap();
    for (pair, [dimension, length, area]) in pairs.iter().zip([[2.0, 8.0, 4.0], [1.0, 3.0, 0.0]]) {
        let contact = &pair["contact"];
        assert_eq!(
            (&contact["dimension"], &contact["regions"]),
            (&(dimension as u64).into(), &1.into())
        );
        for (name, expected) in [("length", length), ("area", area)] {
            let [low, high] = [0, 1].map(|k| contact[name][k].as_f64().unwrap());
            assert!(low <= expected && expected <= high && high - low < 1e-9, "{pair}");
        }
    }
    assert!(json(at, "plate.obj flush.obj").0["pairs"][0].get("contact").is_none());
    let (text, _) = check(at, "plate.obj clash.obj --patches");
    assert!(text.contains("  1 region, length 2.99") && text.contains(", area 0e0..0e0"), "{text}");
    let (csv, _) = check(at, "plate.obj flush.obj clash.obj --csv");
    let lines: Vec<_> = csv.lines().collect();
    assert_eq!(lines[0], "body_a,body_b,relation,allowed,meets,low,high");
    assert_eq!(lines[1], "plate.obj,flush.obj,touching,true,true,,");
    assert!(lines[2].starts_with("plate.obj,clash.obj,crossing,false,true,0.12"), "{csv}");
}

#[test]
fn open_bodies_are_undetermined() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("closed.obj"), cube([0.1; 3], 1.0)).unwrap();
    let run = pfront(at, "check closed.obj b.obj");
    let errors = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert!(errors.contains("b.obj: no solid: edge 0 of triangle 0 is open"), "{errors}");
    let text = String::from_utf8(run.stdout).unwrap();
    assert!(text.starts_with("closed.obj  b.obj  undetermined  at "), "{text}");
    assert!(refused(at, "check a.obj b.obj --allow beside").contains("there are apart, near, "));
    assert!(refused(at, "check a.obj --picture a.obj").contains("a picture is a .ply file"));
    assert!(refused(at, "check a.obj b.obj --ignore a.obj c*").contains("there is no body c*"));
}

/// Bodies in grey, and what is not allowed in red, yellow and blue.
#[test]
fn a_picture_shows_what_is_not_allowed() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("plate.obj"), cube([0.0; 3], 4.0)).unwrap();
    let cases = [
        (cube([3.5; 3], 1.0), "", Some([214_u8, 40, 40])),
        (cube([1.0; 3], 1.0), "", Some([60, 90, 220])),
        (cube([4.25, 1.0, 1.0], 1.0), "--clearance 0.5", Some([232, 190, 40])),
        (cube([4.25, 1.0, 1.0], 1.0), "", None),
    ];
    for (other, options, expected) in cases {
        fs::write(at.join("other.obj"), other).unwrap();
        let (_, code) = check(at, &format!("plate.obj other.obj {options} --picture seen.ply"));
        assert_eq!(code, i32::from(expected.is_some()));
        let bytes = fs::read(at.join("seen.ply")).unwrap();
        let head = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let mut colours: Vec<_> =
            bytes[head..head + 24 * 3 * 15].chunks(15).map(|v| [v[12], v[13], v[14]]).collect();
        colours.sort_unstable();
        colours.dedup();
        let mut all = vec![[172, 182, 196]];
        all.extend(expected);
        all.sort_unstable();
        assert_eq!(colours, all, "{options}");
    }
}
