//! The formats that are read.

/// The extensions that [`open`](crate::open) knows.
pub const FORMATS: [&str; 8] = ["obj", "ply", "stl", "off", "gltf", "glb", "3mf", BAKED];

/// The extension of what `pfront bake` writes.
pub(crate) const BAKED: &str = "pfb";

/// The fault of a glTF of another version than the second.
pub(crate) const FIRST_VERSION: &str = "glTF 1 is not read: convert it to glTF 2";
