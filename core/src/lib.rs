#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
//! Finds every pair of intersecting triangles of two meshes, or of one mesh with itself, exactly and without
//! allocation.
//!
//! This crate has the data structures and algorithms of `pfront` on one thread, in memory that the caller provides.
//! Its central structures are the BVH, the bounding volume test tree (BVTT) of two BVHs, and the p-partition front, a cut
//! through the BVTT that divides a query evenly among p workers (Zhang & Kim, *Scalable Collision Detection Using
//! p-Partition Fronts on Many-Core Processors*, TVCG 2014).
//!
//! # Modules
//! In the order in which data flows through them:
//!
//! - [`Mesh`]: borrowed positions and triangles, checked once; [`pose`]: affine maps, and how a posed vertex is rounded;
//!   [`Aabb`]: boxes;
//! - `exact` (private): exact signs of orientation determinants, with floating-point filters before integers;
//! - [`triangle`]: whether two triangles intersect, the rule for triangles that share vertices, and contacts;
//! - `simd` (private): boxes and triangles in vector lanes;
//! - [`bvh`]: builds, refits and checks of a BVH;
//! - [`bvtt`]: the traversal, its cursor, and the queries [`bvtt::PairBvtt`] and [`bvtt::SelfBvtt`];
//! - [`front`]: fronts, their refinement, their partition, and the cost history from frame to frame;
//! - [`one_ring`]: certificates that save a self query the tests of neighbours;
//! - [`relation`]: what two solids are to each other, and where a point is; [`segment`]: triangles that a segment meets.
//!
//! # Guarantees
//! - **Exact.** A query finds the pairs of closed triangles that intersect, no more and no fewer, for the positions given, in
//!   f32 or, by [`Mesh::from_f64`], in f64. Touching counts.
//! - **No allocation.** Buffers are slices of the caller's. A `const fn` such as [`bvh::node_bound`] gives the length, and
//!   [`CapacityError`] says how many elements a buffer lacks. Stack use is bounded: no query recurses.
//! - **No `std`.** The crate is `no_std` and needs no allocator.
//! - **Additive features.** `f64`, on by default, lets meshes and poses be in f64, and `within` and `relation`, on by default too, let queries
//!   ask for pairs within a distance and for the relation of solids; firmware that needs none of them leaves them out and is smaller. `std` switches on run-time detection of AVX2 and the float functions of the standard library; it changes no
//!   answer and no type. `glam033` and `glam034` convert [poses](pose) from and into what engines keep;
//!   `serde` implements `Serialize` and `Deserialize` for [`Pose`], [`Aabb`], [`bvtt::TrianglePair`],
//!   [`triangle::Contact`], [`triangle::Adjacency`] and [`bvh::BuildOptions`].
//!
//! # Floating-point environment
//! Exact answers need IEEE 754's default environment on every thread that calls: rounding to nearest, and
//! subnormal numbers kept (no FTZ or DAZ, so no `-ffast-math` start-up code of the host). Rust assumes
//! that environment everywhere. [`Mesh::new`], [`Mesh::with_positions`] and their likes in f64 check it and return
//! [`MeshError::FloatEnvironment`] in another one; queries do not check it again. The C API sets and restores it by
//! itself.
//!
//! # Examples
//! ## A pair query
//! Two meshes, the second in a pose relative to the first:
//! ```
//! use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
//! use pfront_core::bvtt::{PairBvtt, Query, TrianglePair};
//! use pfront_core::{Mesh, Node, Pose};
//!
//! let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! let square = Mesh::new(&positions, &[[0, 1, 2], [1, 3, 2]])?;
//! let (mut nodes, mut order) = ([Node::EMPTY; node_bound(2)], [0; 2]);
//! let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
//! let mut scratch = [0; 4];
//! let bvh = morton(square, &BuildOptions::default(), storage, &mut scratch)?;
//!
//! // The square stands upright on the corner at (1, 1).
//! let upright = Pose::new([[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);
//! let query = PairBvtt::new(bvh, bvh, upright)?;
//! assert_eq!(query.any(), Some(TrianglePair { a: 1, b: 0 }));
//! assert_eq!(query.count(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## A self query
//! One mesh with itself. Neighbours do not hit each other in the vertices that they share by index:
//! ```
//! # use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
//! use pfront_core::bvtt::{Query, SelfBvtt, TrianglePair};
//! # use pfront_core::{Mesh, Node};
//! // Triangles 0 and 1 share an edge; triangle 2 pierces triangle 0.
//! let positions = [
//!     [0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4.0, 4.0, 0.0],
//!     [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0],
//! ];
//! let mesh = Mesh::new(&positions, &[[0, 1, 2], [1, 3, 2], [4, 5, 6]])?;
//! # let (mut nodes, mut order) = ([Node::EMPTY; node_bound(3)], [0; 3]);
//! # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
//! let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 6])?;
//! let query = SelfBvtt::new(bvh);
//! assert_eq!(query.count(), 1);
//! let pair = TrianglePair { a: 0, b: 2 };
//! assert_eq!(query.any(), Some(pair));
//! assert!(query.contact(pair).is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## Page by page
//! [`Query::page`](bvtt::Query::page) fills a slice of any length and goes on from there with the next call:
//! ```
//! # use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
//! use pfront_core::bvtt::{PairBvtt, Query, TrianglePair};
//! # use pfront_core::{Mesh, Node, Pose};
//! # let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! # let square = Mesh::new(&positions, &[[0, 1, 2], [1, 3, 2]])?;
//! # let (mut nodes, mut order) = ([Node::EMPTY; node_bound(2)], [0; 2]);
//! # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
//! # let mut scratch = [0; 4];
//! # let bvh = morton(square, &BuildOptions::default(), storage, &mut scratch)?;
//! let query = PairBvtt::new(bvh, bvh, Pose::IDENTITY)?;
//! let (mut cursor, mut page) = (query.start(), [TrianglePair::default(); 3]);
//! let mut total = 0;
//! while !cursor.is_done() {
//!     let len = query.page(&mut cursor, &mut page);
//!     total += page[..len].len();
//! }
//! assert_eq!(total, 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## A front by hand
//! Each frame refines a front, partitions it over two workers, and traverses from its nodes. With their measured costs
//! these are the cost history of the next frame. Here the workers run one after the other; `pfront-cpu` runs them on threads:
//! ```
//! # use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
//! use pfront_core::bvtt::{Cursor, PairBvtt, Query, Work};
//! use pfront_core::front::{Front, FrontNode, Part, RefineOptions};
//! # use pfront_core::{Mesh, Node, Pose};
//! use std::ops::ControlFlow;
//! # let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
//! # let square = Mesh::new(&positions, &[[0, 1, 2], [1, 3, 2]])?;
//! # let (mut nodes, mut order) = ([Node::EMPTY; node_bound(2)], [0; 2]);
//! # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
//! # let mut scratch = [0; 4];
//! # let options = BuildOptions { leaf_size: 1, ..BuildOptions::default() };
//! # let bvh = morton(square, &options, storage, &mut scratch)?;
//! const WORKERS: usize = 2;
//! let (mut memory, mut history) = ([FrontNode::default(); 64], Vec::new());
//! for frame in 0..3 {
//!     let query = PairBvtt::new(bvh, bvh, Pose::from_translation([0.1 * frame as f32, 0.0, 0.0]))?;
//!     let mut front = Front::new(&mut memory);
//!     if let Some(root) = query.root() {
//!         front.add(0, root)?;
//!     }
//!     let report = front.refine(&RefineOptions::new(WORKERS), &mut history, |_| &query);
//!     assert!(!report.full);
//!     let nodes = front.partition(&mut [Part::default(); WORKERS]);
//!
//!     // Worker number `w` takes the nodes whose `part` is `w`.
//!     let mut pairs = 0;
//!     for worker in 0..WORKERS as u32 {
//!         for node in nodes.iter_mut().filter(|node| node.part == worker) {
//!             let mut cursor = Cursor::at(node.pair);
//!             let _ = query.visit(&mut cursor, |_| {
//!                 pairs += 1;
//!                 ControlFlow::Continue(())
//!             });
//!             node.cost = 1.0 + cursor.work.cost() as f32;
//!         }
//!     }
//!     assert_eq!(pairs, query.count());
//!     history = nodes.to_vec();
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "std")]
extern crate std;

mod aabb;
pub mod bvh;
pub mod bvtt;
mod distance;
pub mod environment;
mod error;
mod exact;
pub mod front;
mod mesh;
#[cfg(feature = "motion")]
pub mod motion;
pub mod one_ring;
mod parallel;
pub mod pose;
#[cfg(feature = "relation")]
pub mod relation;
mod scalar;
#[cfg(feature = "relation")]
pub mod segment;
mod simd;
mod sort;
pub mod triangle;
mod vertex_set;

pub use aabb::Aabb;
pub use bvh::arrays::Bvh;
pub use bvh::error::BvhError;
pub use bvh::node::Node;
pub use distance::{Distance, DistanceError};
pub use error::CapacityError;
pub use mesh::{MAX_TRIANGLES, Mesh, MeshError, Triangle};
pub use pose::{Pose, Pose64};
pub use scalar::Scalar;
