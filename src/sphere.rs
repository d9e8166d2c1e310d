//! Bounding spheres of bodies.
//!
//! The box of a rotated box is larger, the sphere of a rotated sphere is not. Spheres separate most bodies side by side
//! whose boxes overlap, before anything of their BVHs is read.

use glam::DVec3;
use pfront_core::bvtt::PosedBvh;
use pfront_core::{Aabb, Bvh, Distance, Pose, Pose64};

/// A closed ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub centre: [f32; 3],
    /// The radius; may be infinite.
    pub radius: f32,
}

impl Sphere {
    /// A sphere about the middle of the root's box that contains every vertex of every triangle; `None` for
    /// an empty mesh. O(triangles).
    pub(crate) fn of(bvh: &Bvh<'_>) -> Option<Self> {
        if bvh.mesh().is_f64() {
            return Some(Self::about(&PosedBvh::new_unchecked(*bvh, &Pose::IDENTITY).aabb()?));
        }
        let bounds = bvh.aabb()?;
        let centre = [0, 1, 2].map(|k| bounds.min[k] * 0.5 + bounds.max[k] * 0.5);
        let (mesh, middle) = (bvh.mesh(), vector(&centre));
        let corners = mesh.triangles().iter().flatten();
        let out = corners.map(|&v| vector(&mesh.shadow()[v as usize]) - middle);
        let farther =
            |x: DVec3, y: DVec3| if x.length_squared() > y.length_squared() { x } else { y };
        let radius = upwards(out.fold(DVec3::ZERO, farther).length());
        Some(Self { centre, radius })
    }

    /// A sphere that contains a box.
    fn about(bounds: &Aabb) -> Self {
        let centre = [0, 1, 2].map(|k| bounds.min[k] * 0.5 + bounds.max[k] * 0.5);
        let out = |corner: &[f32; 3]| (vector(corner) - vector(&centre)).length();
        Self { centre, radius: upwards(out(&bounds.min).max(out(&bounds.max))) }
    }

    /// A sphere that contains the points of this one as [`Pose::apply`] poses them, rounding included; in f64 they are
    /// rounded less. The identity changes nothing.
    ///
    /// A ball is stretched at most by the square root of the largest eigenvalue of RᵀR. This is no larger than
    /// the largest sum of absolute values along a row, which is l²·m for the longest column l of R, and
    /// l·√m is at most l·(1 + m)/2; for rotations and scalings, m = 1. The error of a posed point is
    /// bounded by [`Pose::ROUNDING`].
    pub(crate) fn posed(&self, pose: &Pose64) -> Self {
        if *pose == Pose64::IDENTITY {
            return *self;
        }
        let [a, b, c] = pose.rows;
        let [x, y, z] = [
            DVec3::new(a[0], b[0], c[0]),
            DVec3::new(a[1], b[1], c[1]),
            DVec3::new(a[2], b[2], c[2]),
        ];
        let translation = DVec3::new(a[3], b[3], c[3]);
        let (centre, radius) = (vector(&self.centre), f64::from(self.radius));
        let row = |v: DVec3| v.dot(x).abs() + v.dot(y).abs() + v.dot(z).abs();
        let longest = x.length().max(y.length()).max(z.length()).max(1e-60);
        let sum = row(x).max(row(y)).max(row(z)) / (longest * longest);
        let stretch = longest * 0.5 * (1.0 + sum);
        let far = centre.abs() + DVec3::splat(radius);
        let reach = x.abs() * far.x + y.abs() * far.y + z.abs() * far.z + translation.abs();
        let error =
            reach * f64::from(Pose::ROUNDING) + DVec3::splat(2.0 * f64::from(f32::MIN_POSITIVE));
        let centre = (x * centre.x + y * centre.y + z * centre.z + translation).as_vec3();
        if !centre.is_finite() {
            return Self { centre: [0.0; 3], radius: f32::INFINITY };
        }
        Self { centre: centre.to_array(), radius: upwards(stretch * radius + error.length()) }
    }

