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
    /// The buffers that it uses, of all that its texts declare.
    pub buffers: &'static [&'static str],
}

/// A buffer as WGSL declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Binding {
    /// The index of its bind group.
    pub group: u32,
    /// Its index there.
    pub binding: u32,
    /// Its name.
    pub name: &'static str,
    /// Whether the pass writes it.
    pub access: Access,
}

/// The access of a pass to a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Access {
    /// Parameters.
    Uniform,
    /// Storage that is read.
    Read,
    /// Storage that is read and written.
    ReadWrite,
}

impl Binding {
    /// The buffer that a line declares, which has the form `@group(0) @binding(1) var<storage, read> name: type;`.
    fn declared(line: &'static str) -> Option<Self> {
        let (group, rest) = line.strip_prefix("@group(")?.split_once(") @binding(")?;
        let (binding, rest) = rest.split_once(") var<")?;
        let (space, rest) = rest.split_once("> ")?;
        let (name, _) = rest.split_once(':')?;
        let access = match space {
            "uniform" => Access::Uniform,
            "storage, read" => Access::Read,
            _ => Access::ReadWrite,
        };
        Some(Self { group: group.parse().ok()?, binding: binding.parse().ok()?, name, access })
    }
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

    /// The buffers that it uses. A test of pfront-gpu compares them with what naga finds.
    ///
    /// # Examples
    /// ```
    /// use pfront_shaders::{Access, Binding, GATHER};
    /// let order = Binding { group: 0, binding: 0, name: "order", access: Access::Read };
    /// assert!(GATHER.bindings().any(|binding| binding == order));
    /// ```
    pub fn bindings(self) -> impl Iterator<Item = Binding> {
        let lines = self.parts.iter().flat_map(|part| part.lines());
        lines.filter_map(Binding::declared).filter(move |own| self.buffers.contains(&own.name))
    }

