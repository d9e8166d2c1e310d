//! Where in its file a triangle comes from, and what was lost on the way.

use std::collections::{HashMap, HashSet};

/// The faces and nodes of a file, and its coordinates that f32 does not hold.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The first triangle of each face, if faces may have more than one.
    pub(crate) faces: Vec<u32>,
    nodes: Vec<GltfNode>,
    /// Whether coordinates are rounded to f32.
    pub(crate) in_f32: bool,
    /// If they are, those with more digits than the nearest f32 has.
    pub rounded: usize,
    /// The first line with a coordinate that is not finite, or too large for f64, if the file is text.
    pub out_of_range: Option<usize>,
}

/// A glTF node and the first triangle that it placed.
#[derive(Clone, Debug)]
struct GltfNode {
    name: String,
    triangle: u32,
}

/// Numbers all but the first of those that have one name: `Lid`, `Lid (2)`.
pub fn name_apart<'n>(names: impl Iterator<Item = &'n mut String>) {
    let (mut taken, mut counts) = (HashSet::new(), HashMap::new());
    for name in names {
        let plain = name.clone();
        let count = counts.entry(plain.clone()).or_insert(1_usize);
        while !taken.insert(name.clone()) {
            *count += 1;
            *name = format!("{plain} ({count})");
        }
    }
}

impl Source {
    pub(crate) fn begin_node(&mut self, name: String, triangles: usize) {
        let triangle = triangles as u32;
        // A node without triangles is none.
        self.nodes.pop_if(|last| last.triangle == triangle);
        self.nodes.push(GltfNode { name, triangle });
    }

    pub(crate) fn end_nodes(&mut self, triangles: usize) {
        self.nodes.pop_if(|last| last.triangle as usize == triangles);
        name_apart(self.nodes.iter_mut().map(|node| &mut node.name));
    }

    /// The face of a triangle, from 0 in the file; in glTF the triangle's own number, from 0 in its node.
    pub fn face(&self, triangle: u32) -> u32 {
        match self.faces.partition_point(|&first| first <= triangle) {
            0 => triangle - self.node_of(triangle).map_or(0, |node| node.triangle),
            after => after as u32 - 1,
        }
    }

    /// The name of the glTF node that placed a triangle; no two nodes of a file have the same.
    pub fn node(&self, triangle: u32) -> Option<&str> {
        self.node_of(triangle).map(|node| &node.name[..])
    }

    fn node_of(&self, triangle: u32) -> Option<&GltfNode> {
        let after = self.nodes.partition_point(|node| node.triangle <= triangle);
        self.nodes.get(after.checked_sub(1)?)
    }

    /// The glTF nodes that placed triangles, and the first triangle of each, ascending.
    pub fn nodes(&self) -> impl Iterator<Item = (&str, u32)> {
        self.nodes.iter().map(|node| (&node.name[..], node.triangle))
    }
}
