//! The numbers on which Rust and WGSL must agree, stated once.

use std::fmt::Write;

macro_rules! constants {
    ($all:ident: $type:ty; $($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $type = $value;)*

        /// The name and value of each.
        pub const $all: &[(&str, $type)] = &[$((stringify!($name), $name),)*];
    };
}

constants! {
    ALL_FLOATS: f32;
    /// A bound on the roundings of a posed box, relative to its size: 2^-19.
    PADDING = 16.0 * f32::EPSILON;
}

constants! {
    ALL: u32;
    /// Invocations of a workgroup, in every pass.
    GROUP = 128;
    /// Node pairs in each half of a workgroup's queue.
    QUEUE = 512;
    /// Node pairs of a front that a workgroup takes at once: at most a quarter of [`QUEUE`], so
    /// that the first level cannot overflow it.
    CHUNK = 128;
    /// Node pairs that a workgroup follows on each level while it looks for one hit: their children are one for
    /// each invocation.
    BEAM = GROUP / 4;
    /// Leaf pairs that a workgroup gathers before it writes them out. So few leave `seed` and `expand` below 12 KB of workgroup
    /// memory, which bounds how many workgroups run at a time.
    FOUND = 3 * GROUP;
    /// Counters of fronts, and so one more than passes in a run.
    FRONTS = 66;
    /// The most triangles of a leaf: the core's MAX_LEAF_SIZE.
    MOST_LEAF = 8;
    /// Triangle pairs that wait in a workgroup until there is one for each invocation: one more
    /// batch of box tests must fit.
    WAITING = GROUP * (MOST_LEAF + 1);
    /// Triangle pairs that a workgroup gathers of those that it keeps.
    STAY = 2 * GROUP;
    /// This bit of the second slot of a triangle pair says that f32 has proved that it meets: slots stay below 2^[`LEAF_SHIFT`].
    CERTIFIED = 1 << 31;
    /// Invocations that decide a triangle pair in integers.
    TEAM = 8;
    /// Triangle pairs that a workgroup so decides at once.
    TEAMS = GROUP / TEAM;
    /// Triangle pairs that a workgroup gathers before it writes them out.
    RESULTS = 2 * GROUP;
    /// Buckets of the sort of the hits.
    BUCKETS = 1024;
    /// Hits of the sample for each bucket, where the largest bucket might not have room else.
    FINER = 8;
    /// Hits that one dispatch puts in order, comparing each with all others: beyond, three dispatches take less time.
    FEW = 2 * BUCKETS;
    /// Invocations that rank a hit of the sample.
    RANKERS = 8;
    /// Vectors of four words of a triangle pair for the CPU.
    REST_WORDS = 7;
    /// Hits that a bucket can hold.
    BUCKET = 1024;
    /// A leaf in the list of leaf pairs: its first slot below this bit, its triangles less one from
    /// it up.
    LEAF_SHIFT = 28;
    /// A child index in this bit says that there are no children: the node's own index is in the others.
    LEAF = 1 << 31;
    /// Values of a digit of the sort.
    DIGITS = 256;
    /// Bits of a coordinate across a cut, in a key below the node that is divided.
    CUT_BITS = 13;
    /// Bits of a coordinate within a block: three of them fit in a word.
    AXIS_BITS = 10;
    /// Slots for the triangles that a workgroup arranges at once.
    BLOCK = 512;
    /// Boxes that a workgroup keeps while it fits those above them.
    JOB = 512;
    /// A child whose box an earlier dispatch has fitted, in place of its slot among those of a job.
    EARLIER = 0xffff;
    /// Rounds that a workgroup looks for a hit of one pair of instances, depth-first, before it hands on.
    DIVE = 256;
    /// One hit is wanted of each pair of instances.
    ANY_EACH = 1;
    /// The number of hits is wanted of each pair of instances.
    COUNT_EACH = 2;
    /// The pose of a body is not the identity.
    POSED = 1;
    /// A pose and the coordinates that it takes a body to leave room in f32: boxes of the body can be compared in the frame of another.
    IN_RANGE = 2;
    /// Boxes of other bodies can be compared in the frame of a body, too: its pose can be inverted.
    INVERTIBLE = 4;
    /// A front was too small.
    FRONT_OVERFLOW = 1;
    /// The list of leaf pairs was too small.
    LEAF_OVERFLOW = 2;
    /// The list of hits was too small.
    HIT_OVERFLOW = 4;
    /// The list of triangle pairs was too small.
    KEPT_OVERFLOW = 8;
    /// The list of triangle pairs for the CPU was too small.
    REST_OVERFLOW = 16;
    /// A workgroup had more to do than in the rounds it may take.
    WORK_OVERFLOW = 32;
}

/// All of them in WGSL.
pub(crate) fn header() -> String {
    let mut header = String::new();
    for (name, value) in ALL {
        // Writing to a string cannot fail.
        let _ = writeln!(header, "const {name} = {value}u;");
    }
    for (name, value) in ALL_FLOATS {
        // The shortest decimal that rounds to the value.
        let _ = writeln!(header, "const {name} = {value:e}f;");
    }
    header
}
