//! Where a point is, by its winding number.
//!
//! A ray along the third axis starts at p + (ε, ε², 0), for ε towards 0, so that it meets no edge (Edelsbrunner & Mücke, *Simulation
//! of Simplicity*, 1990). Unless p is on the surface, it has the winding number of p.

use super::ray::{is_beside, side_of_shifted, surrounds};
use super::{Rule, Solid};
use crate::bvtt::PosedBvh;
use crate::exact::Exact;
use crate::exact::orientation::sides;
use crate::mesh::check_position;
use crate::triangle::{flat, intersects_in_f64, turn};
use crate::{MeshError, Pose};
use core::ops::ControlFlow;

/// Where a point is, as a solid sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Location {
    /// In the interior.
    Inside,
    /// On a triangle, also on one that bounds nothing.
    Surface,
    /// Anywhere else.
    Outside,
}

impl Rule {
    /// Where a point is, as a closed mesh sees it that has this rule and is posed: exactly. A pose may round positions, which leaves a closed mesh closed.
    ///
    /// # Errors
    /// [`MeshError`] if a coordinate of the point, as vertex 0, is NaN or beyond ±2^125.
    ///
    /// # Complexity
    /// O(nodes whose boxes a ray from the point reaches); no allocation, bounded stack.
    pub fn inside(
        self,
        posed: &PosedBvh<'_>,
        point: [impl Into<f64>; 3],
    ) -> Result<Location, MeshError> {
        let point = point.map(Into::into);
        check_position(0, point)?;
        Ok(match winding_number(posed, &point) {
            None => Location::Surface,
            Some(winding) if self.is_inside(winding) => Location::Inside,
            Some(_) => Location::Outside,
        })
    }
}

impl Solid<'_> {
    /// Where a point is: exactly, by its winding number and the [rule](Solid::rule). Triangles that meet their own mesh leave nothing
    /// undetermined here, as they do in a relation: the winding number of a point is that of all triangles, however these meet.
    ///
    /// # Errors
    /// [`MeshError`] if a coordinate of the point, as vertex 0, is NaN or beyond ±2^125.
    ///
    /// # Complexity
    /// As [`Rule::inside`].
    ///
    /// # Examples
    /// ```
    /// # use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
    /// # use pfront_core::relation::{Solid, solid_bound, solid_scratch_bound};
    /// # use pfront_core::{Mesh, Node};
    /// use pfront_core::relation::Location;
    /// # let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let mesh = Mesh::new(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// # let (mut nodes, mut order) = ([Node::EMPTY; node_bound(4)], [0; 4]);
    /// # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// # let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 8])?;
    /// # let (mut words, mut scratch) = ([0; solid_bound(4, 4)], [0; solid_scratch_bound(4, 4)]);
    /// let tetrahedron = Solid::new(bvh, &mut words, &mut scratch)?;
    /// assert_eq!(tetrahedron.inside([0.25, 0.25, 0.25])?, Location::Inside);
    /// assert_eq!(tetrahedron.inside([0.25, 0.25, 0.5])?, Location::Surface);
    /// assert_eq!(tetrahedron.inside([0.25, 0.25, 0.5 + f64::EPSILON])?, Location::Outside);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inside(&self, point: [impl Into<f64>; 3]) -> Result<Location, MeshError> {
        self.rule().inside(&PosedBvh::new_unchecked(self.bvh(), &Pose::IDENTITY), point)
    }
}

/// The winding number of a mesh at a point; `None` if a triangle contains the point.
fn winding_number(posed: &PosedBvh<'_>, point: &[f64; 3]) -> Option<i32> {
    let [start] = flat(&[*point], AXIS);
    let mut winding = 0;
    let is_above = |bounds: &crate::aabb::Bounds| {
        let (min, max) = (bounds.min.as_dvec3().to_array(), bounds.max.as_dvec3().to_array());
        (0..AXIS).all(|k| min[k] <= point[k] && point[k] <= max[k]) && point[AXIS] <= max[AXIS]
    };
    let end = posed.visit_reached(is_above, |triangle| {
        let corners = posed.corners(triangle);
        let below = flat(&corners, AXIS);
        if !surrounds(&below, &start) {
            return ControlFlow::Continue(());
        }
        let is_level = !is_beside(corners.map(|corner| corner[AXIS]), point[AXIS]);
        if is_level && intersects_in_f64(&corners, &[*point; 3]) {
            return ControlFlow::Break(());
        }
        let turned = turn::<Exact<f64>>(&corners, AXIS).unwrap_or(0);
        let is_within =
            |&(u, v): &(usize, usize)| side_of_shifted([&below[u], &below[v]], &start, 1) == turned;
        if turned != 0 && [(0, 1), (1, 2), (2, 0)].iter().all(is_within) {
            let [side] = sides(corners.each_ref(), [point]);
            // Not 0: the triangle would contain the point.
            if side != turned {
                winding += turned;
            }
        }
        ControlFlow::Continue(())
    });
    end.is_continue().then_some(winding)
}

/// The axis along which rays run.
const AXIS: usize = 2;