    /// Whether two balls may have points within a distance; `false` is certain.
    #[inline]
    pub(crate) fn is_near(&self, other: &Self, within: Distance) -> bool {
        let reach = f64::from(self.radius) + f64::from(other.radius) + f64::from(within.get());
        let distance = vector(&self.centre).distance_squared(vector(&other.centre));
        let separated = distance > reach * reach * (1.0 + 1e-12);
        // NaN separates nothing.
        !separated
    }
}

fn vector(p: &[f32; 3]) -> DVec3 {
    DVec3::new(p[0].into(), p[1].into(), p[2].into())
}

/// The radius in f32, rounded up, rounding in f64 included.
fn upwards(radius: f64) -> f32 {
    (radius * (1.0 + 1e-12)) as f32 * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::{Aabb, Mesh, Node};
    use pfront_testkit::rng::{RngExt, seeded};

    fn contains(sphere: &Sphere, p: [f32; 3]) -> bool {
        vector(&p).distance(vector(&sphere.centre)) <= f64::from(sphere.radius)
    }

    #[test]
    fn posed_spheres_contain_posed_points() {
        let mut rng = seeded(5);
        let mut next = || rng.random_range(-1.0..1.0f32);
        for round in 0..20_000 {
            let scale = [1e-44, 1e-20, 1.0, 1e7, 1e30][round % 5];
            let points = [[0; 3]; 3].map(|p| p.map(|_| next() * scale));
            let aabb = Aabb::of(&points);
            let root = [Node { min: aabb.min, first: 0, max: aabb.max, count: 1 }];
            let bvh = Bvh::new_unchecked(Mesh::new_unchecked(&points, &[[0, 1, 2]]), &root, &[0]);
            let sphere = Sphere::of(&bvh).unwrap();
            let far = [0.0, 1.0, 1e6][round % 3] * scale;
            let turn = glam::Quat::from_axis_angle(
                glam::Vec3::new(next(), next(), next()).normalize_or(glam::Vec3::X),
                next() * 3.0,
            );
            let offset = glam::Vec3::new(next(), next(), next()) * far;
            let mut pose = Pose::from_rotation_translation(turn.to_array(), offset.to_array());
            if round % 7 == 0 {
                // Shear.
                pose.rows[0][1] += next() * 3.0;
            }
            let posed = sphere.posed(&pose.into());
            for p in points {
                assert!(contains(&sphere, p), "{p:?} {sphere:?}");
                assert!(contains(&posed, pose.apply(p)), "{p:?} {posed:?}");
            }
            if round % 7 != 0 && (1e-20..1e30).contains(&scale) && far <= scale {
                // Coordinates round by their own size, however small the triangle.
                assert!(posed.radius <= sphere.radius + scale * 1e-5, "{posed:?}");
            }
        }
    }

    #[test]
    fn what_overflows_overlaps() {
        let all = Sphere { centre: [3e38; 3], radius: 1e37 };
        let all = all.posed(&Pose64::from_translation([1e38, 0.0, 0.0]));
        let far = Sphere { centre: [3e38; 3], radius: 1.0 };
        assert!(
            all.is_near(&far, Distance::default())
                && far.is_near(&all, Distance::default())
                && all.is_near(&all, Distance::default())
        );
        assert!(!far.is_near(&Sphere { centre: [-3e38; 3], radius: 1.0 }, Distance::default()));
    }

    #[test]
    fn moved_spheres_overlap_where_they_meet() {
        let unit = Sphere { centre: [0.0; 3], radius: 1.0 };
        let moved = |x| unit.posed(&Pose64::from_translation([x, 0.0, 0.0]));
        assert!(
            !unit.is_near(&moved(2.5), Distance::default())
                && moved(2.5).is_near(&moved(1.0), Distance::default())
        );
    }

    #[test]
    fn balls_that_touch_overlap() {
        let at = |x| Sphere { centre: [x, 0.0, 0.0], radius: 1.0 };
        assert!(
            at(0.0).is_near(&at(2.0), Distance::default())
                && !at(0.0).is_near(&at(2.0 + 1e-6), Distance::default())
        );
    }
}
