//! The scenes that have a name.

use thiserror::Error;

use super::scene::{FRAMES, Scene};
use super::{knot, passing, sheet, worm};

/// Far more than any benchmark needs, and far below what 32-bit indices can number.
const MOST_TRIANGLES: usize = 100_000_000;

/// Why there is no such scene.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SceneError {
    /// No scene has this name.
    #[error("no scene is called '{name}'; there are {}", Scene::NAMES.join(", "))]
    UnknownName {
        /// The name asked for.
        name: String,
    },
    /// The scene would have too many triangles.
    #[error("{size} triangles are too many for a scene; ask for at most {MOST_TRIANGLES}")]
    TooLarge {
        /// The number of triangles asked for.
        size: usize,
    },
}

impl Scene {
    /// The names that [`Scene::by_name`] knows.
    pub const NAMES: [&'static str; 7] =
        ["worm-gear", "swarm", "crowd", "sheet", "torus-knots", "spheres", "course"];

    /// The scene called `name` in about `size` triangles, all objects together.
    ///
    /// Without a size: as many as in the paper (worm-gear 64K, swarm 149K, sheet 92K, course
    /// 2 × 58K), 500 × 1,600 for a crowd, 2 × 50K for the others. A size below what the shape needs gives the coarsest one,
    /// which has 7,552 triangles for worm-gear, 3,252 for swarm, 1,568 for a crowd, 768 or fewer for the others.
    ///
    /// # Errors
    /// [`SceneError`] for a name not in [`Scene::NAMES`] or a size above 100 million.
    pub fn by_name(name: &str, size: Option<usize>) -> Result<Self, SceneError> {
        if let Some(size) = size.filter(|&size| size > MOST_TRIANGLES) {
            return Err(SceneError::TooLarge { size });
        }
        Ok(match name {
            "worm-gear" => worm::scene(size.unwrap_or(worm::TRIANGLES)),
            "swarm" => passing::swarm(size.unwrap_or(149_000)),
            "crowd" => passing::crowd(size.unwrap_or(800_000)),
            "sheet" => sheet::scene(size.unwrap_or(sheet::TRIANGLES)),
            "torus-knots" => passing::torus_knots(size.unwrap_or(100_000)),
            "spheres" => passing::spheres(size.unwrap_or(100_000)),
            "course" => {
                let body = knot::torus_knot(size.unwrap_or(116_000) / 2);
                Self::course(body.clone(), body, FRAMES, 0)
            }
            _ => return Err(SceneError::UnknownName { name: name.to_owned() }),
        })
    }
}
