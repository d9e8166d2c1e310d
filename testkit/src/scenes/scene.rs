//! A scene: meshes, the objects made of them, and how these move.

use std::fmt;

use glam::DAffine3;

use super::pose::round;
use crate::MeshData;
use crate::Rows;

/// Frames of a scene that names no other number.
pub(crate) const FRAMES: usize = 120;
/// Meshes, the objects made of them, and how these move.
pub struct Scene {
    /// The name, one of [`Scene::NAMES`].
    pub name: &'static str,
    /// The meshes, each in its own frame.
    pub meshes: Vec<MeshData>,
    /// The mesh of each object, as an index into `meshes`.
    pub objects: Vec<usize>,
    pub(crate) frames: usize,
    pub(crate) motion: Motion,
}

/// The kind of question that a scene asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Two rigid objects; the first stays at the identity, the second's pose is `a_from_b`.
    Pair,
    /// One deforming mesh against itself.
    SelfMesh,
    /// Many rigid objects, each against each.
    Many,
}

type PairMotion = dyn Fn(usize) -> DAffine3 + Send + Sync;
type ManyMotion = dyn Fn(usize, &mut Vec<Rows>) + Send + Sync;
type Deformation = dyn Fn(usize, &mut Vec<[f32; 3]>) + Send + Sync;

/// The function that computes each frame.
pub(crate) enum Motion {
    Pair(Box<PairMotion>),
    Many(Box<ManyMotion>),
    Deforming(Box<Deformation>),
}

impl Scene {
    /// The kind of question that the scene asks.
    pub fn kind(&self) -> Kind {
        match self.motion {
            Motion::Pair(_) => Kind::Pair,
            Motion::Many(_) => Kind::Many,
            Motion::Deforming(_) => Kind::SelfMesh,
        }
    }

    /// How many frames the scene has; the motion is defined beyond them too.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Writes world-from-object of each object in `frame`. The world of a pair is the first
    /// object's frame; a deforming mesh stays at the identity.
    pub fn poses(&self, frame: usize, out: &mut Vec<Rows>) {
        let identity = round(DAffine3::IDENTITY);
        match &self.motion {
            Motion::Pair(a_from_b) => {
                out.clear();
                out.extend([identity, round(a_from_b(frame))]);
            }
            Motion::Many(poses) => poses(frame, out),
            Motion::Deforming(_) => {
                out.clear();
                out.push(identity);
            }
        }
    }

    /// Writes the vertex positions of the first mesh in `frame`, in its own frame: for a deforming
    /// mesh new ones each time, otherwise those it has.
    pub fn positions(&self, frame: usize, out: &mut Vec<[f32; 3]>) {
        match &self.motion {
            Motion::Deforming(positions) => positions(frame, out),
            Motion::Pair(_) | Motion::Many(_) => self.meshes[0].positions.clone_into(out),
        }
    }

    /// Triangles of all objects together.
    pub fn triangles(&self) -> usize {
        self.objects.iter().map(|&mesh| self.meshes[mesh].triangles.len()).sum()
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Scene({}, {} triangles, {} frames)", self.name, self.triangles(), self.frames)
    }
}
