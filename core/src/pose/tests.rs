//! Corners to the bit, and boxes that contain them.

extern crate std;

use super::{Affine, Pose, Pose64, PoseError};
use crate::aabb::Bounds;
use crate::simd::{Box4, LANES, Simd, Task, widest};
use crate::{Aabb, Node};
use glam::{DMat3, DVec3, Vec3A, Vec4};
use pfront_testkit::rng::{RngExt, seeded};

/// Places a point in all lanes but the first and returns the last.
struct Lanes {
    place: Affine,
    point: [f32; 3],
}

impl Task for Lanes {
    type Output = [f32; 3];

    #[inline(always)]
    fn run<S: Simd>(self) -> [f32; 3] {
        let placed = self.place.points(self.point.map(|x| {
            let mut lanes = [x; LANES];
            lanes[0] = -x;
            S::load(&lanes, 0)
        }));
        placed.map(|x| {
            let mut lanes = [0.0; LANES];
            x.store(&mut lanes, 0);
            lanes[LANES - 1]
        })
    }
}

fn course() -> impl Iterator<Item = (Pose, [[f32; 3]; 2])> {
    let mut rng = seeded(7);
    let mut next =
        move || rng.random_range(-1.0..1.0f32) * [1e-6, 1.0, 3.0, 1e4][rng.random_range(0..4)];
    (0..50_000).map(move |_| {
        let rows = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        (Pose::new(rows), core::array::from_fn(|_| core::array::from_fn(|_| next())))
    })
}

/// The map of a pose for what lies between two points.
fn affine(pose: &Pose, points: &[[f32; 3]; 2]) -> Affine {
    Affine::new(pose, &Bounds::new(&Aabb::of(points))).unwrap()
}

#[test]
fn corners_are_posed_by_the_formula_of_the_contract_to_the_bit() {
    for (pose, points) in course() {
        for p in points {
            let (place, truth) = (affine(&pose, &points), pose.apply(p).map(f32::to_bits));
            assert_eq!(place.point(Vec3A::from_array(p)).to_array().map(f32::to_bits), truth);
            let lanes = Lanes { place, point: p };
            assert_eq!(widest(lanes).map(f32::to_bits), truth);
        }
    }
}

#[test]
fn posed_boxes_contain_posed_corners() {
    for (pose, points) in course() {
        let aabb = Aabb::of(&points);
        let affine = affine(&pose, &points);
        let posed = affine.bounds(&Bounds::new(&aabb));
        let one = Node { min: aabb.min, max: aabb.max, ..Node::EMPTY };
        let four =
            affine.boxes(&Box4::transposed([one, Node::EMPTY, one, one].map(bytemuck::must_cast)));
        for corner in 0..8 {
            let p = [0, 1, 2].map(|k| [aabb.min, aabb.max][corner >> k & 1][k]);
            let p = Vec3A::from_array(pose.apply(p));
            assert!(posed.min.cmple(p).all() && p.cmple(posed.max).all());
            let p = p.to_array().map(Vec4::splat);
            assert_eq!(four.overlapping(&Box4 { min: p, max: p }), 0b1101);
        }
    }
}

/// A rotation and a translation of the order of `far`.
fn rigid(points: &[[f32; 3]; 2], far: f32) -> Pose {
    let [axis, offset] = points.map(glam::Vec3::from_array);
    let turn = glam::Quat::from_scaled_axis(axis.normalize_or_zero() * axis.length().min(3.0));
    let offset = offset.normalize_or_zero() * far;
    Pose::from_rotation_translation(turn.to_array(), offset.to_array())
}

#[test]
fn boxes_seen_from_another_pose_contain_what_both_pose_alike() {
    let mut course = course();
    while let (Some((_, p)), Some((_, q)), Some((_, r))) =
        (course.next(), course.next(), course.next())
    {
        for far in [0.0, 1.0, 1e5] {
            let (a, b) = (rigid(&p, far), rigid(&q, far));
            let y = r[0];
            let back = glam::DAffine3::from_mat3_translation(
                DMat3::from_cols_array_2d(&core::array::from_fn(|k| {
                    core::array::from_fn(|i| f64::from(a.rows[i][k]))
                })),
                DVec3::from_array(core::array::from_fn(|i| f64::from(a.rows[i][3]))),
            )
            .inverse();
            let world = glam::Vec3::from_array(b.apply(y)).as_dvec3();
            let x = back.transform_point3(world).as_vec3a();
            let of = |p: [f32; 3]| Bounds::new(&Aabb { min: p, max: p });
            let (a, b) = (affine(&a, &[x.to_array(); 2]), affine(&b, &[y; 2]));
            let seen = b.seen_from(&of(y), &a).unwrap().bounds(&of(y));
            assert!(seen.min.cmple(x).all() && x.cmple(seen.max).all(), "{seen:?} {x}");
        }
    }
}

