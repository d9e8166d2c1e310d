//! The pose of a node in the file: instances, morph targets and skins.

use super::accessor;
use super::checked::{Buffers, INSTANCING};
use crate::budget::Budget;
use crate::error::Fault;
use glam::{DMat4, DQuat, DVec3};
use gltf::accessor::Accessor;
use gltf::mesh::Semantic;
use gltf::{Document, Node, Primitive};
use std::collections::HashMap;
use std::rc::Rc;

/// The weights of morph targets, and the matrices of joints: world from mesh.
pub(super) struct Pose {
    weights: Vec<f64>,
    joints: Option<Rc<[DMat4]>>,
}

/// The matrices of the joints of skins, by the number of the skin.
pub(super) type Skins = HashMap<usize, Rc<[DMat4]>>;

/// The weights of the morph targets of a node.
pub(super) fn weights<'d>(node: &Node<'d>) -> &'d [f32] {
    let of_mesh = || node.mesh().and_then(|mesh| mesh.weights());
    node.weights().or_else(of_mesh).unwrap_or_default()
}

/// The bytes of the numbers that move so many vertices: those of each morph target with a weight, and of each set of joints.
pub(super) fn demand(
    primitive: &Primitive<'_>,
    weights: &[f32],
    is_skinned: bool,
    vertices: usize,
) -> usize {
    let targets = primitive.morph_targets().zip(weights);
    let targets =
        targets.filter(|(target, weight)| **weight != 0.0 && target.positions().is_some());
    let moves = size_of::<[f64; 3]>().saturating_mul(targets.count());
    let sets = if is_skinned { sets(primitive).count() } else { 0 };
    let of_sets = size_of::<[[f64; 4]; 2]>().saturating_mul(sets);
    let sums = if is_skinned { size_of::<Sum>() } else { 0 };
    vertices.saturating_mul(moves.saturating_add(of_sets).saturating_add(sums))
}

/// The accessors of the joints and of the weights of each set.
fn sets<'d>(primitive: &Primitive<'d>) -> impl Iterator<Item = (Accessor<'d>, Accessor<'d>)> {
    (0..).map_while(|set| {
        let joints = primitive.get(&Semantic::Joints(set))?;
        Some((joints, primitive.get(&Semantic::Weights(set))?))
    })
}

/// A vertex as its joints so far place it, times their weights, and these.
type Sum = (DVec3, f64);

impl Pose {
    /// The pose of a node; `worlds` are the matrices of all nodes of the scene.
    pub(super) fn new(
        node: &Node<'_>,
        worlds: &[Option<DMat4>],
        skins: &mut Skins,
        buffers: &Buffers,
        budget: &mut Budget,
    ) -> Result<Self, Fault> {
        let weights = weights(node).iter().map(|&w| w.into()).collect();
        let Some(skin) = node.skin().filter(|_| node.mesh().is_some()) else {
            return Ok(Self { weights, joints: None });
        };
        if let Some(joints) = skins.get(&skin.index()) {
            return Ok(Self { weights, joints: Some(joints.clone()) });
        }
        budget.take(skin.joints().count().saturating_mul(size_of::<DMat4>()))?;
        let inverse = match skin.inverse_bind_matrices() {
            Some(matrices) => accessor::matrices(&matrices, buffers, budget)?,
            None => Vec::new(),
        };
        let has_all = inverse.is_empty() || inverse.len() >= skin.joints().count();
        if !has_all {
            let what = format!("skin {} has fewer matrices than joints", skin.index());
            return Err(Fault::broken(what));
        }
        let joint = |(number, joint): (usize, Node<'_>)| {
            let world = worlds.get(joint.index()).copied().flatten();
            let world = world.ok_or_else(|| {
                Fault::broken(format!("joint node {} is not in the scene", joint.index()))
            })?;
            Ok(match inverse.get(number) {
                Some(matrix) => world * DMat4::from_cols_array(matrix),
                None => world,
            })
        };
        let joints: Rc<[DMat4]> =
            skin.joints().enumerate().map(joint).collect::<Result<_, Fault>>()?;
        skins.insert(skin.index(), joints.clone());
        Ok(Self { weights, joints: Some(joints) })
    }

    /// Whether positions are put into the world by joints, and not by the node.
    pub(super) fn is_skinned(&self) -> bool {
        self.joints.is_some()
    }

