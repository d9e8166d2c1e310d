//! Contacts of the generated scenes: always there, and the same on every machine.

use super::contacts::{Body, Contacts, Site};
use anyhow::Result;
use glam::{DAffine3, DMat3, DVec3};
use pfront::{Model, Pose};
use pfront_testkit::Rows;
use pfront_testkit::scenes::{Kind, Scene, round};
use std::sync::Arc;

/// The scenes, and the frames of each that are harvested: some in which its bodies touch.
const SCENES: [(&str, &[usize]); 4] = [
    ("worm-gear", &[0, 17, 34, 51, 68, 85, 102]),
    ("epicyclic", &[0, 31, 62]),
    ("torus-knots", &[35, 45, 55, 65, 75, 85]),
    ("sheet", &[60, 80, 100]),
];

/// All sets, each in about `size` triangles.
pub(super) fn all(size: Option<usize>) -> Result<Vec<Contacts>> {
    SCENES.map(|(name, frames)| contacts(name, frames, size)).into_iter().collect()
}

fn contacts(name: &'static str, frames: &[usize], size: Option<usize>) -> Result<Contacts> {
    let scene = Scene::by_name(name, size)?;
    let model = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        Model::new(positions.to_vec(), triangles.to_vec()).map(Arc::new)
    };
    let bodies = scene.meshes.iter().map(|mesh| model(&mesh.positions, &mesh.triangles));
    let bodies = bodies.collect::<Result<Vec<Body>, _>>()?;
    let (mut sites, mut poses, mut positions) = (Vec::new(), Vec::new(), Vec::new());
    for &frame in frames {
        if scene.kind() == Kind::SelfMesh {
            scene.positions(frame, &mut positions);
            sites.push(Site::Within(model(&positions, &scene.meshes[0].triangles)?));
            continue;
        }
        scene.poses(frame, &mut poses);
        for (i, pose_a) in poses.iter().enumerate() {
            for (j, pose_b) in poses.iter().enumerate().skip(i + 1) {
                let [a, b] = [i, j].map(|object| bodies[scene.objects[object]].clone());
                let a_from_b = Pose::new(round(affine(pose_a).inverse() * affine(pose_b)));
                sites.push(Site::Pair { a, b, a_from_b });
            }
        }
    }
    Contacts::new(name, sites)
}

fn affine(rows: &Rows) -> DAffine3 {
    let [x, y, z] = rows.map(|row| row.map(f64::from));
    let linear = [x, y, z].map(|[u, v, w, _]| DVec3::new(u, v, w));
    let linear = DMat3::from_cols(linear[0], linear[1], linear[2]).transpose();
    DAffine3::from_mat3_translation(linear, DVec3::new(x[3], y[3], z[3]))
}
