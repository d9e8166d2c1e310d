//! Where two triangles meet: against hand-made cases, the oracle and f64.

use super::*;
use pfront_testkit::families::Family;
use pfront_testkit::oracle::intersect;
use pfront_testkit::rng::seeded;

const FLOOR: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

#[test]
fn crossing_segment_ends_on_the_inner_features() {
    let wall = [[1.0, -1.0, -1.0], [1.0, 9.0, -1.0], [1.0, -1.0, 9.0]];
    let c = contact(&FLOOR, &wall).unwrap();
    let mut ends = c.segment;
    ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
    assert!(!c.is_flat);
    assert_eq!(ends, [[1.0, 0.0, 0.0], [1.0, 3.0, 0.0]]);
    assert_eq!(c.normals, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
}

#[test]
fn nearly_parallel_planes_keep_their_accuracy() {
    // Two sheets that cross at x = 1/3 at an angle of 1e-40.
    let tilt = 1e-40;
    let sheet = [[0.0, -1.0, -tilt], [0.0, 9.0, -tilt], [1.0, 0.0, 2.0 * tilt]];
    let big = [[-9.0, -9.0, 0.0], [99.0, -9.0, 0.0], [-9.0, 99.0, 0.0]];
    let c = contact(&big, &sheet).unwrap();
    for p in c.segment {
        assert!((p[0] - 1.0 / 3.0).abs() < 1e-5 && p[2] == 0.0, "{p:?}");
    }
}

/// Segments whose area in f64 is not zero: some corners are 2^33 times as far as others.
#[test]
fn normals_of_degenerate_triangles_are_zero() {
    let direction = [1.0_f32, 3.0, 7.0];
    for exponent in 20..60 {
        let [near, far] = [-2f32.powi(-exponent), 2f32.powi(20)];
        for size in [1.0, 2f32.powi(60)] {
            let scales = [near, far, 1.5 * far].map(|scale| size * scale);
            let t = scales.map(|scale| direction.map(|x| scale * x));
            assert_eq!(TrianglePlane::of(&t).unit_normal(), [0.0; 3], "{exponent}");
        }
    }
    assert_eq!(TrianglePlane::of(&[[2.0; 3]; 3]).unit_normal(), [0.0; 3]);
    // And with an area that f64 does not see.
    let sliver = [[-1.0, 1.0, 0.0], [f32::from_bits(1), 1.0, -1.0], [-0.5, 1.0, -0.5]];
    assert_eq!(TrianglePlane::of(&sliver).unit_normal(), [0.0, 1.0, 0.0]);
    let least = f32::from_bits(1);
    assert_eq!(
        TrianglePlane::of(&[[0.0; 3], [least, 0.0, 0.0], [0.0, least, 0.0]]).unit_normal(),
        [0.0, 0.0, 1.0]
    );
    let huge = f32::MAX;
    assert_eq!(
        TrianglePlane::of(&[[0.0; 3], [0.0, huge, 0.0], [huge, 0.0, 0.0]]).unit_normal(),
        [0.0, 0.0, -1.0]
    );
}

#[test]
fn flat_contacts() {
    let c = contact(&FLOOR, &[[1.0, 1.0, 0.0], [1.0, 9.0, 0.0], [-9.0, 1.0, 0.0]]).unwrap();
    assert!(c.is_flat);
    for [p, expected] in [[[1.0, 1.0, -1.0], [1.0, 1.0, 0.0]], [[2.0, 2.0, -1.0], [2.0, 2.0, 0.0]]]
    {
        let needle = [p, [p[0], p[1], 1.0], p];
        assert_eq!(contact(&FLOOR, &needle).unwrap().segment, [expected; 2]);
    }
    let across = [[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 1.0, 0.0]];
    let mut ends = contact(&FLOOR, &across).unwrap().segment;
    ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
    assert_eq!(ends, [[0.0, 1.0, 0.0], [3.0, 1.0, 0.0]]);
    assert!(contact(&FLOOR, &[[5.0, 5.0, 0.0]; 3]).is_none());
    let beside = [[5.0, 5.0, -1.0], [5.0, 5.0, 1.0], [5.0, 5.0, 1.0]];
    assert!(contact(&FLOOR, &beside).is_none());
}

#[test]
fn contacts_exist_where_the_oracle_sees_an_intersection() {
    let mut rng = seeded(15);
    for family in Family::ALL {
        for _ in 0..if cfg!(miri) { 2 } else { 100 } {
            let (a, b) = family.pair(&mut rng);
            assert_eq!(contact(&a, &b).is_some(), intersect(&a, &b), "{family:?} {a:?} {b:?}");
        }
    }
}

/// The same triangles in f64, as they are and with one axis stretched as f32 cannot hold it.
#[test]
fn contacts_in_f64_are_those_in_f32() {
    let mut rng = seeded(16);
    let (mut found, mut stretched) = (0, 0);
    for family in Family::ALL {
        for _ in 0..if cfg!(miri) { 2 } else { 100 } {
            let (a, b) = family.pair(&mut rng);
            let extent = a.iter().chain(&b).flatten().fold(0.0, |m: f32, x| m.max(x.abs()));
            if extent > 4e37 {
                continue;
            }
            let [p, q] = [&a, &b].map(|t| t.map(|p| p.map(f64::from)));
            let in_f64 = contact_of(&p, &q).map(Contact::from);
            let Some(expected) = contact(&a, &b) else {
                assert_eq!(in_f64, None);
                continue;
            };
            let in_f64: Contact = in_f64.unwrap();
            found += 1;
            assert_eq!(in_f64.is_flat, expected.is_flat);
            let near = |x: f32, y: f32, extent: f32| (x - y).abs() <= 1e-6 * extent;
            for (x, y) in in_f64.segment.as_flattened().iter().zip(expected.segment.as_flattened())
            {
                assert!(expected.is_flat || near(*x, *y, extent), "{family:?} {x} {y}");
            }
            for (x, y) in in_f64.normals.as_flattened().iter().zip(expected.normals.as_flattened())
            {
                assert!(near(*x, *y, 1.0), "{family:?} {a:?} {b:?}");
            }
            if extent > 1e20 || expected.is_flat {
                continue;
            }
            // The segment in which they meet is scaled as their coordinates are.
            let scale = [2f64.powi(40), 1.0, 2f64.powi(-900)];
            let scaled = |p: [f64; 3]| [0, 1, 2].map(|k: usize| p[k] * scale[k]);
            let [p, q] = [p, q].map(|t| t.map(scaled));
            if let Some(contact) = contact_of(&p, &q) {
                stretched += 1;
                for (x, y) in contact.segment.iter().zip(expected.segment) {
                    for k in 0..3 {
                        let back = (x[k] / scale[k]) as f32;
                        assert!(near(back, y[k], extent), "{family:?} {back} {}", y[k]);
                    }
                }
            }
        }
    }
    assert!(found > if cfg!(miri) { 2 } else { 200 } && stretched > 1, "{found} {stretched}");
}

/// An end of an edge that lies in the plane is returned as it is, though f64 cannot hold its distance from the other
/// end.
#[test]
fn ends_in_the_plane_are_not_rounded() {
    let (near, far) = ([0.1, 0.2, 0.0], [1e12, 1e12, 1e12]);
    for [p, q] in [[near, far], [far, near]] {
        assert_eq!(edge_point(&p, &q, &FLOOR), near);
    }
}

/// The plane x = y, and an edge through it whose ends are closer to it than f64 can tell from so far away.
#[test]
fn edge_parameters_that_f64_does_not_know_come_from_integers() {
    let (far, close) = (2f32.powi(20), 2f32.powi(-40));
    let t = [[far, far, 0.0], [-far, -far, 0.0], [0.0, 0.0, far]];
    let (p, q) = ([close, 0.0, 0.0], [0.0, 3.0 * close, 0.0]);
    assert_eq!(edge_point(&p, &q, &t), [0.75 * close, 0.75 * close, 0.0]);
    // Ends at heights of 1 and −3 over the plane 7x = 3y, of which f64 knows four digits.
    let (far, near, close) = (1_572_863.0 * 2f32.powi(40), 1_398_101.0 * 32.0, 2f32.powi(20));
    let t = [[3.0 * far, 7.0 * far, 0.0], [-3.0 * near, -7.0 * near, 0.0], [0.0, 0.0, far]];
    let (p, q) = ([3.0 * close, 0.0, 0.0], [0.0, 21.0 * close, 0.0]);
    assert_eq!(edge_point(&p, &q, &t), [2.25 * close, 5.25 * close, 0.0]);
}

/// A posed contact is rounded once, at its end, however far the body is from its own origin or however small it is posed.
#[test]
fn posed_contacts_are_those_of_posed_triangles() {
    let far = |[x, y, z]: [f64; 3]| [x + 1_048_576.0, y, z];
    let floor = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(far);
    // The blade cuts the floor at x = 1/3.
    let blade = [[0.0, 1.0, -1.0], [1.0, 1.0, 2.0], [1.0, 2.0, 2.0]].map(far);
    let back = Pose64::from_translation([-1_048_576.0, 0.0, 0.0]);
    let [p, _] = posed_contact(&floor, &blade, &back).unwrap().segment;
    assert!((p[0] - 1.0 / 3.0).abs() < 1e-8, "{p:?}");

    let tilted = [[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 7.0, 1.0]];
    let blade = [[1.0, 1.0, -1.0], [1.0, 2.0, -1.0], [1.0, 1.0, 1.0]];
    let sheared =
        Pose64::new([[1.0, 1000.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let tiny =
        Pose64::new([[1e-90, 0.0, 0.0, 0.0], [0.0, 1e-90, 0.0, 0.0], [0.0, 0.0, 1e-90, 0.0]]);
    let mirrored = Pose64::new([[-1.0, 0.0, 0.0, 2.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 9.0]]);
    let flat = Pose64::new([[0.0; 4], [1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 5.0]]);
    for pose in [Pose64::IDENTITY, sheared, tiny, mirrored, flat] {
        let found = posed_contact(&tilted, &blade, &pose).unwrap();
        let unposed = contact_of(&tilted, &blade).unwrap();
        assert_eq!(found.segment, unposed.segment.map(|p| pose.apply(p)));
        for (t, normal) in [tilted, blade].iter().zip(found.normals) {
            let [a, b, c] = t.map(|p| DVec3::from_array(pose.apply(p)));
            let expected = (b - a).cross(c - a);
            // Far from where its square vanishes.
            let expected =
                (expected / expected.abs().max_element().max(1e-300)).normalize_or_zero();
            let apart = expected - DVec3::from_array(normal.map(f64::from));
            assert!(apart.abs().max_element() < 2f64.powi(-23), "{pose:?} {normal:?}");
        }
    }
}
