//! Benchmark scenes, generated: no data files, no simulation.
//!
//! The scenes stand for those of Zhang & Kim (TVCG 2014, section 5): a worm drive (Fig. 6a), 17
//! bodies (Fig. 6b), a cloth (Fig. 8), random courses (Fig. 9); and there is a crowd of hundreds. They have the
//! paper's triangle counts and its kinds of contact, not its shapes; and where the paper simulates,
//! these move kinematically, by angle and by formula.
//!
//! Solids are closed, manifold and turned outward. The sheet is open: each of its edges has two
//! triangles, or one on its border, and all triangles are turned the same way.
//!
//! Everything is computed in f64 and rounded once to f32, with [`libm`] instead of the platform's
//! sine, so a scene has the same bits on every machine.
//!
//! ```
//! use pfront_testkit::scenes::Scene;
//!
//! let scene = Scene::by_name("worm-gear", Some(8_000))?;
//! let mut poses = Vec::new();
//! for frame in 0..scene.frames() {
//!     scene.poses(frame, &mut poses);
//!     assert_eq!(poses.len(), scene.objects.len());
//! }
//! # Ok::<(), pfront_testkit::scenes::SceneError>(())
//! ```

mod course;
mod gear;
mod knot;
mod mesh;
mod named;
mod passing;
mod pose;
mod scene;
mod sheet;
mod sphere;
mod tooth;
mod worm;

pub use knot::torus_knot;
pub(crate) use mesh::grid_triangles;
pub use named::SceneError;
pub use pose::round;
pub use scene::{Kind, Scene};
pub use sphere::icosphere;
