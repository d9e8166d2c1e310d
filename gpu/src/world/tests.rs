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

/// A posed body in f64.
struct Placed {
    pose: Pose,
    matrix: DMat3,
    translation: DVec3,
    reach: DVec3,
}

/// Coordinates of the mesh are at most so large.
const FAR: DVec3 = DVec3::new(1.0, 0.5, 2.0);

/// The roundings of a posed coordinate: 6 units.
const POSED: f64 = 6.0 / (1 << 24) as f64;

impl Placed {
    fn new(pose: Pose) -> Self {
        let rows = pose.rows.map(|row| row.map(f64::from));
        let matrix = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
        let translation = DVec3::from_array(rows.map(|[.., t]| t));
        let reach = magnitudes(matrix) * FAR + translation.abs();
        Self { pose, matrix, translation, reach }
    }

    /// The inverse, and a bound on the error of its entries.
    fn inverse(&self) -> (DMat3, f64) {
        let [own, inverse] = [self.matrix, self.matrix.inverse()].map(largest);
        let stretch = own.powi(3) / self.matrix.determinant().abs();
        (self.matrix.inverse(), stretch * inverse * f64::exp2(-46.0))
    }
}

fn magnitudes(matrix: DMat3) -> DMat3 {
    DMat3::from_cols_array(&matrix.to_cols_array().map(f64::abs))
}

fn largest(matrix: DMat3) -> f64 {
    matrix.to_cols_array().into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn vector(x: [f32; 3]) -> DVec3 {
    DVec3::from_array(x.map(f64::from))
}

/// The rows that the device makes of bodies in turn: the first and the second, the third and the fourth. And whether the second of each
/// is to be seen from the first.
fn rows(world: &mut World, poses: &[Pose]) -> Vec<(InstancePair, bool)> {
    let bodies: Vec<_> = poses.iter().map(|&pose| (0, pose)).collect();
    world.set_bodies(&bodies).unwrap();
    let pairs: Vec<_> = (0..poses.len() as u32).step_by(2).map(|a| [a, a + 1]).collect();
    world.submit(&pairs, GpuVerb::Count).unwrap();
    let (gpu, table) = (world.runner.engine.gpu.clone(), world.table.buffers.as_ref().unwrap());
    let encoder = world.runner.engine.encoder();
    let (device, queue) = (gpu.device(), gpu.queue());
    let rows = read_now(device, queue, encoder, &table.pairs, pairs.len(), None);
    let is_seen = world
        .bodies
        .chunks_exact(2)
        .map(|two| two[0].kind & INVERTIBLE != 0 && two[1].kind & IN_RANGE != 0);
    pollster::block_on(rows).unwrap().into_iter().zip(is_seen).collect()
}

/// Checks a row.
fn check((row, is_seen): &(InstancePair, bool), [a, b]: [&Placed; 2], point: [f32; 3]) {
    let Placed { matrix: turn, translation: offset, .. } = Placed::new(Pose::new(row.boxes));
    assert_eq!(row.poses, [a.pose.rows, b.pose.rows]);
    // Shaders pad by so much of what they turn; the rest of the padding is for what the row is off by.
    let spare = |pad: [f32; 3], t: DVec3| vector(pad) - t.abs() * f64::from(PADDING) * 0.999_999;
    let flushed =
        DVec3::splat(f64::from(f32::MIN_POSITIVE) * 16.0 * (1.0 + FAR.element_sum() / 2.0));
    assert!(spare(row.pad_a, a.translation).cmpge(flushed).all());
    if !is_seen {
        assert_eq!(row.boxes, b.pose.rows);
        let posed = [a, b].map(|own| u32::from(own.pose != Pose::IDENTITY));
        assert_eq!(row.posed_boxes, posed[0] | posed[1] << 1);
        assert!(spare(row.pad_b, b.translation).cmpge(flushed).all());
        return;
    }
    assert_eq!(row.posed_boxes, 2);
    let ((inverse, error), reach) = (a.inverse(), a.reach + b.reach);
    let off = magnitudes(turn - inverse * b.matrix) * FAR
        + (offset - inverse * (b.translation - a.translation)).abs()
        + magnitudes(inverse) * reach * POSED
        + DVec3::splat(error * reach.element_sum());
    assert!((off + flushed).cmple(spare(row.pad_b, offset)).all(), "{row:?}: {off}");
    // A point that both have, as far as f32 tells.
    let common = vector(a.pose.apply(point));
    let y = (b.inverse().0 * (common - b.translation)).as_vec3().as_dvec3();
    if y.abs().cmple(FAR).all() {
        let most = vector(row.pad_b) + magnitudes(turn) * y.abs() * f64::from(PADDING);
        let seen = turn * y + offset;
        assert!((seen - vector(point)).abs().cmple(most).all(), "{row:?}: {seen} {point:?}");
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
    for (number, [own, other]) in
        scales.map(|x| scales.map(|y| [x, y])).as_flattened().iter().enumerate()
    {
        let mut pose = |scale: f32| {
            let mut pose = Pose::new([(); 3].map(|()| [(); 4].map(|()| scale * random())));
            let far = if random() < 0.0 { 1.0 } else { 100.0 };
            pose.rows.iter_mut().for_each(|[.., t]| *t *= far);
            if random() < 0.9 { pose } else { Pose::IDENTITY }
        };
        let poses: Vec<_> =
            (0..1_000).map(|i| pose(if i % 2 == 0 { *own } else { *other })).collect();
        // More workgroups than have something to do store nothing.
        EXTRA.set(number as u32 % 2);
        let rows = rows(&mut world, &poses);
        EXTRA.set(0);
        let placed: Vec<_> = poses.iter().map(|pose| Placed::new(*pose)).collect();
        for (row, two) in rows.iter().zip(placed.chunks_exact(2)) {
            let point = FAR.to_array().map(|far| far as f32 * random());
            check(row, [&two[0], &two[1]], point);
        }
        let seen = rows.iter().filter(|(_, is_seen)| *is_seen).count();
        let is_usual = (1e-13..1e13).contains(own) && *other < 1e13;
        assert_eq!(seen > 480, is_usual, "{own:e} and {other:e}: {seen}");
    }
    let flat = Pose::new([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]]);
    let rows = rows(&mut world, &[flat, Pose::from_translation([1.0; 3]), Pose::IDENTITY, flat]);
    assert_eq!(rows.iter().map(|(row, _)| row.posed_boxes).collect::<Vec<_>>(), [3, 2]);
}
