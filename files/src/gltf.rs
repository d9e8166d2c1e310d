//! glTF and GLB, through `gltf`: the triangles of all meshes of the default scene (or of the first),
//! placed by their nodes, in f64. Strips and fans become triangles; points and lines are
//! passed over.

mod checked;

use crate::budget;
use crate::error::Fault;
use crate::folder::Folder;
use crate::import::Import;
use checked::Buffers;
use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf::mesh::{Mode, Semantic};
use gltf::scene::Transform;
use gltf::{Document, Gltf, Node, Primitive, Scene};

pub(crate) fn parse(bytes: &[u8], folder: &Folder<'_>, import: &mut Import) -> Result<(), Fault> {
    let Gltf { document, blob } = checked::document(bytes, &mut import.budget)?;
    let buffers = Buffers::load(&document, blob, folder, &mut import.budget)?;
    let document = &document;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| Fault::broken("there is no scene"))?;

    // A small file may place a mesh any number of times: what is asked for is counted before it is read.
    let mut bytes = 0;
    walk(document, &scene, |node, _| {
        for primitive in primitives(node) {
            bytes = demand(&primitive).saturating_add(bytes);
            import.budget.check(bytes)?;
        }
        Ok(())
    })?;
    walk(document, &scene, |node, world| {
        let name = node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned);
        import.source.begin_node(name, import.mesh.triangles.len());
        primitives(node).try_for_each(|primitive| push(import, &primitive, &buffers, world))
    })?;
    import.source.end_nodes(import.mesh.triangles.len());
    Ok(())
}

/// Calls `visit` for all nodes of a scene, children after their parent, with `world_from_node`.
fn walk(
    document: &Document,
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Node<'_>, &DMat4) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut pending: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    pending.reverse();
    let mut left = document.nodes().count();
    while let Some((node, above)) = pending.pop() {
        left = left.checked_sub(1).ok_or_else(|| Fault::broken("a node is below two others"))?;
        let world = above * transform(&node);
        visit(&node, &world)?;
        let first = pending.len();
        pending.extend(node.children().map(|child| (child, world)));
        pending[first..].reverse();
    }
    Ok(())
}

/// The primitives of a node that have triangles.
fn primitives<'n>(node: &Node<'n>) -> impl Iterator<Item = Primitive<'n>> + use<'n> {
    let is_of_triangles = |primitive: &Primitive<'_>| {
        matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    };
    node.mesh().into_iter().flat_map(|mesh| mesh.primitives()).filter(is_of_triangles)
}

/// The bytes that a primitive takes while it is read.
fn demand(primitive: &Primitive<'_>) -> usize {
    let vertices = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count());
    let corners = primitive.indices().map_or(vertices, |indices| indices.count());
    let triangles = if primitive.mode() == Mode::Triangles { corners / 3 } else { corners };
    budget::demand(vertices, triangles)
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
    import: &mut Import,
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    world: &DMat4,
) -> Result<(), Fault> {
    let in_f32 = import.source.in_f32;
    let mesh = &mut import.mesh;
    if let Some(positions) = primitive.get(&Semantic::Positions) {
        checked::positions(&positions, buffers)?;
    }
    if let Some(indices) = primitive.indices() {
        checked::indices(&indices, buffers)?;
    }
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()));
    let first = mesh.positions.len() as u32;
    // Positions that no node moves stay the same to the bit.
    let moves = *world != DMat4::IDENTITY;
    let place = |p: [f32; 3]| {
        let p = p.map(f64::from);
        let placed = if moves { world.transform_point3(DVec3::from(p)).to_array() } else { p };
        if in_f32 { placed.map(|x| f64::from(x as f32)) } else { placed }
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
    match primitive.mode() {
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