    /// Moves the positions of a primitive.
    pub(super) fn apply(
        &self,
        primitive: &Primitive<'_>,
        positions: &mut [[f64; 3]],
        buffers: &Buffers,
        budget: &Budget,
    ) -> Result<(), Fault> {
        for (target, &weight) in primitive.morph_targets().zip(&self.weights) {
            let Some(moves) = target.positions().filter(|_| weight != 0.0) else { continue };
            let moves = accessor::positions(&moves, buffers, budget)?;
            same_length("a morph target", moves.len(), positions.len())?;
            for (position, by) in positions.iter_mut().zip(moves) {
                *position = [0, 1, 2].map(|k| position[k] + weight * by[k]);
            }
        }
        let Some(matrices) = &self.joints else { return Ok(()) };
        budget.check(positions.len().saturating_mul(size_of::<Sum>()))?;
        let mut sums: Vec<Sum> = vec![(DVec3::ZERO, 0.0); positions.len()];
        for (set, (joints, weights)) in sets(primitive).enumerate() {
            let joints = accessor::joints(&joints, buffers, budget)
                .map_err(|fault| fault.within(format_args!("JOINTS_{set}")))?;
            let weights = accessor::fours(&weights, buffers, budget)?;
            same_length("JOINTS", joints.len(), positions.len())?;
            same_length("WEIGHTS", weights.len(), positions.len())?;
            for (vertex, (sum, total)) in sums.iter_mut().enumerate() {
                let at = DVec3::from(positions[vertex]);
                for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                    if weight == 0.0 {
                        continue;
                    }
                    let matrix = matrices.get(joint as usize).ok_or_else(|| {
                        Fault::broken(format!("vertex {vertex} has a joint {joint} of no skin"))
                    })?;
                    *sum += weight * matrix.transform_point3(at);
                    *total += weight;
                }
            }
        }
        for (vertex, (position, (sum, total))) in positions.iter_mut().zip(sums).enumerate() {
            // Weights that are written as integers do not sum up to 1.
            if total > 0.0 {
                *position = (sum / total).to_array();
            } else {
                return Err(Fault::broken(format!("vertex {vertex} of a skin has no weights")));
            }
        }
        Ok(())
    }
}

fn same_length(what: &str, found: usize, vertices: usize) -> Result<(), Fault> {
    if found == vertices {
        return Ok(());
    }
    Err(Fault::broken(format!("{what} of {found} elements for {vertices} vertices")))
}

/// The accessor of an attribute of instances.
fn attribute<'d>(
    node: &Node<'_>,
    document: &'d Document,
    name: &str,
) -> Result<Option<Accessor<'d>>, Fault> {
    let number = node.extension_value(INSTANCING).and_then(|value| value["attributes"].get(name));
    let Some(number) = number else { return Ok(None) };
    let accessor = number.as_u64().and_then(|number| document.accessors().nth(number as usize));
    accessor.map(Some).ok_or_else(|| Fault::broken(format!("there is no accessor {number}")))
}

const ATTRIBUTES: [&str; 3] = ["TRANSLATION", "ROTATION", "SCALE"];

/// How often a node places its mesh.
pub(super) fn instances_count(node: &Node<'_>, document: &Document) -> Result<usize, Fault> {
    let mut count = None;
    for name in ATTRIBUTES {
        let Some(accessor) = attribute(node, document, name)? else { continue };
        let first = *count.get_or_insert(accessor.count());
        same_length(name, accessor.count(), first)?;
    }
    Ok(count.unwrap_or(1))
}

/// The matrices of the instances of a node, or the identity.
pub(super) fn instances(
    node: &Node<'_>,
    document: &Document,
    buffers: &Buffers,
    budget: &Budget,
) -> Result<Vec<DMat4>, Fault> {
    let count = instances_count(node, document)?;
    let [translation, rotation, scale] = ATTRIBUTES.map(|name| attribute(node, document, name));
    let threes = |accessor: Option<Accessor<'_>>| {
        accessor.map(|accessor| accessor::positions(&accessor, buffers, budget)).transpose()
    };
    let (translation, scale) = (threes(translation?)?, threes(scale?)?);
    let rotation = rotation?.map(|accessor| accessor::fours(&accessor, buffers, budget));
    let rotation = rotation.transpose()?;
    budget.check(count.saturating_mul(size_of::<DMat4>()))?;
    let three = |list: &Option<Vec<[f64; 3]>>, i: usize, default| {
        list.as_ref().map_or(default, |list| DVec3::from(list[i]))
    };
    let matrix = |i: usize| {
        let rotation =
            rotation.as_ref().map_or(Ok(DQuat::IDENTITY), |list| self::rotation(list[i]))?;
        let [scale, translation] =
            [three(&scale, i, DVec3::ONE), three(&translation, i, DVec3::ZERO)];
        Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
    };
    (0..count).map(matrix).collect()
}

/// The rotation of a quaternion, which need not have length 1.
pub(super) fn rotation(quaternion: [f64; 4]) -> Result<DQuat, Fault> {
    let quaternion = DQuat::from_array(quaternion);
    if quaternion.length_squared() == 0.0 {
        return Err(Fault::broken("a rotation is a quaternion of length 0"));
    }
    Ok(quaternion.normalize())
}
