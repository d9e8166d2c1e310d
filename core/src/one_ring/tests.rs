//! Fans that touch themselves, and fans that do not.

use super::*;

/// The fan of a vertex at the origin over these rim points, closed or not.
fn certified(rim: &[[f32; 3]], ring: bool) -> bool {
    let n = rim.len() as u32;
    let mut positions = [[0.0; 3]; MOST + 2];
    positions[1..=rim.len()].copy_from_slice(rim);
    let mut triangles = [[0; 3]; MOST + 1];
    let count = if ring { n } else { n - 1 };
    for i in 0..count {
        // Each turned another way, which changes nothing.
        let t = [0, i + 1, (i + 1) % n + 1];
        triangles[i as usize] = [t, [t[1], t[2], t[0]], [t[2], t[0], t[1]]][i as usize % 3];
    }
    let mesh = Mesh::new(&positions, &triangles[..count as usize]).unwrap();
    let mut fans = [Fan::default(); MOST + 2];
    link(mesh, &mut [0; link_scratch_bound(MOST + 2, MOST + 1)], &mut fans).unwrap();
    certify(mesh, &mut fans).unwrap();
    fans[0].is_certified()
}

fn circle(n: usize, turns: f32, height: impl Fn(usize) -> f32) -> [[f32; 3]; MOST + 1] {
    core::array::from_fn(|i| {
        let angle = 0.1 + turns * core::f32::consts::TAU * i as f32 / n as f32;
        [cos(angle), cos(angle - core::f32::consts::FRAC_PI_2), height(i)]
    })
}

fn cos(x: f32) -> f32 {
    glam::Vec2::from_angle(x).x
}

#[test]
fn rings_round_once() {
    for n in 3..=MOST {
        assert!(certified(&circle(n, 1.0, |_| 0.0)[..n], true), "flat, {n}");
        assert!(certified(&circle(n, 1.0, |_| 0.5)[..n], true), "a cone, {n}");
    }
    assert!(certified(&circle(6, 1.0, |i| [0.3, -0.3][i % 2])[..6], true), "a saddle");
    assert!(!certified(&circle(MOST + 1, 1.0, |_| 0.0), true), "too many to count");
}

#[test]
fn rings_round_twice_or_folded() {
    for n in 5..=MOST {
        assert!(!certified(&circle(n, 2.0, |i| i as f32 * 0.1)[..n], true), "{n}");
    }
    let mut folded = circle(6, 1.0, |_| 0.0);
    folded.swap(2, 3);
    assert!(!certified(&folded[..6], true));
    folded[3] = folded[2];
    assert!(!certified(&folded[..6], true), "a triangle without area");
}

#[test]
fn rows() {
    for n in 2..=MOST {
        // Of n − 1 triangles.
        assert!(certified(&circle(2 * n, 1.0, |_| 0.0)[..n], false), "half a turn, {n}");
    }
    assert!(!certified(&circle(12, 1.2, |_| 0.0)[..13], false), "more than a turn");
    assert!(!certified(&circle(12, 1.0, |_| 0.0)[..13], false), "a whole turn");
}

#[test]
fn what_is_not_one_fan() {
    let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let at_first = |triangles: &[[u32; 3]]| {
        let mesh = Mesh::new(&square, triangles).unwrap();
        let (mut fans, mut scratch) = ([Fan::default(); 5], [0; link_scratch_bound(5, 4)]);
        link(mesh, &mut scratch, &mut fans).unwrap();
        certify(mesh, &mut fans).unwrap();
        fans[0].is_certified()
    };
    assert!(at_first(&[[0, 1, 2], [0, 2, 3]]));
    assert!(!at_first(&[[0, 1, 2], [0, 3, 2]]), "turned over");
    assert!(!at_first(&[[0, 1, 2], [0, 1, 2]]), "twice");
    assert!(!at_first(&[[0, 1, 2], [0, 1, 3]]), "two on one side of an edge");
    assert!(!at_first(&[[0, 1, 2], [0, 3, 4]]), "two rows");
    assert!(!at_first(&[[0, 1, 2], [0, 2, 1], [0, 3, 4], [0, 4, 3]]), "two rings");
    assert!(!at_first(&[[0, 1, 2], [0, 0, 3]]), "an index twice");
    assert!(!at_first(&[]), "none");
    assert!(link(Mesh::new(&square, &[]).unwrap(), &mut [0; 5], &mut [Fan(0); 5]).is_err());
}
