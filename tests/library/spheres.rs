//! A unit sphere through a unit sphere, at distance d along some axis u.
//!
//! They share the circle about d/2·u of radius ρ = √(1 − d²/4), at right angles to u.
//!
//! A triangle whose corners lie on the sphere has all its points at distances from 1 − h to 1 of the centre, h
//! being the sagitta. A point p on both meshes so has r = |p| and s = |p − d·u| in that range, and
//! x = p·u = (r² − s² + d²) / 2d is within (1 − (1 − h)²) / 2d ≤ h/d of d/2; and p is at the distance
//! √(r² − x²) from the axis, whose square is within 2h + h/d·(d + h/d) of ρ².

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pfront::{Model, PairQuery, Pose};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::icosphere;
use std::f64::consts::{PI, TAU};

const DISTANCE: f64 = 1.1;
/// Steps of an edge of the icosahedron.
const REFINEMENTS: [u32; 3] = [16, 32, 64];

/// The error that rounding to f32 adds to a length of about 1: of the vertices, the pose and the contact.
const ROUNDING: f64 = 1e-6;

/// The segments in which two icospheres meet, and how far a mesh lies below its sphere.
struct Met {
    segments: Vec<[DVec3; 2]>,
    sagitta: f64,
    /// The length of all edges for each unit of area.
    edges: f64,
}

fn point(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// Where u points: along no edge and no symmetry of the icosahedron.
fn axis() -> DVec3 {
    DVec3::new(0.48, 0.6, 0.64)
}

fn meet(refinement: u32) -> Met {
    let mesh = icosphere(20 * (refinement * refinement) as usize);
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.3, -0.5, 0.9)));
    let place = DAffine3::from_mat3_translation(turn, axis() * DISTANCE);
    let column = |c: DVec3| c.to_array().map(|x| x as f32);
    let columns = [place.x_axis, place.y_axis, place.z_axis, place.translation].map(column);
    let pose = Pose::new([0, 1, 2].map(|row| columns.map(|c| c[row])));
    let model = Model::new(mesh.positions.clone(), mesh.triangles.clone()).unwrap();
    let mut query = PairQuery::new();
    let contacts = query.contacts(&model, &model, pose).unwrap();
    let segments = contacts.iter().map(|(_, contact)| contact.segment.map(point)).collect();
    let (sagitta, edges) = measure(&mesh);
    Met { segments, sagitta, edges }
}

/// The sagitta of the flattest triangle, and the length of edges for each unit of the sphere's area.
fn measure(mesh: &MeshData) -> (f64, f64) {
    let corners = mesh.triangles.iter().map(|t| t.map(|v| point(mesh.positions[v as usize])));
    let (mut lowest, mut edges) = (1.0_f64, 0.0);
    for [a, b, c] in corners {
        lowest = lowest.min((b - a).cross(c - a).normalize().dot(a));
        // Each belongs to two triangles.
        edges += (a.distance(b) + b.distance(c) + c.distance(a)) / 2.0;
    }
    (1.0 - lowest, edges / (4.0 * PI))
}

fn radius() -> f64 {
    (1.0 - DISTANCE * DISTANCE / 4.0).sqrt()
}

#[test]
fn contacts_lie_on_the_circle() {
    for refinement in REFINEMENTS {
        let Met { segments, sagitta: h, .. } = meet(refinement);
        let along = h / DISTANCE;
        let across = (2.0 * h + along * (DISTANCE + along)) / radius();
        let bound = along.hypot(across) + ROUNDING;
        assert!(bound < 0.05, "{bound} bounds nothing");
        let mut farthest = 0.0_f64;
        for p in segments.as_flattened() {
            let x = p.dot(axis());
            let from_axis = p.distance(axis() * x);
            let off = (x - DISTANCE / 2.0).hypot(from_axis - radius());
            farthest = farthest.max(off);
        }
        assert!(farthest <= bound, "{farthest} is beyond {bound} at {refinement}");
        // Nor is the bound far off.
        assert!(farthest >= bound / 20.0, "{farthest} of {bound} at {refinement}");
    }
}

/// Every end of a segment is the end of one other, and all hang together: one closed curve.
#[test]
fn contacts_close() {
    for refinement in REFINEMENTS {
        let segments = meet(refinement).segments;
        let ends = segments.as_flattened();
        let partner = |end: usize| {
            let near = |&other: &usize| other != end && ends[other].distance(ends[end]) < ROUNDING;
            let found: Vec<_> = (0..ends.len()).filter(near).collect();
            assert_eq!(found.len(), 1, "end {end} at {} has {found:?}", ends[end]);
            found[0]
        };
        let (mut at, mut steps) = (0, 0);
        loop {
            // To the other end of the segment, and on to the next.
            at = partner(at ^ 1);
            steps += 1;
            if at == 0 {
                break;
            }
        }
        assert_eq!(steps, segments.len(), "more than one curve at {refinement}");
    }
}

/// The length of the curve is 2πρ but for a share of the sagitta, which falls to a quarter when edges are
/// halved. And the curve crosses edges as a line crosses needles: lines of length Λ for each unit of area,
/// in all directions alike, are crossed 2/π·Λ times for each unit of its length (Cauchy and Crofton). It is
/// cut into a segment wherever it crosses an edge of either mesh.
#[test]
fn length_and_count_converge() {
    let circle = TAU * radius();
    let mut last: Option<(f64, usize)> = None;
    for refinement in REFINEMENTS {
        let Met { segments, sagitta, edges } = meet(refinement);
        let length: f64 = segments.iter().map(|[p, q]| p.distance(*q)).sum();
        let short = circle - length;
        assert!(0.0 < short && short < 4.0 * sagitta * circle, "{short} at {refinement}");
        let expected = 2.0 * 2.0 / PI * edges * length;
        let off = segments.len() as f64 / expected - 1.0;
        assert!(off.abs() < 0.03, "{} segments, {expected} expected", segments.len());
        println!("{refinement}: {} segments ({off:+.4}), {short:.6} short", segments.len());
        if let Some((was_short, count)) = last {
            let (falls, grows) = (was_short / short, segments.len() as f64 / count as f64);
            assert!((falls - 4.0).abs() < 0.4, "falls by {falls} at {refinement}");
            assert!((grows - 2.0).abs() < 0.1, "grows by {grows} at {refinement}");
        }
        last = Some((short, segments.len()));
    }
}
