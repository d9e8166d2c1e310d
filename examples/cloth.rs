//! Cloth: a sheet that deforms each frame, against a ball and against itself.
//!
//! `cargo run --release --example cloth`
//!
//! A solver would move the vertices and take the contacts as constraints; here a formula moves them: waves that grow
//! until they roll over and the sheet passes through itself.

use pfront::{Adjacency, Error, Model, PairQuery, Pose, SelfQuery};
use std::f32::consts::{PI, TAU};

/// Quads along each side of the sheet.
const SIDE: usize = 60;

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

    let mut folds = 0;
    for frame in 0..8 {
        let time = frame as f32 / 7.0;
        // The triangles stay, the vertices move; the BVH is refitted, which takes O(n).
        let moved: Vec<_> = uv(SIDE).map(|(u, v)| waves(time, u, v)).collect();
        sheet.set_positions(&moved)?;

        // The verb says how much is to be known: `any`, `count`, `all` or `contacts`.
        let itself = self_query.count(&sheet)?;
        // Contacts have the segment in which two triangles cross, and their normals, in the frame of the first model.
        let contacts = ball_query.contacts(&ball, &sheet, Pose::IDENTITY)?;
        let highest = contacts.iter().flat_map(|(_, contact)| contact.segment.map(|[_, y, _]| y));
        let (on_the_ball, highest) = (contacts.len(), highest.reduce(f32::max));
        println!("frame {frame}: {itself} in folds; {on_the_ball} on the ball, up to {highest:?}");
        folds += itself;
    }
    assert!(folds > 0 && ball_query.any(&ball, &sheet, Pose::IDENTITY)?.is_some());
    Ok(())
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
