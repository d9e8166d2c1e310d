//! The WGSL of pfront-gpu: passes, each a file with one entry point of the same name, and the parts that
//! they share.
//!
//! There is no preprocessor. A [`Pass`] names its parts, and [`Pass::source`] is a header of constants,
//! those of [`constants`], followed by the parts and the pass; in WGSL the order of declarations
//! is free. Code that sets up buffers or dispatches reads the same constants, and a test of pfront-gpu
//! compares structs with Rust's by reflection.
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
    BALANCED = "parts/balanced";
    BINDINGS = "parts/bindings";
    BOXES = "parts/boxes";
    COUNTING = "parts/counting";
    CUTS = "parts/cuts";
    DESCEND = "parts/descend";
    DIRECT = "parts/direct";
    EXACT = "parts/exact";
    EXTENT = "parts/extent";
    FILTER = "parts/filter";
    FITTED = "parts/fitted";
    GROUP = "parts/group";
    HALVES = "parts/halves";
    INSTANCES = "parts/instances";
    LATTICE = "parts/lattice";
    LAYOUT = "parts/layout";
    MESHES = "parts/meshes";
    NEAR = "parts/near";
    NOTHING = "parts/nothing";
    ORDERED = "parts/ordered";
    OUTCOME = "parts/outcome";
    PLACE = "parts/place";
    PREFIX = "parts/prefix";
    RANK = "parts/rank";
    RANKING = "parts/ranking";
    RESULTS = "parts/results";
    SHARING = "parts/sharing";
    SIGNS = "parts/signs";
    SOFT = "parts/soft";
    SORTING = "parts/sorting";
    SOURCE = "parts/source";
    STAYING = "parts/staying";
    TALLIES = "parts/tallies";
    TRIANGLES = "parts/triangles";
    UNTALLIED = "parts/untallied";
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
pub const SEED: Pass =
    pass!("seed", LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND);

/// One depth-bounded pass from a front.
pub const EXPAND: Pass =
    pass!("expand", LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND);

/// The triangle pairs of leaf pairs that meet, and those that are left open.
pub const NARROW: Pass = pass!(
    "narrow", LAYOUT, BINDINGS, MESHES, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES,
    SHARING, SIGNS, FILTER, STAYING
);

/// [`NARROW`] where the host decides the few pairs of two meshes that f32 leaves open, so that nothing is left for [`DECIDE`].
pub const NARROW_DIRECT: Pass = pass!(
    "narrow", LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE,
    TRIANGLES, SHARING, SIGNS, FILTER, RESULTS, DIRECT
);

/// Triangle pairs decided: in f32, and in integers where that leaves them open.
pub const DECIDE: Pass = pass!(
    "decide", LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES,
    SHARING, SIGNS, FILTER, OUTCOME, LATTICE, EXACT, RESULTS
);

/// [`DECIDE`] where the host decides what f32 leaves open: about shadows, and pairs within a distance.
pub const CERTIFY: Pass = pass!(
    "certify", LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES,
    SHARING, SIGNS, FILTER, OUTCOME, NEAR, RESULTS
);

/// One hit of each pair of instances, if it is easily found.
pub const DIVE: Pass = pass!(
    "dive", LAYOUT, BINDINGS, INSTANCES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND, PLACE, SOFT,
    WIDE, TRIANGLES, SHARING, SIGNS, FILTER, OUTCOME
);

/// [`EXPAND`] over pairs of instances.
pub const EXPAND_INSTANCES: Pass =
    pass!("expand", LAYOUT, BINDINGS, INSTANCES, TALLIES, NOTHING, GROUP, BOXES, DESCEND);

/// [`NARROW`] over pairs of instances.
pub const NARROW_INSTANCES: Pass = pass!(
    "narrow", LAYOUT, BINDINGS, INSTANCES, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES,
    SHARING, SIGNS, FILTER, STAYING
);

/// [`DECIDE`] over pairs of instances.
pub const DECIDE_INSTANCES: Pass = pass!(
    "decide", LAYOUT, BINDINGS, INSTANCES, TALLIES, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES,
    SHARING, SIGNS, FILTER, OUTCOME, LATTICE, EXACT, RESULTS
);

/// Few hits in order.
pub const ORDER: Pass = pass!("order", LAYOUT, GROUP, RANKING, RANK);

/// Where the buckets of a sort of the hits begin.
pub const SAMPLE: Pass = pass!("sample", LAYOUT, GROUP, RANKING, RANK);

/// Hits by bucket.
pub const DEAL: Pass = pass!("deal", LAYOUT, GROUP, RANKING);

/// Hits in order.
pub const SETTLE: Pass = pass!("settle", LAYOUT, GROUP, RANKING, RANK);

/// Corners of a mesh in the order of its leaves.
pub const GATHER: Pass = pass!("gather", LAYOUT, SOURCE);

/// Boxes and corners of a mesh that has moved.
pub const REFIT: Pass = pass!("refit", LAYOUT, ORDERED, SOURCE, FITTED);

/// How to divide the nodes of a level of a balanced tree.
pub const SURVEY: Pass = pass!("survey", LAYOUT, BALANCED, ORDERED, EXTENT, SOURCE, CUTS);

/// Keys of triangles, to sort them by, and counts of their first digit.
pub const KEYS: Pass = pass!("keys", BALANCED, SORTING, COUNTING, SOURCE, CUTS);

/// Counts of another digit.
pub const COUNT: Pass = pass!("count", BALANCED, SORTING, COUNTING);

/// From counts of a digit to where they begin.
pub const SCAN: Pass = pass!("scan", BALANCED, SORTING, PREFIX);

/// Sorts by one digit.
pub const SCATTER: Pass = pass!("scatter", BALANCED, SORTING, PREFIX);

/// Corners in the order of the leaves of a balanced tree.
pub const ARRANGE: Pass = pass!("arrange", LAYOUT, BALANCED, ORDERED, EXTENT, SOURCE, HALVES);

/// Some levels of a balanced tree.
pub const FIT: Pass = pass!("fit", LAYOUT, BALANCED, ORDERED, SOURCE, FITTED);

/// Whether the adapter rounds as posing needs.
pub const PROBE: Pass = pass!("probe", NOTHING, PLACE, SOFT, WIDE);

/// Every pass.
pub const PASSES: [Pass; 24] = [
    SEED,
    EXPAND,
    NARROW,
    NARROW_DIRECT,
    DECIDE,
    CERTIFY,
    DIVE,
    EXPAND_INSTANCES,
    NARROW_INSTANCES,
    DECIDE_INSTANCES,
    ORDER,
    SAMPLE,
    DEAL,
    SETTLE,
    GATHER,
    REFIT,
    SURVEY,
    KEYS,
    COUNT,
    SCAN,
    SCATTER,
    ARRANGE,
    FIT,
    PROBE,
];