#[test]
fn no_view_from_a_pose_that_flattens_or_stretches() {
    let unit = Bounds::new(&Aabb { min: [0.0; 3], max: [1.0; 3] });
    let mut flat = Pose::IDENTITY;
    flat.rows[2] = [0.0; 4];
    let mut stretched = Pose::IDENTITY;
    stretched.rows[1][1] = 3.0;
    let corners = [[0.0; 3], [1.0; 3]];
    let moved = affine(&Pose::from_translation([1.0; 3]), &corners);
    for pose in [flat, stretched].map(|pose| affine(&pose, &corners)) {
        assert!(moved.seen_from(&unit, &pose).is_none());
        assert!(pose.seen_from(&unit, &moved).is_some());
    }
}

#[test]
fn what_shrinks_to_subnormal_numbers_is_still_seen() {
    // A corner far out in b, which its pose takes down to some 1e-6: entries keep a digit or none.
    for scale in [1e-38_f32, 1e-42, 1e-44, f32::from_bits(1)] {
        let turn = glam::Quat::from_rotation_z(core::f32::consts::FRAC_PI_4);
        let mut shrunk = Pose::IDENTITY;
        (0..3).for_each(|k| shrunk.rows[k][k] = scale);
        let (a, y) =
            (Pose::from_rotation_translation(turn.to_array(), [0.0; 3]), [0.9e38, 0.9e38, 0.0]);
        let world = glam::Vec3::from_array(shrunk.apply(y)).as_dvec3();
        let back = DMat3::from_cols_array_2d(&core::array::from_fn(|k| {
            core::array::from_fn(|i| f64::from(a.rows[i][k]))
        }));
        let x = (back.inverse() * world).as_vec3a();
        let of = |p: [f32; 3]| Bounds::new(&Aabb { min: p, max: p });
        let (a, b) = (affine(&a, &[x.to_array(); 2]), affine(&shrunk, &[y; 2]));
        let seen = b.seen_from(&of(y), &a).unwrap().bounds(&of(y));
        assert!(seen.min.cmple(x).all() && x.cmple(seen.max).all(), "{scale:e}: {seen:?} {x}");
    }
}

#[test]
fn refuses_what_cannot_be_posed() {
    let unit = Aabb { min: [0.0; 3], max: [1.0; 3] };
    let mut pose = Pose::IDENTITY;
    pose.rows[1][3] = f32::NAN;
    assert_eq!(pose.check(&unit), Err(PoseError::NonFinite { row: 1, column: 3 }));
    pose.rows[1][3] = f32::MAX;
    assert_eq!(pose.check(&unit), Err(PoseError::Range { row: 1 }));
    assert_eq!(pose.check(&Aabb::EMPTY), Err(PoseError::Range { row: 1 }));
    assert_eq!(Pose::IDENTITY.check(&unit), Ok(()));
    assert_eq!(Pose::IDENTITY.check(&Aabb::EMPTY), Ok(()));
}

#[test]
fn a_huge_mesh_may_shrink_into_range() {
    let huge = Aabb { min: [-3e38; 3], max: [3e38; 3] };
    let scaled = |scale: f32| {
        let mut pose = Pose::IDENTITY;
        (0..3).for_each(|k| pose.rows[k][k] = scale);
        pose
    };
    assert_eq!(scaled(1e-3).check(&huge), Ok(()));
    assert_eq!(scaled(0.5).check(&huge), Err(PoseError::Range { row: 0 }));
    let pose = scaled(1e-3);
    let affine = affine(&pose, &[huge.min, huge.max]);
    let posed = affine.bounds(&Bounds::new(&huge));
    for p in [huge.min, huge.max].map(|p| Vec3A::from_array(pose.apply(p))) {
        assert!(posed.min.cmple(p).all() && p.cmple(posed.max).all(), "{posed:?} {p}");
    }
}

