//! glTF and GLB, through `gltf`: the triangles of all meshes of the default scene (or of the first),
//! placed by their nodes, in f64 and rounded once. Strips and fans become triangles; points and lines are
//! passed over.

mod checked;

use super::MeshData;
use super::error::Fault;
use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf::buffer::Data;
use gltf::mesh::{Mode, Semantic};
use gltf::scene::Transform;
use gltf::{Node, Primitive};
use std::path::Path;

/// A small file may place a mesh any number of times.
const MOST_VERTICES: usize = 1 << 26;

pub(super) fn parse(bytes: &[u8], folder: &Path) -> Result<MeshData, Fault> {
    let (document, mut blob) = checked::document(bytes)?;
    let load = |buffer| checked::load(&buffer, folder, &mut blob);
    let buffers = document.buffers().map(load).collect::<Result<Vec<_>, _>>()?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Fault::broken("there is no scene"))?;

    let mut mesh = MeshData::default();
    let mut pending: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    pending.reverse();
    let mut left = document.nodes().count();
    while let Some((node, above)) = pending.pop() {
        left = left.checked_sub(1).ok_or_else(|| Fault::broken("a node is below two others"))?;
        let world = above * transform(&node);
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            push(&mut mesh, &primitive, &buffers, &world)?;
        }
        let first = pending.len();
        pending.extend(node.children().map(|child| (child, world)));
        pending[first..].reverse();
    }
    Ok(mesh)
}

fn transform(node: &Node<'_>) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => Mat4::from_cols_array_2d(&matrix).as_dmat4(),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation: DQuat = Quat::from_array(rotation).as_dquat().normalize();
            let [scale, translation] = [scale, translation].map(|v| Vec3::from(v).as_dvec3());
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    }
}

fn push(
    mesh: &mut MeshData,
    primitive: &Primitive<'_>,
    buffers: &[Data],
    world: &DMat4,
) -> Result<(), Fault> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    if let Some(positions) = primitive.get(&Semantic::Positions) {
        checked::positions(&positions, buffers)?;
    }
    if let Some(indices) = primitive.indices() {
        checked::indices(&indices, buffers)?;
    }
    let added = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count());
    if mesh.positions.len() + added > MOST_VERTICES {
        return Err(Fault::broken(format!("over {MOST_VERTICES} vertices, instances included")));
    }
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data[..]));
    let first = mesh.positions.len() as u32;
    // What stays where it is stays so to the bit.
    let moves = *world != DMat4::IDENTITY;
    let place = |p: [f32; 3]| {
        let moved = |p| world.transform_point3(DVec3::from(p)).as_vec3().to_array();
        if moves { moved(p.map(f64::from)) } else { p }
    };
    mesh.positions.extend(reader.read_positions().into_iter().flatten().map(place));
    let end = mesh.positions.len() as u32;

    let corners: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().map(|i| first.saturating_add(i)).collect(),
        None => (first..end).collect(),
    };
    if let Some(stray) = corners.iter().find(|&&corner| corner >= end) {
        let (stray, all) = (stray - first, end - first);
        return Err(Fault::broken(format!("there is no vertex {stray} among {all}")));
    }
    match mode {
        Mode::TriangleFan => mesh.push_fan(&corners),
        // Every other triangle of a strip is turned round.
        Mode::TriangleStrip => mesh.triangles.extend(
            corners
                .windows(3)
                .zip([false, true].into_iter().cycle())
                .map(|(t, odd)| if odd { [t[1], t[0], t[2]] } else { [t[0], t[1], t[2]] }),
        ),
        _ => {
            let (triangles, over) = corners.as_chunks();
            if !over.is_empty() {
                return Err(Fault::broken(format!("triangles of {} corners", corners.len())));
            }
            mesh.triangles.extend(triangles);
        }
    }
    Ok(())
}
