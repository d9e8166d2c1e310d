//! Rows of pairs that the device makes, read back.

use super::World;
use crate::groups::EXTRA;
use crate::layout::InstancePair;
use crate::read::read_now;
use crate::{Gpu, GpuVerb};
use glam::{DMat3, DVec3};
use pfront_core::bvh::{BuildOptions, BvhStorage, node_bound, sah};
use pfront_core::{Mesh, Node, Pose};
use pfront_shaders::constants::{IN_RANGE, INVERTIBLE, PADDING};
use pfront_testkit::rng::{Rng, seeded};

/// Coordinates of the mesh are at most so large.
const FAR: DVec3 = DVec3::new(1.0, 0.5, 2.0);

/// The matrix and the translation of a pose.
fn parts(pose: &Pose) -> (DMat3, DVec3) {
    let rows = pose.rows.map(|row| row.map(f64::from));
    let matrix = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
    (matrix, DVec3::from_array(rows.map(|[.., t]| t)))
}

fn magnitudes(matrix: DMat3) -> DMat3 {
    DMat3::from_cols_array(&matrix.to_cols_array().map(f64::abs))
}

fn vector(x: [f32; 3]) -> DVec3 {
    DVec3::from_array(x.map(f64::from))
}

/// The rows that the device makes of bodies, the first with the second, the third with the fourth, and whether the second of each is to
/// be seen from the first.
fn rows(world: &mut World, poses: &[Pose]) -> Vec<(InstancePair, bool)> {
    let bodies: Vec<_> = poses.iter().map(|&pose| (0, pose)).collect();
    world.set_bodies(&bodies).unwrap();
    let pairs: Vec<_> = (0..poses.len() as u32).step_by(2).map(|a| [a, a + 1]).collect();
    world.submit(&pairs, GpuVerb::Count).unwrap();
    let (engine, table) = (&world.runner.engine, world.table.buffers.as_ref().unwrap());
    let (device, queue) = (engine.gpu.device(), engine.gpu.queue());
    let rows = read_now(device, queue, engine.encoder(), &table.pairs, pairs.len(), None);
    let is_seen = world
        .bodies
        .chunks_exact(2)
        .map(|two| two[0].kind & INVERTIBLE != 0 && two[1].kind & IN_RANGE != 0);
    pollster::block_on(rows).unwrap().into_iter().zip(is_seen).collect()
}

/// Checks a row, also at a point of the first body.
fn check((row, is_seen): &(InstancePair, bool), [a, b]: [&Pose; 2], point: [f32; 3]) {
    assert_eq!(row.poses, [a.rows, b.rows]);
    let [(of_a, to_a), (of_b, to_b), (turn, offset)] = [a, b, &Pose::new(row.boxes)].map(parts);
    // Shaders want so much of the padding for what they turn; the rest is for what the row is off by.
    let flushed = f64::from(f32::MIN_POSITIVE) * (16.0 + 8.0 * FAR.element_sum());
    let spare = |pad: [f32; 3], t: DVec3| {
        vector(pad) - t.abs() * f64::from(PADDING) * 0.999_999 - DVec3::splat(flushed)
    };
    assert!(spare(row.pad_a, to_a).cmpge(DVec3::ZERO).all());
    if !is_seen {
        let posed = [a, b].map(|pose| u32::from(*pose != Pose::IDENTITY));
        assert_eq!((row.boxes, row.posed_boxes), (b.rows, posed[0] | posed[1] << 1));
        assert!(spare(row.pad_b, to_b).cmpge(DVec3::ZERO).all());
        return;
    }
    assert_eq!(row.posed_boxes, 2);
    let [reach_a, reach_b] = [(of_a, to_a), (of_b, to_b)]
        .map(|(matrix, translation)| magnitudes(matrix) * FAR + translation.abs());
    let reach = reach_a + reach_b;
    let inverse = of_a.inverse();
    let largest =
        |matrix: DMat3| matrix.to_cols_array().into_iter().fold(0.0, |x, y| y.abs().max(x));
    let [own, other] = [of_a, inverse].map(largest);
    let error = f64::powi(own, 3) / of_a.determinant().abs() * other * f64::exp2(-46.0);
    // A posed coordinate is off by 6 units.
    let off = magnitudes(turn - inverse * of_b) * FAR
        + (offset - inverse * (to_b - to_a)).abs()
        + magnitudes(inverse) * reach * (6.0 * f64::exp2(-24.0))
        + DVec3::splat(error * reach.element_sum());
    assert!(off.cmple(spare(row.pad_b, offset)).all(), "{row:?}: {off}");
    // A point that both have, as far as f32 tells.
    let y = of_b.inverse() * (vector(a.apply(point)) - to_b);
    if y.abs().cmple(FAR).all() {
        let most = vector(row.pad_b) + magnitudes(turn) * y.abs() * f64::from(PADDING);
        let away = (turn * y + offset - vector(point)).abs();
        assert!(away.cmple(most).all(), "{row:?}: {away} {point:?}");
    }
}

#[test]
fn padding_covers_points_in_common() {
    let gpu = Gpu::new().unwrap_or_else(|error| panic!("{error}"));
    let far = FAR.as_vec3().to_array();
    let positions = [far, far.map(|x| -x), [0.5, -0.5, 1.0]];
    let mesh = Mesh::new(&positions, &[[0, 1, 2]]).unwrap();
    let (mut nodes, mut order) = (vec![Node::EMPTY; node_bound(1)], [0]);
    let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    let bvh = sah(mesh, &BuildOptions::default(), storage, &mut [Node::EMPTY]).unwrap();
    let mut world = World::new(&gpu, gpu.settings()).unwrap();
    world.add_mesh(bvh).unwrap();
    let mut rng = seeded(1);
    let mut random = || rng.next_u32() as f32 / (1_u32 << 31) as f32 - 1.0;
    let scales = [1.0, 1e-3, 1e6, 1e-12, 1e12, 1e-20, 1e20, 1e-38, 1e34];
    let all = scales.map(|x| scales.map(|y| [x, y]));
    for (two, extra) in all.as_flattened().iter().zip([0, 1].into_iter().cycle()) {
        let mut pose = |scale: f32| {
            let away = if random() < 0.0 { 1.0 } else { 100.0 };
            let flat = if random() < -0.5 { 1e-4 } else { 1.0 };
            let rows = [flat, 1.0, 1.0]
                .map(|flat| [1.0, 1.0, 1.0, away].map(|x| x * flat * scale * random()));
            if random() < 0.9 { Pose::new(rows) } else { Pose::IDENTITY }
        };
        let poses: Vec<_> = (0..1_000).map(|i| pose(two[i % 2])).collect();
        // More workgroups than have something to do store nothing.
        EXTRA.set(extra);
        let rows = rows(&mut world, &poses);
        EXTRA.set(0);
        for (row, poses) in rows.iter().zip(poses.as_chunks().0) {
            check(row, poses.each_ref(), far.map(|far| far * random()));
        }
        let seen = rows.iter().filter(|(_, is_seen)| *is_seen).count();
        let is_usual = (1e-13..1e13).contains(&two[0]) && two[1] < 1e13;
        assert_eq!(seen > 300, is_usual, "{two:?}: {seen}");
    }
    let flat = Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]]);
    let rows = rows(&mut world, &[flat, Pose::from_translation([1.0; 3]), Pose::IDENTITY, flat]);
    assert_eq!(rows.iter().map(|(row, _)| row.posed_boxes).collect::<Vec<_>>(), [3, 2]);
}
