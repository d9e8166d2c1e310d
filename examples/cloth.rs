//! Cloth: a sheet that deforms each frame, against a ball and against itself.
//!
//! `cargo run --release --example cloth`
//!
//! A solver would move the vertices by the constraints that are made here of the contacts; in its place a formula moves them: waves
//! that grow until they roll over and the sheet passes through itself. `docs/response.md` has the other ways to answer a contact.

use pfront::{Adjacency, Contact, Error, Model, PairQuery, Pose, SelfQuery, TrianglePair};
use std::collections::BTreeMap;
use std::f32::consts::{PI, TAU};

/// Quads along each side of the sheet.
const SIDE: usize = 60;
/// The most rounds of constraints in a frame.
const ROUNDS: usize = 40;
/// The distance that the sheet keeps from the ball, since touching counts.
const GAP: f32 = 1e-3;

fn main() -> Result<(), Error> {
    let mut sheet = surface(SIDE, |u, v| waves(0.0, u, v))?;
    let ball = surface(24, |u, v| {
        let (longitude, latitude) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
        [latitude.0 * longitude.0, latitude.1 - 2.0, latitude.0 * longitude.1]
    })?;
    // A query keeps its memory and what it has learnt from frame to frame: make it once.
    let mut ball_query = PairQuery::new();
    // Triangles that share a vertex always touch there. By default only what they share beyond it counts; without
    // neighbours it does not count either, as most solvers want it.
    let mut self_query = SelfQuery::new().with_adjacency(Adjacency::SkipNeighbours);

    let (mut folds, mut laid_down) = (0, 0);
    for frame in 0..8 {
        let time = frame as f32 / 7.0;
        // The triangles stay, the vertices move; the BVH is refitted, which takes O(n).
        let moved: Vec<_> = uv(SIDE).map(|(u, v)| waves(time, u, v)).collect();
        sheet.set_positions(&moved)?;

        // The verb says how much is to be known: `any`, `count`, `all` or `contacts`.
        let itself = self_query.count(&sheet)?;
        // Contacts have the segment in which two triangles cross, and their normals, in the frame of the first model. A solver weighs
        // the constraints against the stiffness of the cloth; alone they lay it on the ball, a ring of vertices a round.
        let mut laid = moved;
        let mut rounds = 0;
        let before = ball_query.count(&ball, &sheet, Pose::IDENTITY)?;
        let after = loop {
            let contacts = ball_query.contacts(&ball, &sheet, Pose::IDENTITY)?;
            if contacts.is_empty() || rounds == ROUNDS {
                break contacts.len();
            }
            for (vertex, Constraint { normal, depth }) in constraints(contacts, &sheet) {
                let point = &mut laid[vertex as usize];
                *point = [0, 1, 2].map(|axis| point[axis] + (depth + GAP) * normal[axis]);
            }
            sheet.set_positions(&laid)?;
            rounds += 1;
        };
        println!(
            "frame {frame}: {itself} in folds; {before} on the ball, {after} after {rounds} rounds"
        );
        folds += itself;
        laid_down += usize::from(before > 0 && after == 0);
    }
    assert!(folds > 0 && laid_down > 0);
    Ok(())
}

/// The distance by which a vertex has to move along a normal, for a solver.
struct Constraint {
    normal: [f32; 3],
    depth: f32,
}

/// The constraint of each vertex whose triangle meets the ball: the deepest that it is behind the plane of a triangle of the ball.
fn constraints(contacts: &[(TrianglePair, Contact)], sheet: &Model) -> BTreeMap<u32, Constraint> {
    let mut found = BTreeMap::<u32, Constraint>::new();
    // Flat contacts tell where they touch, and not which way to go.
    for (pair, contact) in contacts.iter().filter(|(_, contact)| !contact.is_flat) {
        let [normal, _] = contact.normals;
        for vertex in sheet.mesh().triangles()[pair.b as usize] {
            let point = sheet.mesh().shadow()[vertex as usize];
            let behind =
                [0, 1, 2].map(|axis| (contact.segment[0][axis] - point[axis]) * normal[axis]);
            let depth = behind.iter().sum();
            if found.get(&vertex).map_or(0.0, |known| known.depth) < depth {
                found.insert(vertex, Constraint { normal, depth });
            }
        }
    }
    found
}

/// The sheet at a time in 0 ..= 1: it sinks, and its three waves turn into loops.
fn waves(time: f32, u: f32, v: f32) -> [f32; 3] {
    let phase = 3.0 * TAU * (u - 0.5);
    let (sin, cos) = phase.sin_cos();
    let (width, height) = (0.3 - 0.2 * time, 0.2 * time);
    [width * phase - height * sin, -2.0 * time - height * cos, 4.0 * (v - 0.5)]
}

/// The parameters of the vertices of a surface, row by row.
fn uv(side: usize) -> impl Iterator<Item = (f32, f32)> {
    let at = move |i: usize| i as f32 / side as f32;
    (0..=side).flat_map(move |i| (0..=side).map(move |j| (at(i), at(j))))
}

/// A surface over the unit square, of two triangles a quad.
fn surface(side: usize, point: impl Fn(f32, f32) -> [f32; 3]) -> Result<Model, Error> {
    let row = side as u32 + 1;
    let corners = (0..row - 1).flat_map(|i| (0..row - 1).map(move |j| i * row + j));
    let triangles = corners.flat_map(|k| [[k, k + 1, k + row], [k + 1, k + row + 1, k + row]]);
    Model::new(uv(side).map(|(u, v)| point(u, v)).collect(), triangles.collect())
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
