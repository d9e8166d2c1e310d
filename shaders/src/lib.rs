//! The WGSL of pfront-gpu: passes, each a file with one entry point of the same name, and the parts that
//! they share.
//!
//! There is no preprocessor. A [`Pass`] names its parts, and [`Pass::source`] is a header of constants,
//! those of [`constants`], followed by the parts and the pass; in WGSL the order of declarations
//! is free. Whoever sets up buffers or dispatches reads the same constants, and a test of
//! pfront-gpu compares structs with Rust's by reflection.
//!
//! ```
//! let source = pfront_shaders::EXPAND.source();
//! assert!(source.starts_with("const GROUP = "));
//! assert!(source.contains("fn expand("));
//! ```

pub mod constants;

/// One compute pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// The name of its entry point and its file.
    pub entry: &'static str,
    /// The texts that make it up, after the constants.
    pub parts: &'static [&'static str],
}

impl Pass {
    /// The whole module in WGSL.
    #[must_use]
    pub fn source(&self) -> String {
        let mut source = constants::header();
        for part in self.parts {
            source.push('\n');
            source.push_str(part);
        }
        source
    }
}

macro_rules! texts {
    ($($name:ident = $file:literal;)*) => {
        $(const $name: &str = include_str!(concat!("../wgsl/", $file, ".wgsl"));)*
    };
}

texts! {
    BINDINGS = "parts/bindings";
    BOXES = "parts/boxes";
    DESCEND = "parts/descend";
    EXACT = "parts/exact";
    FILTER = "parts/filter";
    GROUP = "parts/group";
    LATTICE = "parts/lattice";
    LAYOUT = "parts/layout";
    ORDERED = "parts/ordered";
    PLACE = "parts/place";
    RESULTS = "parts/results";
    SHARING = "parts/sharing";
    SIGNS = "parts/signs";
    SOFT = "parts/soft";
    TRIANGLES = "parts/triangles";
    WIDE = "parts/wide";
}

macro_rules! pass {
    ($entry:literal, $($part:ident),*) => {
        Pass {
            entry: $entry,
            parts: &[$($part,)* include_str!(concat!("../wgsl/passes/", $entry, ".wgsl"))],
        }
    };
}

/// The first pass of a query: node pairs of one level of both BVHs, and down from there.
pub const SEED: Pass = pass!("seed", LAYOUT, BINDINGS, GROUP, BOXES, DESCEND);

/// One depth-bounded pass from a front.
pub const EXPAND: Pass = pass!("expand", LAYOUT, BINDINGS, GROUP, BOXES, DESCEND);

/// The triangle pairs of leaf pairs, in f32.
pub const NARROW: Pass = pass!(
    "narrow", LAYOUT, BINDINGS, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES, SHARING, SIGNS, FILTER,
    RESULTS
);

/// What f32 left open, in integers.
pub const DECIDE: Pass = pass!(
    "decide", LAYOUT, BINDINGS, GROUP, PLACE, SOFT, WIDE, TRIANGLES, SHARING, SIGNS, LATTICE,
    EXACT, RESULTS
);

/// Boxes and corners of a mesh that has moved.
pub const REFIT: Pass = pass!("refit", LAYOUT, ORDERED);

/// Whether the adapter rounds as posing needs.
pub const PROBE: Pass = pass!("probe", PLACE, SOFT, WIDE);

/// Every pass.
pub const PASSES: [Pass; 6] = [SEED, EXPAND, NARROW, DECIDE, REFIT, PROBE];
