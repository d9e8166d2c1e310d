//! The two ways a walk places a mesh.

use crate::Pose;
use crate::aabb::Bounds;
use crate::simd::{Boxes, Simd};
use glam::Vec3A;
pub(crate) use posed::Posed;

mod posed;
#[cfg(test)]
mod tests;

/// How a walk sees a mesh: where its boxes and corners are in the frame of the query.
pub(crate) trait Placement {
    /// A box that contains the placed corners of everything in `bounds`.
    fn bounds(&self, bounds: &Bounds) -> Bounds;
    /// The same of four boxes.
    fn boxes(&self, boxes: &Boxes) -> Boxes;
    /// The placed corner.
    fn point(&self, p: Vec3A) -> Vec3A;
    /// Placed corners.
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3];
}

impl<P: Placement> Placement for &P {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        P::bounds(self, bounds)
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        P::boxes(self, boxes)
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        P::point(self, p)
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        P::points(self, p)
    }
}

/// The mesh is in the frame of the query as it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InPlace;

impl Placement for InPlace {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        *bounds
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        *boxes
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        p
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        p
    }
}

/// Either, for what is asked of single nodes; a walk asks once and keeps to the one or the other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    InPlace,
    Posed(Posed),
}

impl Place {
    pub(crate) fn new(pose: &Pose) -> Self {
        if *pose == Pose::IDENTITY { Self::InPlace } else { Self::Posed(Posed::new(pose)) }
    }
}

impl Placement for Place {
    #[inline]
    fn bounds(&self, bounds: &Bounds) -> Bounds {
        match self {
            Self::InPlace => InPlace.bounds(bounds),
            Self::Posed(posed) => posed.bounds(bounds),
        }
    }
    #[inline(always)]
    fn boxes(&self, boxes: &Boxes) -> Boxes {
        match self {
            Self::InPlace => *boxes,
            Self::Posed(posed) => posed.boxes(boxes),
        }
    }
    #[inline]
    fn point(&self, p: Vec3A) -> Vec3A {
        match self {
            Self::InPlace => InPlace.point(p),
            Self::Posed(posed) => posed.point(p),
        }
    }
    #[inline(always)]
    fn points<S: Simd>(&self, p: [S; 3]) -> [S; 3] {
        match self {
            Self::InPlace => p,
            Self::Posed(posed) => posed.points(p),
        }
    }
}