#[test]
fn poses_are_made_from_what_engines_keep() {
    let rotation = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
    let (translation, point) = (glam::Vec3::new(1.0, -2.0, 3.5), glam::Vec3::new(0.2, 0.7, -4.0));
    let matrix = glam::Mat4::from_rotation_translation(rotation, translation);
    let expected = matrix.transform_point3(point);
    let poses = [
        Pose::from_cols_array(&matrix.to_cols_array()),
        Pose::from_rotation_translation(rotation.to_array(), translation.to_array()),
        #[cfg(feature = "glam034")]
        Pose::from(glam::Affine3A::from_mat4(matrix)),
        #[cfg(feature = "glam033")]
        Pose::from(glam033::Affine3A::from_cols_array(
            &glam::Affine3A::from_mat4(matrix).to_cols_array(),
        )),
    ];
    for pose in poses {
        let found = glam::Vec3::from(pose.apply(point.to_array()));
        assert!((found - expected).length() < 1e-5, "{found} {expected}");
        #[cfg(feature = "glam034")]
        assert_eq!(Pose::from(glam::Affine3A::from(pose)), pose);
        #[cfg(feature = "glam033")]
        assert_eq!(Pose::from(glam033::Affine3A::from(pose)), pose);
    }
}

#[test]
fn a_pose_and_its_inverse_take_points_back() {
    let mut rng = seeded(4);
    for _ in 0..200 {
        // Not rigid: any map that is not flat has an inverse.
        let mut pose =
            || Pose::new([[0; 4]; 3].map(|row| row.map(|_| rng.random_range(-1.0..1.0))));
        let (a, b) = (pose(), pose());
        let rows = a.rows.map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into()));
        let determinant = DMat3::from_cols_array_2d(&rows.map(|row| row.to_array())).determinant();
        if determinant.abs() < 0.05 {
            continue;
        }
        let p = [0.3, -0.8, 0.5];
        let back = a.inverse().unwrap().apply(a.apply(p));
        let (twice, once) = (a.apply(b.apply(p)), (a * b).apply(p));
        for k in 0..3 {
            assert!((back[k] - p[k]).abs() < 1e-4 && (twice[k] - once[k]).abs() < 1e-5);
        }
    }
    let flat = Pose::new([[1.0, 2.0, 3.0, 0.0], [2.0, 4.0, 6.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let endless = Pose::from_translation([f32::INFINITY, 0.0, 0.0]);
    assert_eq!([flat.inverse(), endless.inverse()], [None, None]);
}

/// How far points of a shadow, posed in f32, lie from where the positions are posed in f64, in units of the padding.
fn error_of_shadow(pose: &Pose64, positions: &[[f64; 3]], origin: DVec3, zero: DVec3) -> f64 {
    let shadow = |p: &[f64; 3]| (DVec3::from_array(*p) - origin).as_vec3().to_array();
    let shadows: std::vec::Vec<_> = positions.iter().map(shadow).collect();
    let affine = Affine::of_shadow(pose, origin, &Bounds::new(&Aabb::of(&shadows)), zero);
    let errors = positions.iter().zip(&shadows).map(|(&p, &shadow)| {
        let posed = affine.point(Vec3A::from_array(shadow)).as_dvec3();
        let error = posed - (DVec3::from_array(pose.apply(p)) - zero);
        (error.abs() / affine.padding().as_dvec3()).max_element()
    });
    errors.fold(0.0, f64::max)
}

/// Corners are off by no more than 13/16 of the padding, and by 1/16 where nothing is posed, as queries in f64 rely on.
#[test]
fn posed_shadows_are_as_near_to_posed_positions_as_queries_rely_on() {
    let mut rng = seeded(17);
    let (mut worst, mut unposed) = (0.0_f64, 0.0_f64);
    for round in 0..if cfg!(miri) { 20 } else { 30_000 } {
        let (size, far) = ([1e-3, 1.0, 1e4][round % 3], [0.0, 1.0, 1e3, 1e8][round / 3 % 4]);
        let mut within = |reach: f64| reach * rng.random_range(-1.0..1.0);
        let origin = DVec3::from_array([0; 3].map(|_| within(far)));
        // Corners of the box, where products are largest, and points near them.
        let positions: [[f64; 3]; 16] = core::array::from_fn(|corner| {
            let near = if corner < 8 { 0.0 } else { 0.01 };
            let side = |k: usize| if corner >> k & 1 == 0 { -size } else { size };
            [0, 1, 2].map(|k| origin[k] + side(k) * (1.0 - near * within(1.0).abs()))
        });
        let pose = Pose64::new([0; 3].map(|_| {
            let r = [0; 3].map(|_| within(1.0));
            [r[0], r[1], r[2], within(far)]
        }));
        let zero = DVec3::from_array(pose.apply(origin.to_array()));
        let aside = DVec3::from_array([0; 3].map(|_| within(size)));
        for zero in [zero, zero + aside] {
            worst = worst.max(error_of_shadow(&pose, &positions, origin, zero));
        }
        let bounds = [origin - DVec3::splat(size), origin + DVec3::splat(size)];
        let shadows = bounds.map(|p| (p - origin).as_vec3().to_array());
        let padding = Affine::identity(&Bounds::new(&Aabb::of(&shadows))).padding().as_dvec3();
        for p in positions.map(DVec3::from_array) {
            let error = (p - origin).as_vec3().as_dvec3() - (p - origin);
            unposed = unposed.max((error.abs() / padding).max_element());
        }
    }
    assert!(worst <= 13.0 / 16.0 && unposed <= 1.0 / 16.0, "{worst} {unposed}");
    // Else these positions would say nothing of the bounds.
    assert!(worst > 0.15 && unposed > 0.02, "{worst} {unposed}");
}

/// The formulas of f32, in f64: points to 2^-50 of their size where f32 has them to 2^-20.
#[test]
fn poses_in_f64_keep_the_digits_of_f64() {
    let (half, point) = (core::f64::consts::FRAC_1_SQRT_2, [0.1, -0.7, 4.0]);
    let turn = Pose64::from_rotation_translation([0.0, 0.0, half, half], [1e6, -2e6, 0.1]);
    let expected = [1e6 + 0.7, -2e6 + 0.1, 4.1];
    let near = |p: [f64; 3], q: [f64; 3], reach: f64| {
        assert!((0..3).all(|k| (p[k] - q[k]).abs() <= reach * 2f64.powi(-50)), "{p:?} {q:?}");
    };
    near(turn.apply(point), expected, 2e6);
    let back = turn.inverse().unwrap();
    near(back.apply(turn.apply(point)), point, 1e7);
    near((back * turn).apply(point), point, 1e7);
    assert_eq!((Pose64::IDENTITY * turn, turn * Pose64::IDENTITY), (turn, turn));
    let [x, y, z] = turn.rows;
    let columns: [[f64; 4]; 4] = core::array::from_fn(|k| [x[k], y[k], z[k], 0.0]);
    let matrix: std::vec::Vec<f64> = columns.concat();
    assert_eq!(Pose64::from_cols_array(&core::array::from_fn(|i| matrix[i])), turn);
    // Each operation is rounded to f64, and none is fused.
    let third = Pose64::new([[1.0 / 3.0, 0.1, 0.7, 1e-17], [0.0; 4], [0.0; 4]]);
    let [x, y, z] = core::hint::black_box([1.0 / 3.0, -0.3, 0.9]);
    assert_eq!(third.apply([x, y, z])[0], ((1.0 / 3.0 * x + 0.1 * y) + 0.7 * z) + 1e-17);
    // A pose in f32 has the same entries in f64, in which the point is rounded.
    let narrow = Pose::new([[0.1, 0.2, 0.3, 0.4], [1.0; 4], [0.0; 4]]);
    assert_eq!(Pose64::from(narrow).rows, narrow.rows.map(|row| row.map(f64::from)));
    assert_ne!(Pose64::from(narrow).apply([0.1; 3])[0], f64::from(narrow.apply([0.1; 3])[0]));
}

#[test]
fn refuses_what_cannot_be_posed_in_f64() {
    let unit = Aabb { min: [0.0; 3], max: [1.0; 3] };
    let mut pose = Pose64::IDENTITY;
    pose.rows[2][0] = f64::NEG_INFINITY;
    assert_eq!(pose.check(&unit), Err(PoseError::NonFinite { row: 2, column: 0 }));
    assert_eq!((pose.inverse(), Pose64::new([[0.0; 4]; 3]).inverse()), (None, None));
    // The limit is that of f32, 2^125, which is not within it.
    let limit = 2f64.powi(125);
    let below = limit - 2f64.powi(73);
    for (t, expected) in [(limit, Err(PoseError::Range { row: 0 })), (below, Ok(()))] {
        let pose = Pose64::from_translation([t, 0.0, 0.0]);
        assert_eq!(pose.check(&Aabb::EMPTY), expected, "{t:e}");
    }
    assert_eq!(Pose64::from_translation([1e308; 3]).check(&unit), Err(PoseError::Range { row: 0 }));
}
