//! glTF and GLB, through `gltf`: the triangles of all meshes of the default scene (or of the first),
//! placed by their nodes, in f64 and rounded once. Strips and fans become triangles; points and lines are
//! passed over.

use super::MeshData;
use super::error::Fault;
use glam::{DMat4, DVec3, Mat4};
use gltf::buffer::Data;
use gltf::json::Root;
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive};
use std::path::Path;

pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<MeshData, Fault> {
    let broken = |e: gltf::Error| Fault::broken(e.to_string());
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(broken)?;
    let root = document.into_json();
    no_stray_positions(&root)?;
    let document = Document::from_json(root).map_err(broken)?;
    let buffers = gltf::import_buffers(&document, path.parent(), blob).map_err(broken)?;
    for accessor in document.accessors() {
        inside(&accessor, &buffers)?;
    }
    let mut mesh = MeshData::default();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots = scene.iter().flat_map(gltf::Scene::nodes);
    let mut pending: Vec<(Node<'_>, DMat4)> = roots.map(|node| (node, DMat4::IDENTITY)).collect();
    pending.reverse();
    let mut left = document.nodes().count();
    while let Some((node, above)) = pending.pop() {
        left = left.checked_sub(1).ok_or_else(|| Fault::broken("a node is its own ancestor"))?;
        let world = above * Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4();
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            push(&mut mesh, &primitive, &buffers, &world)?;
        }
        let first = pending.len();
        pending.extend(node.children().map(|child| (child, world)));
        pending[first..].reverse();
    }
    Ok(mesh)
}

/// `gltf` takes for granted, before it checks, that the accessors of positions exist.
fn no_stray_positions(root: &Root) -> Result<(), Fault> {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut used = primitives.flat_map(|primitive| primitive.attributes.values());
    match used.find(|accessor| accessor.value() >= root.accessors.len()) {
        Some(stray) => Err(Fault::broken(format!("there is no accessor {}", stray.value()))),
        None => Ok(()),
    }
}

/// Checks that an accessor stays within its buffer, which `gltf` does not.
fn inside(accessor: &gltf::Accessor<'_>, buffers: &[Data]) -> Result<(), Fault> {
    let fault =
        || Fault::broken(format!("accessor {} reaches beyond its buffer", accessor.index()));
    let views = [
        accessor.view().map(|view| (view, accessor.offset(), accessor.count(), accessor.size())),
        accessor.sparse().map(|sparse| {
            let (indices, count) = (sparse.indices(), sparse.count());
            (indices.view(), indices.offset(), count, indices.index_type().size())
        }),
        accessor.sparse().map(|sparse| {
            let values = sparse.values();
            (values.view(), values.offset(), sparse.count(), accessor.size())
        }),
    ];
    for (view, offset, count, size) in views.into_iter().flatten() {
        let stride = view.stride().unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(size));
        let end = last.and_then(|n| n.checked_add(offset)).ok_or_else(fault)?;
        let view_end = view.offset().checked_add(view.length()).ok_or_else(fault)?;
        let buffer = buffers.get(view.buffer().index()).map_or(0, |data| data.len());
        if end > view.length() || view_end > buffer {
            return Err(fault());
        }
    }
    // Without a view all is zero, and takes no bytes however much there is of it.
    if accessor.view().is_none() && accessor.count() > buffers.iter().map(|data| data.len()).sum() {
        return Err(fault());
    }
    Ok(())
}

fn push(
    mesh: &mut MeshData,
    primitive: &Primitive<'_>,
    buffers: &[Data],
    world: &DMat4,
) -> Result<(), Fault> {
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data[..]));
    let Some(positions) = reader.read_positions() else { return Ok(()) };
    let first = mesh.positions.len();
    // What stays where it is stays so to the bit.
    let moves = *world != DMat4::IDENTITY;
    let place = |p: [f32; 3]| {
        let moved = |p| world.transform_point3(DVec3::from(p)).as_vec3().to_array();
        if moves { moved(p.map(f64::from)) } else { p }
    };
    mesh.positions.extend(positions.map(place));
    let added = mesh.positions.len() - first;
    let corners: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..added as u32).collect(),
    };
    if let Some(stray) = corners.iter().find(|&&corner| corner as usize >= added) {
        return Err(Fault::broken(format!("there is no vertex {stray} among {added}")));
    }
    let corners: Vec<u32> = corners.into_iter().map(|corner| corner + first as u32).collect();
    match primitive.mode() {
        Mode::Triangles => {
            mesh.triangles.extend(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
        }
        // Every other triangle of a strip is turned round.
        Mode::TriangleStrip => mesh.triangles.extend(
            corners
                .windows(3)
                .zip([false, true].into_iter().cycle())
                .map(|(t, odd)| if odd { [t[1], t[0], t[2]] } else { [t[0], t[1], t[2]] }),
        ),
        Mode::TriangleFan => mesh.push_fan(&corners),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {}
    }
    Ok(())
}
