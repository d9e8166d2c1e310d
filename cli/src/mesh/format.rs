//! The formats that are read.

/// The extensions that [`read`](super::read) knows.
pub const FORMATS: [&str; 7] = ["obj", "ply", "stl", "off", "gltf", "glb", BAKED];

/// The extension of what `pfront bake` writes.
pub(super) const BAKED: &str = "pfb";