    /// Whether it has an override of this name.
    #[must_use]
    pub fn has_override(&self, name: &str) -> bool {
        let declares = |line: &str| {
            let rest = line.strip_prefix("override ").and_then(|rest| rest.strip_prefix(name));
            rest.is_some_and(|rest| rest.starts_with([':', ' ']))
        };
        self.parts.iter().flat_map(|part| part.lines()).any(declares)
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
    READ_BACK = "parts/read_back";
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
    ($entry:literal, [$($part:ident),*], [$($buffer:ident),*]) => {
        Pass {
            entry: $entry,
            parts: &[$($part,)* include_str!(concat!("../wgsl/passes/", $entry, ".wgsl"))],
            buffers: &[$(stringify!($buffer)),*],
        }
    };
}

/// The first pass of a query: node pairs of one level of both BVHs, and down from there.
pub const SEED: Pass = pass!(
    "seed",
    [LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND],
    [query, counters, leaves, step, front_out, nodes_a, nodes_b, seeds_a, seeds_b]
);

/// One depth-bounded pass from a front.
pub const EXPAND: Pass = pass!(
    "expand",
    [LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND],
    [query, counters, leaves, step, front_in, front_out, nodes_a, nodes_b]
);

/// The triangle pairs of leaf pairs that meet, and those that are left open.
pub const NARROW: Pass = pass!(
    "narrow",
    [
        LAYOUT, BINDINGS, MESHES, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES, SHARING,
        SIGNS, FILTER, STAYING
    ],
    [query, counters, leaves, kept, corners_a, corners_b]
);

/// [`NARROW`] where the host decides the few pairs of two meshes that f32 leaves open, so that nothing is left for [`DECIDE`].
pub const NARROW_DIRECT: Pass = pass!(
    "narrow",
    [
        LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES,
        SHARING, SIGNS, FILTER, RESULTS, DIRECT
    ],
    [query, counters, leaves, hits, rest, corners_a, corners_b, order_a, order_b]
);

/// Triangle pairs decided: in f32, and in integers where that leaves them open.
pub const DECIDE: Pass = pass!(
    "decide",
    [
        LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES, SHARING,
        SIGNS, FILTER, OUTCOME, LATTICE, EXACT, RESULTS
    ],
    [query, counters, hits, kept, rest, corners_a, corners_b, order_a, order_b]
);

/// [`DECIDE`] where the host decides what f32 leaves open: about shadows, and pairs within a distance.
pub const CERTIFY: Pass = pass!(
    "certify",
    [
        LAYOUT, BINDINGS, MESHES, UNTALLIED, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES, SHARING,
        SIGNS, FILTER, OUTCOME, NEAR, RESULTS
    ],
    [query, counters, hits, kept, rest, corners_a, corners_b, order_a, order_b]
);

/// One hit of each pair of instances, if it is easily found.
pub const DIVE: Pass = pass!(
    "dive",
    [
        LAYOUT, BINDINGS, INSTANCES, UNTALLIED, NOTHING, GROUP, BOXES, DESCEND, PLACE, SOFT, WIDE,
        TRIANGLES, SHARING, SIGNS, FILTER, OUTCOME
    ],
    [query, counters, leaves, kept, step, front_in, front_out, nodes_a, corners_a, pairs]
);

/// [`EXPAND`] over pairs of instances.
pub const EXPAND_INSTANCES: Pass = pass!(
    "expand",
    [LAYOUT, BINDINGS, INSTANCES, TALLIES, NOTHING, GROUP, BOXES, DESCEND],
    [query, counters, leaves, step, front_in, front_out, nodes_a, pairs, tallies]
);

/// [`NARROW`] over pairs of instances.
pub const NARROW_INSTANCES: Pass = pass!(
    "narrow",
    [
        LAYOUT, BINDINGS, INSTANCES, NOTHING, GROUP, BOXES, PLACE, SOFT, WIDE, TRIANGLES, SHARING,
        SIGNS, FILTER, STAYING
    ],
    [query, counters, leaves, kept, nodes_a, corners_a, pairs]
);

/// [`DECIDE`] over pairs of instances.
pub const DECIDE_INSTANCES: Pass = pass!(
    "decide",
    [
        LAYOUT, BINDINGS, INSTANCES, TALLIES, NOTHING, GROUP, PLACE, SOFT, WIDE, TRIANGLES,
        SHARING, SIGNS, FILTER, OUTCOME, LATTICE, EXACT, RESULTS
    ],
    [query, counters, hits, kept, rest, corners_a, order_a, pairs, tallies]
);

/// How the second of each pair of instances stands to the first.
pub const POSE: Pass = pass!("pose", [LAYOUT], [bodies, rows, pairs]);

/// The results for the host, hits as they are.
pub const BRING: Pass = pass!(
    "bring",
    [LAYOUT, GROUP, RANKING, READ_BACK],
    [query, counters, hits, rest, read_back, read_back_hits]
);

/// The results for the host, few hits in order.
pub const ORDER: Pass = pass!(
    "order",
    [LAYOUT, GROUP, RANKING, READ_BACK, RANK],
    [query, counters, hits, sorted, rest, read_back, read_back_hits]
);

/// Where the buckets of a sort of the hits begin.
pub const SAMPLE: Pass =
    pass!("sample", [LAYOUT, GROUP, RANKING, RANK], [query, counters, hits, buckets]);

/// Hits by bucket.
pub const DEAL: Pass =
    pass!("deal", [LAYOUT, GROUP, RANKING], [query, counters, hits, kept, buckets]);

/// The results for the host, hits in order.
pub const SETTLE: Pass = pass!(
    "settle",
    [LAYOUT, GROUP, RANKING, READ_BACK, RANK],
    [query, counters, hits, kept, buckets, sorted, rest, read_back, read_back_hits]
);

/// Corners of a mesh in the order of its leaves.
pub const GATHER: Pass = pass!("gather", [LAYOUT, SOURCE], [positions, triangles, order, corners]);

/// Boxes and corners of a mesh that has moved.
pub const REFIT: Pass = pass!(
    "refit",
    [LAYOUT, ORDERED, SOURCE, FITTED],
    [positions, nodes, corners, schedule, rounds, jobs, stage]
);

/// Positions of vertices that are in a buffer of the caller's.
pub const TAKE: Pass = pass!("take", [LAYOUT], [given, taken, outside, taking]);

/// How to divide the nodes of a level of a balanced tree.
pub const SURVEY: Pass = pass!(
    "survey",
    [LAYOUT, BALANCED, ORDERED, EXTENT, SOURCE, CUTS],
    [build, positions, triangles, cuts, entries_in]
);

/// Keys of triangles, to sort them by, and counts of their first digit.
pub const KEYS: Pass = pass!(
    "keys",
    [BALANCED, SORTING, COUNTING, SOURCE, CUTS],
    [build, entries_out, table, positions, triangles, cuts]
);

/// Counts of another digit.
pub const COUNT: Pass = pass!("count", [BALANCED, SORTING, COUNTING], [build, entries_in, table]);

/// From counts of a digit to where they begin.
pub const SCAN: Pass = pass!("scan", [BALANCED, SORTING, PREFIX], [build, table, totals]);

/// Sorts by one digit.
pub const SCATTER: Pass =
    pass!("scatter", [BALANCED, SORTING, PREFIX], [build, entries_in, entries_out, table, totals]);

/// Corners in the order of the leaves of a balanced tree.
pub const ARRANGE: Pass = pass!(
    "arrange",
    [LAYOUT, BALANCED, ORDERED, EXTENT, SOURCE, HALVES],
    [build, positions, triangles, entries_in, corners, order]
);

/// Some levels of a balanced tree.
pub const FIT: Pass =
    pass!("fit", [LAYOUT, BALANCED, ORDERED, SOURCE, FITTED], [build, positions, nodes, corners]);

/// Whether the adapter rounds as posing needs.
pub const PROBE: Pass = pass!("probe", [NOTHING, PLACE, SOFT, WIDE], [trials]);

/// Every pass.
pub const PASSES: [Pass; 27] = [
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
    POSE,
    BRING,
    ORDER,
    SAMPLE,
    DEAL,
    SETTLE,
    GATHER,
    REFIT,
    TAKE,
    SURVEY,
    KEYS,
    COUNT,
    SCAN,
    SCATTER,
    ARRANGE,
    FIT,
    PROBE,
];
