//! The numbers on which Rust and WGSL must agree, stated once.

use std::fmt::Write;

macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        /// The name and value of each.
        pub const ALL: &[(&str, u32)] = &[$((stringify!($name), $name),)*];
    };
}

constants! {
    /// Invocations of a workgroup, in every pass.
    GROUP = 128;
    /// Node pairs in each half of a workgroup's queue.
    QUEUE = 512;
    /// Node pairs of a front that a workgroup takes at once: below a quarter of [`QUEUE`], so that the
    /// first level cannot overflow it.
    CHUNK = 64;
    /// Leaf pairs that a workgroup gathers before it writes them out.
    FOUND = 512;
    /// Counters of fronts, and so one more than passes in a run.
    FRONTS = 66;
    /// The most triangle pairs of a leaf pair: the core's MAX_LEAF_SIZE squared.
    MOST_PAIRS = 64;
    /// Invocations that share a leaf pair.
    LANES = 16;
    /// Leaf pairs that a workgroup works on at once.
    LEAF_PAIRS = GROUP / LANES;
    /// Triangle pairs that these may give.
    RESULTS = LEAF_PAIRS * MOST_PAIRS;
    /// A leaf in the list of leaf pairs: its first slot below this bit, its triangles less one from it
    /// up.
    LEAF_SHIFT = 28;
    /// A front was too small.
    FRONT_OVERFLOW = 1;
    /// The list of leaf pairs was too small.
    LEAF_OVERFLOW = 2;
    /// The list of hits was too small.
    HIT_OVERFLOW = 4;
    /// The list of undecided triangle pairs was too small.
    UNDECIDED_OVERFLOW = 8;
    /// The list of triangle pairs for the CPU was too small.
    REST_OVERFLOW = 16;
}

/// All of them in WGSL.
pub(crate) fn header() -> String {
    let mut header = String::new();
    for (name, value) in ALL {
        // Writing to a string cannot fail.
        let _ = writeln!(header, "const {name} = {value}u;");
    }
    header
}
