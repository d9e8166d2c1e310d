//! Every intersecting triangle pair of two meshes, or within one: exactly, sorted, and the same
//! from every backend.
//!
//! `pfront` implements Zhang & Kim, *Scalable Collision Detection Using p-Partition Fronts on
//! Many-Core Processors* (IEEE TVCG 2014), on triangle predicates that are exact for all finite f32
//! input. A [`Model`] owns a mesh and its BVH; a [`PairQuery`] or [`SelfQuery`] owns the buffers
//! that a question needs and keeps them from frame to frame; a [`SceneQuery`] owns many posed models
//! as well.
//!
//! ```
//! use pfront::{Model, PairQuery, Pose};
//! # fn main() -> Result<(), pfront::Error> {
//! let tetrahedron = || Model::new(
//!     vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
//! );
//! let (a, b) = (tetrahedron()?, tetrahedron()?);
//! let mut query = PairQuery::new();
//! for frame in 0..4 {
//!     let a_from_b = Pose::from_translation([0.0, 0.0, 0.3 * frame as f32]);
//!     let pairs = query.all(&a, &b, &a_from_b)?;
//!     println!("frame {frame}: {} pairs", pairs.len());
//! }
//! # Ok(()) }
//! ```
//!
//! All that can be asked, on one page, and who answers: [`questions`]. The ways to answer a hit: [`response`].
//!
//! # What the answer is
//! - Triangles are closed sets: touching counts, and a triangle without area is a segment or a point.
//! - The pairs reported are the true set for the posed f32 positions. The posed position of a vertex is fixed to the bit by [`Pose::apply`]; a pair query poses the second
//!   mesh into the frame of the first, a scene poses every body into the world.
//! - Positions in f64 ([`Model::from_f64`]) and poses in f64 ([`Pose64`]) are decided in f64, exactly: see
//!   [`Mesh::from_f64`].
//! - Within one mesh, what two triangles share by index is no contact: see
//!   [`pfront_core::triangle::intersects_in_mesh`].
//!
//! # Limits
//! - Surfaces, not solids: a body that lies wholly inside another has no hit, from any query but those about a [`Solid`].
//! - One instant, unless it is asked about a [`Motion`]: what is on one side of a wall in one frame and on the other in the next has no hit in
//!   either (tunnelling). Corners of a motion go in straight lines, from one frame to the next.
//!
//! # Features
//! - `threads` (default): the queries on several CPU threads.
//! - `gpu`: the module `gpu`, the queries on any GPU, with the same answers.
//! - `glam033`, `glam034`: poses from and into the types of bevy and rapier; see [`pfront_core::pose`].
//! - `serde`: `Serialize` and `Deserialize` for what is stored: [`Pose`], [`Aabb`], [`TrianglePair`], [`Contact`],
//!   [`SceneHit`], [`BodyId`], [`BodyOptions`], [`Groups`], [`Adjacency`] and [`BuildOptions`].
//!
//! The heart of it, [`pfront_core`], needs neither an allocator nor std. How to put any of it into an engine or into
//! firmware, how large every buffer has to be, and the worst case of every call: [`embedding`].

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod batch;
#[doc = include_str!("../docs/embedding.md")]
pub mod embedding {}
#[doc = include_str!("../docs/questions.md")]
pub mod questions {}
#[doc = include_str!("../docs/response.md")]
pub mod response {}
mod environment;
mod error;
pub mod executor;
#[cfg(feature = "gpu")]
pub mod gpu;
mod impacts;
mod itself;
mod memory;
mod model;
mod motion;
mod once;
mod pair;
mod patches;
mod pose;
mod relation;
mod scene;
mod solid;
mod sphere;
mod subject;
mod subject_query;
mod ticket;

pub use batch::{Batch, PairLists};
pub use error::Error;
pub use executor::Executor;
pub use itself::SelfQuery;
pub use model::{Model, Scalar, Stamp};
pub use motion::Motion;
pub use once::{any, count, distance, pairs, self_pairs};
pub use pair::PairQuery;
pub use patches::{ContactPatch, ContactSize};
pub use pose::AnyPose;
pub use scene::{
    Allowed, Body, BodyId, BodyLocation, BodyOptions, CheckReport, CheckedPair, Groups, Piece,
    SceneHit, SceneQuery,
};
pub use solid::Solid;
pub use sphere::Sphere;
pub use ticket::Ticket;

pub use pfront_blob::{self, Blob, BlobError};
pub use pfront_core;
pub use pfront_core::bvh::BuildOptions;
pub use pfront_core::bvtt::{Gap, TrianglePair};
pub use pfront_core::motion::{Impact, MotionError};
pub use pfront_core::pose::PoseError;
pub use pfront_core::relation::{Between, Location, NotSolid, Relation, Rule};
pub use pfront_core::segment::SegmentHit;
pub use pfront_core::triangle::{Adjacency, Contact};
pub use pfront_core::{Aabb, Bvh, Distance, DistanceError, Mesh, MeshError, Node, Pose, Pose64};
/// The backend on several CPU threads, and what can be chosen about it.
#[cfg(feature = "threads")]
pub use pfront_cpu as threads;

/// The examples of the README are compiled and run where there are all features.
#[cfg(all(doctest, feature = "gpu"))]
#[doc = include_str!("../README.md")]
mod readme {}
