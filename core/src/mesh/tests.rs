//! Shadows, and what is refused.

use super::*;

const TRIANGLES: [[u32; 3]; 1] = [[0, 1, 2]];

#[test]
fn a_shadow_is_near_its_positions_wherever_they_are() {
    for offset in [0.0, 1e7, -1e30] {
        let points = [[0.1, 0.2, 0.3], [1.7, 0.2, -5.0], [0.4, 8.9, 0.3]];
        let points = points.map(|p: [f64; 3]| p.map(|x| x + offset));
        let mut shadow = [[9.0; 3]; 3];
        let mesh = Mesh::from_f64(&points, &TRIANGLES, &mut shadow).unwrap();
        for (p, s) in points.iter().zip(mesh.shadow()) {
            for k in 0..3 {
                let (back, extent) =
                    (f64::from(s[k]) + mesh.origin()[k], 9.0 + offset.abs() * 1e-9);
                assert!((back - p[k]).abs() < extent * 2f64.powi(-23), "{back} {}", p[k]);
            }
        }
        assert_eq!(mesh.triangle_f64(0), points);
    }
}

#[test]
fn positions_in_f64_that_are_refused_are_named() {
    let refused = |x: f64| {
        let points = [[0.0; 3], [0.0, x, 0.0], [x; 3]];
        Mesh::from_f64(&points, &TRIANGLES, &mut [[0.0; 3]; 3]).err()
    };
    assert_eq!(refused(f64::NAN), Some(MeshError::NonFinite { vertex: 1 }));
    assert_eq!(refused(f64::NEG_INFINITY), Some(MeshError::NonFinite { vertex: 1 }));
    assert_eq!(refused(1e38), Some(MeshError::Range { vertex: 1 }));
    assert_eq!(refused(2f64.powi(125)), None);
    let short = Mesh::from_f64(&[[0.0; 3]; 3], &TRIANGLES, &mut [[0.0; 3]; 2]).err();
    assert_eq!(short, Some(MeshError::VertexCount { expected: 3, found: 2 }));
    let beyond = Mesh::from_f64(&[[0.0; 3]; 2], &TRIANGLES, &mut [[0.0; 3]; 2]).err();
    let expected = MeshError::IndexOutOfRange { triangle: 0, index: 2, vertices: 2 };
    assert_eq!(beyond, Some(expected));
    assert!(Mesh::from_f64(&[], &[], &mut []).is_ok());
}

#[test]
fn a_mesh_takes_positions_of_its_own_precision_only() {
    let (points, mut shadow, mut other) = ([[0.1; 3]; 3], [[0.0; 3]; 3], [[0.0; 3]; 3]);
    let exact = Mesh::from_f64(&points, &TRIANGLES, &mut shadow).unwrap();
    let rounded = Mesh::new(&[[0.1; 3]; 3], &TRIANGLES).unwrap();
    assert_eq!(exact.with_positions(&[[0.1; 3]; 3]).err(), Some(MeshError::OtherPrecision));
    let refused = rounded.with_positions_f64(&points, &mut other).err();
    assert_eq!(refused, Some(MeshError::OtherPrecision));
    // The origin stays while the box contains it, so that what has not moved keeps its shadow.
    let moved = [[0.1; 3], [0.2; 3], [-3.0; 3]];
    assert_eq!(exact.with_positions_f64(&moved, &mut other).unwrap().origin(), [0.1; 3]);
    let (away, mut other) = ([[7.0; 3]; 3], [[0.0; 3]; 3]);
    assert_eq!(exact.with_positions_f64(&away, &mut other).unwrap().origin(), [7.0; 3]);
}

#[test]
fn a_mesh_in_f32_is_itself_when_it_is_widened() {
    let points = [[0.5; 3], [1.5; 3], [-7.25; 3]];
    let mesh = Mesh::new(&points, &TRIANGLES).unwrap().widened();
    assert!(mesh.is_f64() && mesh.positions_f64().is_none());
    assert_eq!((mesh.origin(), mesh.triangle_f64(0)), ([0.0; 3], points.map(|p| p.map(f64::from))));
    let (exact, mut shadow) = ([[0.1; 3]; 3], [[0.0; 3]; 3]);
    let exact = Mesh::from_f64(&exact, &TRIANGLES, &mut shadow).unwrap();
    assert_eq!(exact.widened().positions_f64(), exact.positions_f64());
}

#[test]
#[should_panic]
fn positions_in_f64_that_are_missing_are_no_answer() {
    let shadow = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Mesh::from_f64_unchecked(&[], &shadow, [7.0; 3], &TRIANGLES).triangle_f64(0);
}
