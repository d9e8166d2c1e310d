//! glTF and GLB, through `gltf`: the triangles of all meshes of the default scene (or of the first), placed by their nodes and
//! instances, in f64, in the pose of the file: morph targets by their weights, skins by their joints. Strips and fans
//! become triangles; points and lines are passed over.

mod accessor;
mod checked;
mod pose;

use crate::budget;
use crate::error::Fault;
use crate::folder::Folder;
use crate::import::Import;
use checked::Buffers;
use glam::{DMat4, Mat4, Vec3};
use gltf::accessor::Accessor;
use gltf::mesh::{Mode, Semantic};
use gltf::scene::Transform;
use gltf::{Document, Gltf, Node, Primitive};
use pose::{Pose, Skins};
use std::collections::HashSet;

pub(crate) fn parse(bytes: &[u8], folder: &Folder<'_>, import: &mut Import) -> Result<(), Fault> {
    import.is_split = true;
    let Gltf { document, blob } = checked::document(bytes, import)?;
    let buffers = Buffers::load(&document, blob, folder, &mut import.budget)?;
    let document = &document;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<_> = match &scene {
        Some(scene) => scene.nodes().collect(),
        None => {
            import.notes.push("there is no scene: all nodes are read".to_owned());
            let children = document.nodes().flat_map(|node| node.children());
            let children: HashSet<_> = children.map(|child| child.index()).collect();
            document.nodes().filter(|node| !children.contains(&node.index())).collect()
        }
    };

    // A small file may place a mesh any number of times: what is asked for is counted before it is read.
    let mut bytes = 0;
    let mut worlds = vec![None; document.nodes().len()];
    let mut others = 0;
    walk(document, &roots, |node, world| {
        worlds[node.index()] = Some(*world);
        let times = pose::instances_count(node, document)?;
        let weights = pose::weights(node);
        for primitive in node.mesh().into_iter().flat_map(|mesh| mesh.primitives()) {
            if !is_of_triangles(&primitive) {
                others += 1;
                continue;
            }
            let vertices = positions(&primitive)?.count();
            let posed = pose::demand(&primitive, weights, node.skin().is_some(), vertices);
            let demand = demand(&primitive, vertices).saturating_add(posed);
            bytes = demand.saturating_mul(times).saturating_add(bytes);
            import.budget.check(bytes)?;
        }
        Ok(())
    })?;
    if scene.is_none()
        && let Some(node) = worlds.iter().position(Option::is_none)
    {
        return Err(Fault::broken(format!("node {node} is below itself")));
    }
    import.note("primitives of points and lines are passed over", others);
    let is_elsewhere = |node: &Node<'_>| node.mesh().is_some() && worlds[node.index()].is_none();
    let elsewhere = document.nodes().filter(is_elsewhere).count();
    import.note("nodes with a mesh outside of the scene are passed over", elsewhere);
    let mut skins = Skins::default();
    walk(document, &roots, |node, world| {
        let name = node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned);
        let pose = Pose::new(node, &worlds, &mut skins, &buffers, &mut import.budget)?;
        for instance in pose::instances(node, document, &buffers, &import.budget)? {
            import.begin_body(name.clone())?;
            let world = if pose.is_skinned() { instance } else { *world * instance };
            let primitives = node.mesh().into_iter().flat_map(|mesh| mesh.primitives());
            for primitive in primitives.filter(is_of_triangles) {
                push(import, &primitive, &buffers, &world, &pose)?;
            }
        }
        Ok(())
    })
}

/// Calls `visit` for all nodes below some, children after their parent, with `world_from_node`. Every node is reached
/// once, or the file is refused.
fn walk<'d>(
    document: &'d Document,
    roots: &[Node<'d>],
    mut visit: impl FnMut(&Node<'d>, &DMat4) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut seen = vec![false; document.nodes().len()];
    let mut reach = |node: &Node<'_>| match std::mem::replace(&mut seen[node.index()], true) {
        true => Err(Fault::broken(format!("node {} is reached twice", node.index()))),
        false => Ok(()),
    };
    let mut pending = Vec::new();
    for root in roots {
        reach(root)?;
        pending.push((root.clone(), DMat4::IDENTITY));
    }
    pending.reverse();
    while let Some((node, above)) = pending.pop() {
        let own = transform(&node)
            .map_err(|fault| fault.within(format_args!("node {}", node.index())))?;
        let world = above * own;
        visit(&node, &world)?;
        let first = pending.len();
        for child in node.children() {
            reach(&child)?;
            pending.push((child, world));
        }
        pending[first..].reverse();
    }
    Ok(())
}

fn is_of_triangles(primitive: &Primitive<'_>) -> bool {
    matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

fn positions<'d>(primitive: &Primitive<'d>) -> Result<Accessor<'d>, Fault> {
    let missing = || Fault::broken(format!("primitive {} has no POSITION", primitive.index()));
    primitive.get(&Semantic::Positions).ok_or_else(missing)
}

/// The bytes that a primitive of so many vertices takes while it is read, without its pose.
fn demand(primitive: &Primitive<'_>, vertices: usize) -> usize {
    let corners = primitive.indices().map_or(vertices, |indices| indices.count());
    let triangles = if primitive.mode() == Mode::Triangles { corners / 3 } else { corners };
    budget::demand(vertices, triangles)
}

fn transform(node: &Node<'_>) -> Result<DMat4, Fault> {
    Ok(match node.transform() {
        Transform::Matrix { matrix } => Mat4::from_cols_array_2d(&matrix).as_dmat4(),
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation = pose::rotation(rotation.map(f64::from))?;
            let [scale, translation] = [scale, translation].map(|v| Vec3::from(v).as_dvec3());
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    })
}

fn push(
    import: &mut Import,
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    world: &DMat4,
    pose: &Pose,
) -> Result<(), Fault> {
    let accessor = positions(primitive)?;
    let budget = &import.budget;
    let mut positions = accessor::positions(&accessor, buffers, budget)?;
    pose.apply(primitive, &mut positions, buffers, budget)?;
    let first = import.push_placed(&positions, world);
    let (budget, mesh) = (&import.budget, &mut import.mesh);
    let end = mesh.positions.len() as u32;
    let corners: Vec<u32> = match primitive.indices() {
        Some(indices) => {
            let indices = accessor::indices(&indices, buffers, budget)?;
            indices.into_iter().map(|[i]| first.saturating_add(i as u32)).collect()
        }
        None => (first..end).collect(),
    };
    if let Some(stray) = corners.iter().find(|&&corner| corner >= end) {
        let (stray, all) = (stray - first, end - first);
        return Err(Fault::broken(format!("there is no vertex {stray} among {all}")));
    }
    match primitive.mode() {
        Mode::TriangleFan => mesh.push_fan(&corners),
        Mode::TriangleStrip => mesh.push_strip(&corners),
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
