//! The formats that are read.

/// The extensions that [`open`](crate::open) knows.
pub const FORMATS: [&str; 8] = ["obj", "ply", "stl", "off", "gltf", "glb", "3mf", BAKED];

/// The extension of what `pfront bake` writes.
pub(crate) const BAKED: &str = "pfb";
