//! The queries of [`pfront_core`] on p CPU threads: the same answer, to the bit, for every number of
//! workers and every schedule.
//!
//! A [`Pool`] is p workers and their threads, which any number of traversals share. A [`Traversal`] keeps what a frame leaves
//! for the next: the measured cost of each node of its p-partition front, and every buffer. In each frame that is worth
//! several threads it generates a front, partitions it over p workers, lets each traverse from its nodes, and gathers what they found (Zhang & Kim 2014, sections 3
//! and 3.4). Under
//! [`Schedule::Static`] that is all, as in the paper; by default a worker that is done takes nodes that others
//! have not begun, and then halves of what they have begun ([`Schedule::Hybrid`]). A small frame ends on the calling
//! thread. Costs are counted in box and triangle tests, not timed, so that those in the [`Report`] of a frame mean the
//! same on every machine and for any p.
//!
//! ```
//! use pfront_core::{bvh::*, bvh::node_bound, bvtt::PairBvtt, *};
//! use pfront_cpu::{Pool, Traversal};
//! # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! # let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
//! # let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
//! # let mesh = Mesh::new(&points, &[[0, 1, 2]])?;
//! # let mut scratch = [0; 2];
//! # let bvh = morton(mesh, &BuildOptions::default(), storage, &mut scratch)?;
//! let mut traversal = Traversal::new(&Pool::new(8));
//! let mut pairs = Vec::<bvtt::TrianglePair>::new();
//! for frame in 0..3 {
//!     let pose = Pose::from_translation([0.1 * frame as f32, 0.0, 0.0]);
//!     traversal.all(&[PairBvtt::new(bvh, bvh, pose)?], &mut pairs)?;
//!     assert_eq!(pairs.len(), 1);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where the threads come from
//! Work runs in the rayon pool of the calling thread, which outside of any pool is the global one:
//! call from `pool.install(|| …)` to use another, or hand one over for good with
//! `Pool::from(pool)`. The number of workers p is independent of the number of threads.
//!
//! Threads are called before the front of a frame is made and wait for it awake, 1 ms at most, since waking up takes as
//! long as a small frame. Between frames they sleep as the pool lets them.
//!
//! # Floating-point environment
//! A thread of a pool has the floating-point environment of the thread that made the pool. All work of a frame runs in the
//! default one, on every thread, and afterwards each thread has its own again; visitors run in that of their thread.
//! [`Pool::install`] and [`Pool::spawn`] change nothing for the function that they run.

// `traversal` has the verbs, about `queries`; each calls `Traversal::run` in `frame`, which begins alone and then divides: `front` makes and
// partitions the front, and `workers` has each thread traverse its part, into an output of `output`. `merge` makes one list of
// theirs, which `sort` has sorted. `control` ends frames early.
mod build;
mod control;
mod distance;
mod frame;
mod front;
mod memory;
mod merge;
mod output;
mod pool;
mod queries;
mod report;
mod settings;
mod sort;
mod traversal;
mod workers;

pub use build::join;
pub use memory::MemoryError;
pub use output::Hit;
pub use pool::{MAX_WORKERS, Pool};
pub use queries::Queries;
pub use rayon;
pub use report::{Report, Share};
pub use settings::{Schedule, Settings};
pub use traversal::Traversal;
