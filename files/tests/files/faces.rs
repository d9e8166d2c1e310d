//! Faces of many corners become triangles that cover them, few around any corner.

use super::fault;
use super::lenient::read;
use pfront_files::TriangleMesh;
use robust::{Coord, orient2d};
use std::fmt::Write;

/// An OBJ of one face.
fn face(points: &[[f64; 2]], place: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
    let mut file = String::new();
    for &[x, y] in points {
        let [x, y, z] = place(x, y);
        writeln!(file, "v {x} {y} {z}").unwrap();
    }
    // Vertices may come after the faces that they are of.
    let corners: String = (1..=points.len()).map(|i| format!(" {i}")).collect();
    read("obj", format!("f{corners}\n{file}")).unwrap().mesh
}

fn circle(n: usize, radius: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    let turn = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
    (0..n).map(|i| [radius(i) * turn(i).cos(), radius(i) * turn(i).sin()]).collect()
}

fn area(points: [[f64; 2]; 3]) -> f64 {
    let [a, b, c] = points;
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// Checks that the triangles of a face turn as it does, and have its area: then they cover it, each point once.
fn covers(points: &[[f64; 2]]) -> Vec<usize> {
    let mesh = face(points, |x, y| [x, y, 0.0]);
    assert_eq!(mesh.triangles.len(), points.len() - 2);
    let turned = |t: &[u32; 3]| t.map(|v| points[v as usize]);
    let turns_left = |t: &[[f64; 2]; 3]| {
        let [a, b, c] = t.map(|[x, y]| Coord { x, y });
        orient2d(a, b, c) > 0.0
    };
    assert!(mesh.triangles.iter().map(turned).all(|t| turns_left(&t)));
    let next = points.iter().cycle().skip(1);
    let whole: f64 = points.iter().zip(next).map(|(&a, &b)| area([[0.0; 2], a, b])).sum();
    let sum: f64 = mesh.triangles.iter().map(turned).map(area).sum();
    assert!((sum - whole).abs() < 1e-9 * whole, "{sum}, and not {whole}");
    let mut valence = vec![0; points.len()];
    mesh.triangles.as_flattened().iter().for_each(|&v| valence[v as usize] += 1);
    valence
}

#[test]
fn a_flat_face_of_many_corners_is_no_fan() {
    let n = 100_000;
    let square = |i: usize| {
        let (side, at) = (4 * i / n, (4 * i % n) as f64 / n as f64);
        [[at, 0.0], [1.0, at], [1.0 - at, 1.0], [0.0, 1.0 - at]][side]
    };
    let wave = |i: usize, y: f64| [1e-3 * i as f64, y + (1e-2 * i as f64).sin()];
    let far = (0..n / 2).rev().map(|i| wave(i, 5.0));
    // Round holes, each with a bridge to the outline and back.
    let hole = |h: usize| {
        let outer = circle(2000, |_| 10.0)[40 * h..40 * (h + 1)].to_vec();
        let (end, corners) = (outer[39], n / 50 - 42);
        let mut hole = circle(corners, |_| 0.3);
        hole.iter_mut().for_each(|[x, y]| [*x, *y] = [0.8 * end[0] + *x, 0.8 * end[1] - *y]);
        hole.rotate_left(corners - corners * (40 * h + 39) / 2000);
        let bridge = [hole[0], end];
        [&outer[..], &hole, &bridge].concat()
    };
    for (name, points, allowed) in [
        ("circle", circle(n, |_| 1.0), 12),
        ("square of straight edges", (0..n).map(square).collect(), 12),
        ("gear", circle(n, |i| if i / 10 % 2 == 0 { 1.0 } else { 0.9 }), 12),
        ("star", circle(n, |i| if i % 2 == 0 { 1.0 } else { 0.999 }), 12),
        ("band of waves", (0..n / 2).map(|i| wave(i, 0.0)).chain(far).collect(), 16),
        // Where bridges end.
        ("plate with holes", (0..50).flat_map(hole).collect(), 24),
    ] {
        let most = covers(&points).into_iter().max().unwrap();
        assert!(most <= allowed, "{most} triangles around one corner of a {name}");
    }
}

#[test]
fn concave_faces_are_covered() {
    let plate = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let dart = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
    // A frame, whose hole a bridge leads to.
    let frame = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    let edges = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]];
    let spiral = (0..400).map(|i| {
        let (at, radius) = if i < 200 { (i, 1.0) } else { (399 - i, 1.2) };
        let turn = 0.1 * f64::from(at);
        [turn.cos(), turn.sin()].map(|x| (radius + 0.1 * turn) * x)
    });
    let mut spiral: Vec<_> = spiral.collect();
    spiral.reverse();
    for points in [&plate[..], &dart, &frame, &edges, &spiral] {
        // From each corner on: a fan would cover some.
        for first in (0..points.len()).step_by(1 + points.len() / 20) {
            let turned = [&points[first..], &points[..first]].concat();
            covers(&turned);
        }
    }
    // As it stands in space and turns, with the corners in their order.
    let lies = |x: f64, y: f64| [0.25 * x - y, y, x + 0.5 * y];
    let stands = |x: f64, y: f64| lies(y, x);
    assert_eq!(face(&dart, lies).triangles.len(), 2);
    assert_eq!(face(&dart, lies).triangles, face(&dart, stands).triangles);
}

/// As before, so that numbers of triangles stay.
#[test]
fn small_convex_faces_are_fans() {
    for n in 4..=8 {
        let mesh = face(&circle(n, |_| 1.0), |x, y| [x, y, x + y]);
        let fan: Vec<_> = (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect();
        assert_eq!(mesh.triangles, fan);
    }
}

/// Without an area, or across itself, a face is not lost; and a corner that is NaN is named.
#[test]
fn faces_that_are_none_keep_their_triangles() {
    let line =
        face(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.5, 0.0]], |x, y| [x, y, 0.0]);
    assert_eq!(line.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    // Nor does a corner that is there twice make a face less than it is.
    let twice = "v 0 0 0\nv 2 0 0\nv 2 0 0\nv 1 0.5 0\nv 0 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n";
    let twice = read("obj", twice).unwrap();
    assert_eq!((twice.mesh.triangles.len(), twice.notes), (4, Vec::new()));
    let star = circle(11, |_| 1.0);
    let star: Vec<_> = (0..11).map(|i| star[5 * i % 11]).collect();
    assert_eq!(face(&star, |x, y| [x, y, 0.0]).triangles.len(), 9);
    let nan = "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4 5\n";
    let error = fault("nan.obj", nan);
    assert!(error.contains("line 3: vertex 2 has a NaN"), "{error}");
}
