//! Continuous queries: which triangles meet while both move, and when first.
//!
//! # The question
//! Each corner goes in a straight line, (1 − t) p + t q, from its position p at the start, t = 0, to its position q at the end, t = 1: in real
//! numbers, from positions that are posed and rounded as they are for any query. Triangles meet at the first time at which they have a point
//! in common.
//!
//! - Two that are not reported meet at no time from 0 to 1.
//! - Each that are have an [`Impact`]: they do not meet before `from`, and certainly meet before `to`, if that is finite. Else they come near
//!   at `from`, and whether they meet is open: that is so where they touch and do not pass, where all corners move in one plane for ever,
//!   where coordinates in f64 have more than 356 bits, and where they pass each other at a gap for which the shortest intervals, 2^-96 for coordinates of up
//!   to 284 bits, are too long; no such pair is known. An undecided pair is reported, never dropped.
//! - At the times 0 and 1 they meet exactly if they intersect then.
//!
//! # How a pair is decided
//! Not by roots of cubics, as by Provot (*Collision and self-collision handling in cloth model dedicated to design garments*, 1997), and not by
//! boxes in time and on both features, as by Wang et al. (*A Large-Scale Benchmark and an Inclusion-Based Algorithm for Continuous Collision
//! Detection*, 2021), but by certificates about whole triangles, each with an error bound, whatever suggested it:
//!
//! 1. near points of both are found at a time. A direction that separates the triangles then, such as that from one point to the other, is a
//!    certificate that they stay apart for a while; and so is the normal of the features with the points, which moves with these (`apart`).
//!    The next step begins where the best of them ends: conservative advancement (Mirtich, 1996) with certificates in place of bounds on
//!    speeds. Nearly all pairs end here, after one or two steps;
//! 2. where they are near, a corner that passes a face, or an edge that passes an edge, is a certificate that they meet (`meets`);
//! 3. what is left is asked again in integers, interval of time by interval (`exact::motion`), until a certificate in f64 leads on.
//!
//! A wrong guess, NaN or a bad division costs a step, never an answer.
//!
//! Few pairs of meshes in f32 come so far. Lanes reject those, eight at a time, that a plane or a direction certainly holds apart all the time,
//! and tell which cross at the start (`bvtt::moving`); and they take the steps of others up to the end, if these get there (`bvtt::moving_lanes`).
//! The rest is decided as above, so that lanes change no answer.
//!
//! # Which pairs are asked about
//! Two meshes that move have a BVTT like any two ([`MovingBvtt`]). A node has its box at the start and at the end, and two nodes are compared
//! at a common time (`common_time`): so whatever moves side by side has no more node pairs than if it were at rest. No tree is built for a
//! motion: it is the same nodes under two poses, or refitted to the positions at the end.
//!
//! # One mesh
//! Triangles that share vertices by index are decided by a rule of their own: see [`impact_in_mesh`].
//!
//! # Within a distance
//! `within` of a [`MovingBvtt`] asks for pairs that come within a distance d in place of those that meet, with the same certificates: a direction
//! n holds triangles apart whose heights along it differ by more than d |n|, and one that moves with features if they differ by more than d times the
//! longest that it gets. Two points at most d apart, at one time, prove that they are within it, nearest or not. Integers decide at the times 0 and
//! 1 only, so that pairs are open which come as near as d, but for rounding, and no nearer. Boxes reach d farther.
//!
//! # Rigid bodies
//! They too are decided by their corners, in straight lines between both poses. A screw motion is off from it: a corner at the distance r
//! from its axis, that turns by an angle θ, by r θ²/8 at most, for its acceleration is r θ², and linear interpolation is off by an eighth of
//! that. So two bodies in screw motions, whose axes may move in straight lines, do not meet before they are within
//!
//! d = (r_A θ_A² + r_B θ_B²) / 8
//!
//! of each other in straight lines, with r the largest distance of a corner of each from its axis, and θ in radians: within d none of their contacts is
//! missed, and none is earlier than `from`. With r = 0.5, a body adds 7.6e-5 for 2°, and 1.9e-3 for 10°; half the step takes a quarter.

mod adjacency;
mod apart;
mod bvh;
mod bvtt;
mod common_time;
mod impact;
mod leaf;
mod meets;
mod pair;
mod query;
#[cfg(test)]
mod tests;
mod traversal;

pub use adjacency::impact_in_mesh;
pub use bvh::{MotionError, MovingBvh};
pub use bvtt::MovingBvtt;
pub use impact::{Impact, impact};
pub use pair::MovingTriangle;
